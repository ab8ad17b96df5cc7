"""What the packages import is declared, what is declared is used, and the lock file holds what that needs and nothing else."""

import ast
import re
import sys
import tomllib
from importlib.metadata import distribution, packages_distributions
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
ROOMS = ("slipwave", "reduced", "fullwave", "validation")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
ENGINES = {"netcdf4"}
"""Loaded by name by a package that is imported (xarray's engine)."""


def plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def imported() -> set[str]:
    """Distributions of all modules that the packages import, ours and Python's own left out."""
    found = set()
    for room in ROOMS:
        for path in (ROOT / room).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Import):
                    found |= {alias.name.partition(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom):
                    found.add(str(node.module).partition(".")[0])
    providers = packages_distributions()
    others = found - set(sys.stdlib_module_names) - {*ROOMS, "tests"}
    return {plain(providers[module][0]) for module in others}


def needed(names: list[str]) -> set[str]:
    """`names` and all that they require here."""
    waiting, found = [Requirement(name) for name in names], set()
    while waiting:
        asked = waiting.pop()
        if plain(asked.name) in found:
            continue
        found.add(plain(asked.name))
        for line in distribution(asked.name).requires or ():
            further = Requirement(line)
            if further.marker is None or any(further.marker.evaluate({"extra": extra}) for extra in ("", *asked.extras)):
                waiting.append(further)
    return found


def test_what_is_imported_is_declared_and_what_is_declared_is_imported() -> None:
    assert {plain(Requirement(line).name) for line in PROJECT["project"]["dependencies"]} == imported() | ENGINES


def test_the_lock_file_holds_all_that_is_needed_and_nothing_else() -> None:
    lines = [line for line in (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines)
    project = PROJECT["project"]
    asked = project["dependencies"] + project["optional-dependencies"]["test"] + PROJECT["build-system"]["requires"]
    assert sorted(plain(line.partition("==")[0]) for line in lines) == sorted(needed(asked))
