"""Numbers that the pages and the help texts give are those of the program.

In a page a number is followed by a comment that the reader does not see, `300<!--validation.run.length.LIMIT-->`: the constant,
or an expression of constants, that it must equal. In a help text every number must be one of `HELP`.
"""

import re
from importlib import import_module

import pytest

from slipwave.sources import ROOT
from validation.cli import COMMANDS, command_called

MARKED = re.compile(r"([\w.+-]+)<!--(.+?)-->")
WORDS = {"eight": 8.0, "sixteen": 16.0}
NUMBER = re.compile(r"(?<![\w.:=-])\d[\d.]*(?:e-?\d+)?(?![\w:]|\.\d)")
HELP = {
    "run --fields": "validation.run.recording.FIELD_WINDOW",
    "run --checkpoint-every": "validation.run.recording._EVERY",
    "orbit --tol": "validation.results.orbit.ORBIT_TOLERANCE",
    "branch --tol": "validation.results.branch.BRANCH_TOLERANCE",
    "branch --most-points": "validation.results.branch.BRANCH_POINTS",
    "curve --tol": "validation.results.branch.BRANCH_TOLERANCE",
    "curve --most-points": "validation.results.curve.CURVE_POINTS",
    "sweep --refine": "2.0",
    "sweep --until": "validation.sweep.measures.TRANSITS",
}
RANGES = {"--cfl": {0.0, 1.0}}
"""Whose ends are refused or taken in `tests/fullwave`."""


def value(expression):
    """Of constants by their full names, and what is computed from them."""

    def constant(name):
        module, _, attribute = name[0].rpartition(".")
        return repr(getattr(import_module(module), attribute))

    return float(eval(re.sub(r"[a-z]\w*(?:\.\w+)+", constant, expression)))


def number(text):
    return WORDS[text] if text in WORDS else float(text)


PAGES = sorted(page for page in (ROOT / "docs").glob("*.md") if MARKED.search(page.read_text(encoding="utf-8")))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_numbers_of_a_page_are_those_of_the_program(page):
    marked = MARKED.findall(page.read_text(encoding="utf-8"))
    assert [(text, name) for text, name in marked if number(text) != pytest.approx(value(name), rel=1e-12)] == []


def test_numbers_of_help_texts_are_those_of_the_program():
    commands = {name: command_called(name) for name in COMMANDS}
    told = {}
    for name, command in commands.items():
        for option in command.params:
            found = {float(text) for text in NUMBER.findall(option.help or "")}
            if found and found != RANGES.get(option.opts[0]):
                told[f"{name} {option.opts[0]}"] = found
    assert told == {key: {value(name)} for key, name in HELP.items()}
