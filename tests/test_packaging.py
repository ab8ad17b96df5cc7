"""What a wheel would hold: every program and every data file of the four rooms."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOMS = ("slipwave", "reduced", "fullwave", "validation")
TOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]
SETUPTOOLS = TOOLS["setuptools"]


def files(room):
    return {path for path in (ROOT / room).rglob("*") if path.is_file() and "__pycache__" not in path.parts}


def test_every_data_file_is_declared():
    for room in ROOMS:
        declared = {path for pattern in SETUPTOOLS["package-data"].get(room, ()) for path in (ROOT / room).glob(pattern)}
        assert {path for path in files(room) if path.suffix != ".py"} == declared


def test_a_clone_is_not_imported_as_an_empty_package(tmp_path):
    """The clone's folder may have the package's name. An editable install that puts the clone on the path is found before it."""
    assert TOOLS["distutils"]["editable_wheel"]["mode"] == "compat"
    (tmp_path / "slipwave").symlink_to(ROOT)
    code = "import slipwave; print(slipwave.__version__ and slipwave.read.__name__)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True
    )
    assert (done.stdout, done.stderr) == ("read\n", "")


def test_every_folder_of_programs_is_a_package():
    assert SETUPTOOLS["packages"]["find"]["include"] == [f"{room}*" for room in ROOMS]
    folders = {path.parent for room in ROOMS for path in files(room) if path.suffix == ".py"}
    assert [folder for folder in folders if not (folder / "__init__.py").exists()] == []
