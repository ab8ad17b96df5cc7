"""The benchmark for other programs: page and table agree, both programs compute a part again, `score.py` counts digits."""

import csv
import re
import subprocess
import sys
from importlib import import_module
from types import SimpleNamespace

import pytest

import slipwave as sw
from slipwave.sources import ROOT

FOLDER = ROOT / "docs" / "benchmark"
with (FOLDER / "benchmark.csv").open(newline="") as stream:
    KNOWN = {row["id"]: (float(row["value"]), float(row["bar"])) for row in csv.DictReader(stream)}


@pytest.fixture(scope="module")
def values():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(FOLDER)
        yield import_module("values")


def astray(found):
    """Names of values that lie outside the bars of the table."""
    return [name for name, value in found if not abs(value - KNOWN[name][0]) <= KNOWN[name][1]]


def test_the_page_and_the_table_are_one():
    page = (ROOT / "docs" / "benchmark.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| ([a-z]\w*\.\S+) \| (\S+) \| (\S+) \|", page, re.M)
    assert {name: (float(value), float(bar)) for name, value, bar in shown} == KNOWN
    points = {name.rpartition(".")[0] for name in KNOWN if name.endswith(".log10_r")}
    assert len(points) == 12


def test_the_second_program_shares_nothing_with_slipwave_and_the_score_needs_nothing():
    def imported_by(name):
        lines = re.findall(r"^(?:import|from) (\S+)", (FOLDER / name).read_text(), re.M)
        return {line.partition(".")[0] for line in lines}

    assert imported_by("second_program.py") == {"collections", "typing", "numpy"}
    assert imported_by("score.py") == {"csv", "math", "sys", "pathlib"}
    assert len((FOLDER / "score.py").read_text().splitlines()) <= 60


@pytest.mark.parametrize("program", ["psi_of", "psi_of_second"])
def test_psi_after_each_start_is_that_of_both_programs(program, values, monkeypatch):
    """At the times up to 40 transits."""
    short = {name: (*start, tuple(t for t in times if t <= 40.0)) for name, (*start, times) in values.STARTS.items()}
    monkeypatch.setattr(values, "STARTS", short)
    found = [pair for start in short for pair in getattr(values, program)(start)]
    assert len(found) == 7
    assert astray(found) == []


def test_the_onset_is_that_of_the_closed_form(values):
    assert astray(zip(("onset.log10_r", "onset.period"), values.other.onset(), strict=True)) == []


@pytest.mark.slow
def test_orbit_and_multipliers_are_those_of_both_programs(values, monkeypatch):
    monkeypatch.setattr(values, "STARTS", {})
    orbit = sw.orbit("paper", model="delay", tol=1e-11)
    onset = {"onset": SimpleNamespace(log10_r=KNOWN["onset.log10_r"][0], period=KNOWN["onset.period"][0])}
    for program in (values.by_slipwave, values.by_second):
        found = list(program(orbit, onset))
        assert len(found) == 10
        assert astray(found) == []


@pytest.fixture
def score(tmp_path):
    """Status and output of `score.py` on a table, in a process that sees no packages."""

    def scored(text, *digits):
        path = tmp_path / "theirs.csv"
        path.write_text(text, encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-I", "-S", FOLDER / "score.py", path, *digits], capture_output=True, text=True, cwd=tmp_path
        )
        return done.returncode, done.stdout, done.stderr

    return scored


THEIRS = "id,value\norbit.period,73.4721\norbit.v_max,4413\nfold.1.log10_r,-2.7002517033056\n"


def test_score_says_how_many_digits_are_right(score):
    """|4413/4412.32 - 1| is 1.5e-4: three digits; 73.4721 is off by 6e-7: six. Bars of 1e-12 leave twelve."""
    status, said, _ = score(THEIRS, "3")
    assert status == 0
    digits = {line.split()[0]: line.split()[2:5] for line in said.splitlines()[:-1]}
    assert digits == {
        "orbit.period": ["6", "of", "12"],
        "orbit.v_max": ["3", "of", "12"],
        "fold.1.log10_r": ["12", "of", "12"],
    }
    assert said.endswith("3 of 3 rows have 3 digits right, or all in which the two programs agree\n")
    status, said, _ = score(THEIRS + "fold.1.perod,59.1\n")
    assert status == 3
    assert "is not in the benchmark\n2 of 4 rows have 6 digits right" in said


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name,value\na,1\n", "line 1: must be id,value"),
        ("id,value\norbit.period,x\n", "line 2: x is no number"),
        ("id,value\norbit.period,73.4721\norbit.v_max,nan\n", "line 3: nan is no number"),
        ('id,value\norbit.period,"73,4721"\n', "line 2: 73,4721 is no number"),
        ("id,value\norbit.period,73,4721\n", "line 2: must be an id and one number, with a decimal point and no comma"),
        ("id,value\n\norbit.period,1\norbit.period,2\n", "line 4: orbit.period is there twice"),
        ("id,value\n", "no row"),
    ],
)
def test_wrong_tables_are_refused_with_their_line(text, told, score):
    status, said, error = score(text)
    assert (status, said) == (2, "")
    assert error.endswith(f": {told}\n")
    assert error.count("\n") == 1
