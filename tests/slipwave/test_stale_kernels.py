"""Compiled code is never older than any file it was made from, and a user's own numba code keeps its cache where it was."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from slipwave.sources import ROOT

KERNEL = "from slipwave.compiled import njit\n{imports}@njit\ndef {name}(x):\n    return {value}\n"
CHAIN = {
    "near": KERNEL.format(imports="from slipwave.between import between\n", name="near", value="between(x)"),
    "between": KERNEL.format(imports="from slipwave.far import far\n", name="between", value="far(x)"),
    "far": KERNEL.format(imports="", name="far", value="2.0 * x"),
}
ASK = "from slipwave.near import near; print(near(1.0), sum(near.stats.cache_hits.values()))"
OWN = """
import numba
before = numba.config.CACHE_DIR
import slipwave.observe
import own
print(numba.config.CACHE_DIR == before, own.own(1.0), any(own.own.stats.cache_misses.values()))
"""


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """A copy of the ground room with a kernel that calls one that calls another, each in a file of its own."""
    shutil.copytree(ROOT / "slipwave", tmp_path / "slipwave", ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in CHAIN.items():
        (tmp_path / "slipwave" / f"{name}.py").write_text(text)
    return tmp_path


def asked(house: Path, program: str = ASK) -> str:
    """What a process of its own prints, whose house is `house`."""
    environment = os.environ | {"PYTHONPATH": str(house), "XDG_CACHE_HOME": str(house / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run([sys.executable, "-c", program], env=environment, cwd=house, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_an_edit_two_imports_away_compiles_the_kernel_anew(house: Path) -> None:
    assert [asked(house), asked(house)] == ["2.0 0\n", "2.0 1\n"]
    far = house / "slipwave" / "far.py"
    far.write_text("# a comment\n" + far.read_text())
    assert asked(house) == "2.0 1\n"
    far.write_text(far.read_text().replace("2.0", "3.0"))
    assert [asked(house), asked(house)] == ["3.0 0\n", "3.0 1\n"]


def test_the_cache_of_a_users_own_functions_stays_where_it_was(house: Path) -> None:
    (house / "own.py").write_text("import numba\n@numba.njit(cache=True)\ndef own(x):\n    return x + 1.0\n")
    assert asked(house, OWN) == "True 2.0 True\n"
    assert [path.suffix for path in sorted((house / "__pycache__").glob("own*"))] == [".nbc", ".nbi"]
