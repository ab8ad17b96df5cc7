"""The pages that show commands are followed word by word: files are written, commands and programs run, and what a page shows of
their output is what they print."""

import contextlib
import io
import re
import shlex
from pathlib import Path

import pytest

import slipwave
from slipwave.input.source import parse_toml
from slipwave.sources import ROOT
from validation.cli import main

BLOCK = re.compile(r"```(\w*)\n(.*?)```", re.S)
FILE = re.compile(r"Write `([^`]+)`:\s*$")
PAGES = (
    "laboratory.md",
    "fit.md",
    "notebook.md",
    "output-files.md",
    "own-slab.md",
    "protocols.md",
    "testing-machine.md",
    "troubleshooting.md",
    "unlike-slabs.md",
    "verify.md",
    "benchmark.md",
)
LONG = ("first-sample.md",)


def steps(page):
    """(kind, content, words before) of every block."""
    words, *rest = BLOCK.split((ROOT / "docs" / page).read_text(encoding="utf-8"))
    return list(zip(rest[::3], rest[1::3], [words, *rest[2::3]], strict=False))


def printed_by(kind, content, names):
    """What the lines of a shell block, or a program, print."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        if kind == "python":
            exec(content, names)
        else:
            for line in content.splitlines():
                program, *arguments = shlex.split(line, comments=True)
                assert program == "slipwave"
                main(arguments)
    return out.getvalue()


@pytest.mark.parametrize("page", [*PAGES, *(pytest.param(page, marks=pytest.mark.slow) for page in LONG)])
def test_a_page_does_what_it_says(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    printed, shown = "", 0
    for kind, content, words in steps(page):
        if found := FILE.search(" ".join(words.split())):
            Path(found[1]).write_text(content)
        elif kind in ("sh", "python"):
            printed = printed_by(kind, content, names)
        elif kind == "text":
            lines = printed.splitlines()
            assert [line for line in content.splitlines() if line not in ("...", *lines)] == [], printed
            shown += 1
    assert shown


def test_every_page_with_commands_is_followed():
    pages = {path.name for path in (ROOT / "docs").glob("*.md") if "```sh\nslipwave" in path.read_text(encoding="utf-8")}
    assert pages - {"extending.md", "reading-the-report.md"} <= {*PAGES, *LONG}


def test_the_machine_of_a_data_sheet_is_that_of_the_gallery():
    (table,) = [content for kind, content, _ in steps("testing-machine.md") if kind == "toml"]
    given = parse_toml(table)["upper"]["face"]
    assert slipwave.read("steel-on-pmma", {"upper.face": given}).upper == slipwave.read("steel-on-pmma").upper
