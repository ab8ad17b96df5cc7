"""The tests with the oldest packages that pyproject.toml allows, in an environment of their own.

    python -m tests.oldest

Everything is downloaded; what these packages need in turn is as new as they allow.
"""

import os
import subprocess
import sys
import tempfile
import tomllib
import venv
from itertools import chain
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
OF_THE_LINTERS = {"ruff", "mypy", "scipy-stubs"}
OF_THE_LOCK = "tests/test_dependencies.py::test_the_lock_file_holds_all_that_is_needed_and_nothing_else"


def oldest():
    """Every package that is declared, at the lowest version that it may have."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    wanted = map(Requirement, chain(project["dependencies"], *(extras[name] for name in extras if name != "bench")))
    return sorted(
        f"{one.name}=={next(iter(one.specifier)).version}" for one in wanted if one.specifier and one.name not in OF_THE_LINTERS
    )


def main():
    """Install them, and slipwave without further ones; exit status of the tests."""
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        python = Path(folder) / "bin" / "python"
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, *oldest(), "setuptools>=77"], check=True)
        subprocess.run([*pip, "--no-deps", "--no-build-isolation", "--editable", ROOT], check=True)
        tests = [python, "-m", "pytest", "-m", "not slow and not studies", "-n", "2", "--deselect", OF_THE_LOCK]
        # newer packages warn older ones, also in tests that start further ones
        return subprocess.run(tests, cwd=ROOT, env=os.environ | {"PYTEST_ADDOPTS": "-W default"}).returncode


if __name__ == "__main__":
    sys.exit(main())
