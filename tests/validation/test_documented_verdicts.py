"""docs/what-a-run-says.md has a row for every verdict and every key of the JSON, and no others."""

import json
import re
from pathlib import Path
from typing import get_args

from slipwave.observe.verdict import REPEATING, Kind

PAGE = (Path(__file__).parents[2] / "docs" / "what-a-run-says.md").read_text(encoding="utf-8")


def rows(heading):
    """Cells of the first table below a heading."""
    lines = PAGE.partition(f"## {heading}\n")[2].partition("\n## ")[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| `")]


def test_every_verdict_has_a_row_that_says_whether_it_has_means():
    found = {row[0].strip("`"): row[2] for row in rows("The verdict")}
    assert set(found) == set(get_args(Kind))
    assert {kind for kind, means in found.items() if means != "none"} == set(REPEATING)


def test_every_key_has_a_row(printed):
    """Of a run on a default grid that rounding has a share in, so that `grid` and `notes` are there."""
    printed = set(json.loads(printed("run", "paper", "--model", "dg:7", "--until", "10", "--json", "--set", "slab.r=0.1")))
    documented = {key for row in rows("The JSON of `run --json`") for key in re.findall("`(\\w+)`", row[0])}
    assert documented == printed | {"failed", "si", "left_out", "lyapunov", "protocol"}
