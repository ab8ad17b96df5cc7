"""Red means red: a failing verdict, a number off its baseline or a broken study ends the command with status 3, and says so."""

import json
import math
import os
import re
import subprocess
from pathlib import Path

import pytest
from fake_studies import result

from validation.cli import NUMERICS_FAILED, main
from validation.report import baseline
from validation.report.baseline import RedReport
from validation.report.build import make_report
from validation.report.record import Word
from validation.report.recorded import read_report
from validation.study import Evidence, Number, Outcome, StudyResult, Verdict

ROOT = Path(__file__).parents[2]


def failing(claim):
    return Verdict(claim, Evidence.EXACT, "below 10^{-9}", "3 · 10^{-4}", Outcome.FAIL, "at `r`\n= 1")


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """The folder of the baseline, for this test only."""
    monkeypatch.setattr(baseline, "FOLDER", tmp_path / "baseline")
    return tmp_path / "baseline"


def told(page):
    """The numbers at the page's head: what holds, findings, fails, studies that did not finish."""
    head = re.search(r'<p class="tally">(.*?)</p>', page.read_text())[1]
    return [int(number) for number in re.findall(r"(\d+) (?:hold|finding|fail|stud)", head)]


def test_every_reason_has_its_line(fake, kept, tmp_path, capsys):
    out = tmp_path / "out"
    values = [73.0, 5.0]

    def measured(budget):
        return StudyResult("", numbers={"T_{1}": Number(values[0], 1e-6), "v": Number(values[1], 1e-3)})

    fake.add("first", measured)
    make_report(out)
    baseline.take(out)
    fake.add(
        "second", lambda budget: StudyResult("", verdicts=(failing("Waves *stay*"), *result().verdicts, failing("Grips hold")))
    )
    fake.add("third", lambda budget: 1 / 0)
    values[:] = 73.0001, 5.004
    (out / "data" / "first" / "result.json").unlink()
    capsys.readouterr()
    assert main(["report", "--out", str(out)]) == NUMERICS_FAILED == 3
    said = capsys.readouterr()
    assert said.out == f"{out / 'index.html'}\n"
    *lines, last = said.err.splitlines()[-5:]
    assert lines[0] == "first: T1: expected 73 ± 7.3e-05, found 73.0001"
    assert lines[1:3] == [
        "second: Waves stay: expected below 10^-9, found 3 · 10^-4 (at r = 1)",
        "second: Grips hold: expected below 10^-9, found 3 · 10^-4 (at r = 1)",
    ]
    assert re.fullmatch(
        r"third: failed: ZeroDivisionError: division by zero \(test_red_report.py, line \d+, in <lambda>\)", lines[3]
    )
    assert last == f"slipwave: the report is red for 4 reasons: see {out / 'index.html'}"
    assert told(out / "index.html") == [2, 1, 2, 1]


def test_a_stored_failure_stays_red(fake, kept, tmp_path):
    """Also where only another study was asked for."""
    fake.add("first", lambda budget: StudyResult("", verdicts=(failing("Waves stay"),)))
    fake.add("second")
    for words in ([], ["--only", "second"], []):
        assert main(["report", "--out", str(tmp_path), *words]) == 3
    assert fake.runs == ["first", "second"]


@pytest.mark.parametrize(
    ("before", "now", "moves"),
    [
        (math.nan, math.nan, False),
        (math.nan, 1.0, True),
        (1.0, math.nan, True),
        (math.inf, math.inf, False),
        (math.inf, 1.0, True),
        (1.0, math.inf, True),
        (1.0, 1.0 + 2e-6, True),
        (1.0, 1.0 - 2e-6, True),
        (-1.0, -1.0 - 0.9e-6, False),
        (0.0, 0.0, False),
    ],
)
def test_a_number_that_comes_or_goes_has_moved(fake, kept, tmp_path, before, now, moves):
    """By more than its tolerance, 1e-6 of the larger one; a baseline holds numbers that JSON lacks too."""
    numbers = {"T": Number(before)}
    fake.add("first", lambda budget: StudyResult("", numbers=numbers))
    make_report(tmp_path)
    baseline.take(tmp_path)
    (tmp_path / "data/first/result.json").unlink()
    numbers["T"] = Number(now)
    assert main(["report", "--out", str(tmp_path)]) == 3 * moves
    assert [change.name for change in read_report(tmp_path).changes.of(Word.MOVED)] == ["T"] * moves
    assert (tmp_path / "baseline.patch").exists() == moves


def test_the_page_tells_what_moved_since_the_baseline(fake, kept, tmp_path):
    """What a quick report leaves out is no change, and a new number is not red."""
    numbers = {"T": Number(73.0), "order": Number(2.0)}

    def measured(budget):
        return StudyResult("", numbers={name: n for name, n in numbers.items() if not budget.quick or name == "T"})

    fake.add("first", measured)
    assert "the committed baseline: 2 new." in make_report(tmp_path / "full").read_text()
    (written,) = baseline.take(tmp_path / "full")
    assert json.loads(written.read_text())["T"] == {"value": 73.0, "tolerance": 1e-6}
    assert main(["report", "--out", str(tmp_path / "again")]) == 0
    assert told(tmp_path / "again" / "index.html") == [0, 0, 0]
    assert "0 of 2 numbers moved since the committed baseline" in (tmp_path / "again" / "index.html").read_text()
    assert "0 of 1 numbers moved" in make_report(tmp_path / "quick", quick=True).read_text()
    numbers |= {"T": Number(73.001), "new": Number(3.0)}
    del numbers["order"]
    with pytest.raises(RedReport) as red:
        make_report(tmp_path / "moved")
    assert red.value.lines == ["first: order: expected 2, found none", "first: T: expected 73 ± 7.3e-05, found 73.001"]
    html = red.value.page.read_text()
    assert "2 of 2 numbers moved since the committed baseline, 1 new." in html
    assert '<td class="n">73</td><td class="n">73.001</td>' in html
    assert '<td class="n">–</td><td class="n">3</td>' in html


@pytest.mark.parametrize(("status", "ends"), [(0, 0), (3, 3)])
def test_ci_runs_the_tests_and_the_report_and_goes_red_with_it(tmp_path, status, ends):
    make = tmp_path / "make"
    make.write_text(f'#!/bin/sh\necho "$@" >> {tmp_path}/asked\n[ "$1" != report ] || exit {status}\n')
    make.chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run([ROOT / ".ci" / "run"], env=os.environ | {"PATH": path}, check=False)
    assert done.returncode == ends
    assert {"test", "report QUICK=1"} <= set((tmp_path / "asked").read_text().splitlines())


def test_make_hands_the_status_on(tmp_path):
    """`make report` runs slipwave bare: what it ends with ends make."""
    rule = subprocess.run(
        ["make", "--no-print-directory", "--dry-run", "report", "QUICK=1"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert rule.stdout.splitlines()[-1] == ".venv/bin/slipwave report --quick"
