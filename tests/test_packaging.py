"""What a wheel would hold: every program and every data file of the four rooms."""

import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOMS = ("slipwave", "reduced", "fullwave", "validation")
SETUPTOOLS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def files(room):
    return {path for path in (ROOT / room).rglob("*") if path.is_file() and "__pycache__" not in path.parts}


def test_every_data_file_is_declared():
    for room in ROOMS:
        declared = {path for pattern in SETUPTOOLS["package-data"].get(room, ()) for path in (ROOT / room).glob(pattern)}
        assert {path for path in files(room) if path.suffix != ".py"} == declared


def test_every_folder_of_programs_is_a_package():
    assert SETUPTOOLS["packages"]["find"]["include"] == [f"{room}*" for room in ROOMS]
    folders = {path.parent for room in ROOMS for path in files(room) if path.suffix == ".py"}
    assert [folder for folder in folders if not (folder / "__init__.py").exists()] == []
