"""The walk of a run (docs/design.md): the files whose functions `slipwave run paper` calls, by a trace."""

import re
import sys

import pytest

from slipwave.sources import ROOT
from validation.cli import main

ROOMS = ("validation", "reduced", "fullwave", "slipwave")


def our_file(frame):
    """The file of a function of ours, relative to the checkout; empty for any other."""
    name = frame.f_code.co_filename.removeprefix(f"{ROOT}/")
    return name if name.startswith(ROOMS) else ""


def is_import(frame):
    while frame is not None and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None


@pytest.fixture
def calls(capsys):
    """(file that calls, file that is called) of a run from the command line to the printed table."""
    found = set()

    def note(frame, event, argument):
        called = our_file(frame) if event == "call" else ""
        if called and not is_import(frame):
            caller = frame.f_back
            while caller is not None and not our_file(caller):
                caller = caller.f_back
            found.add((our_file(caller) if caller else "", called))

    assert main(["run", "paper"]) == 0  # what is compiled is loaded from the disk
    sys.setprofile(note)
    try:
        assert main(["run", "paper"]) == 0
    finally:
        sys.setprofile(None)
    return {(caller, called) for caller, called in found if caller != called}


def test_the_walk_is_no_longer_than_it_is_written(calls):
    section = (ROOT / "docs" / "design.md").read_text(encoding="utf-8").partition("## The walk of a run")[2].partition("\n## ")[0]
    touched = {called for _, called in calls}
    listed = set(re.findall(r"`((?:validation|slipwave|reduced)/[\w/]+\.py)`", section))
    assert {file for file in touched if file.startswith("validation/")} <= listed <= touched
    most, ours, onwards = (int(number) for number in re.findall(r"\*\*(\d+)\*\*", section))
    assert len(touched) <= most
    assert sum(file.startswith("validation/") for file in touched) <= ours
    assert len({caller for caller, _ in calls} - {""}) <= onwards


def test_the_walk_climbs_back_at_most_three_times(calls):
    assert len({pair for pair in calls if not pair[0].startswith("validation/") and pair[0] and pair[1].startswith("valid")}) <= 3
