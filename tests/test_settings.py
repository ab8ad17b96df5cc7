"""A setting is changed on purpose or not at all: those of the four rooms have the values in `settings.txt`.

What a value does is for the tests of its module to say. Many are choices (a grid, a limit on work, a number of repeats) whose
neighbours would do as well: their only right value is the one that was decided on.
"""

from importlib import import_module
from pathlib import Path

import pytest

from slipwave.sources import ROOT
from tests.settings import settings_of

RECORD = Path(__file__).with_name("settings.txt")
ROOMS = ("slipwave", "reduced", "fullwave", "validation")


def settings() -> list[str]:
    files = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__") for path in files]
    return [line for name in names for line in settings_of(import_module(name))]


def test_settings_are_as_recorded(request: pytest.FixtureRequest) -> None:
    lines = settings()
    if request.config.getoption("record_shown"):
        RECORD.write_text("\n".join([*lines, ""]), encoding="utf-8")
    recorded = RECORD.read_text(encoding="utf-8").splitlines()
    differ = [f"- {line}" for line in recorded if line not in lines] + [f"+ {line}" for line in lines if line not in recorded]
    assert not differ, "\n".join([*differ, "meant? pytest tests/test_settings.py --record-shown"])
