"""The files beside the page, and what turns a report red: failing verdicts, moved numbers, broken studies, each with its line."""

import csv
import io
import json
import math
import os
import re
import subprocess
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree as xml

import pytest
from fake_studies import answered, draw, result
from test_page import models

from tests.validation.without_times import lasting_digest
from validation.commands.cli import NUMERICS_FAILED, main
from validation.report import (
    EXACT,
    Column,
    Evidence,
    Figure,
    Number,
    Outcome,
    Table,
    Verdict,
    baseline,
    claim,
    holding,
    stated,
    table,
)
from validation.report.build import make_report
from validation.report.record import read_report, report_schema, text_of

ROOT = Path(__file__).parents[3]


@pytest.fixture
def changing(fake, tmp_path, monkeypatch):
    """A study whose result a test changes, its report in `out`, and a baseline of this test's own."""
    monkeypatch.setattr(baseline, "FOLDER", tmp_path / "baseline")
    kept, out = {"result": result()}, tmp_path / "out"
    fake.add("first", lambda budget: kept["result"])

    def report(*words, now=None):
        """The exit status of `slipwave report`, computed again if the study's result is `now`."""
        if now is not None:
            kept["result"] = now
            (out / "data/first/result.json").unlink(missing_ok=True)
        return main(["report", "--out", str(out), *words])

    return SimpleNamespace(out=out, report=report, record=lambda: read_report(out))


def found(size, limit=1e-6, title="Waves stay"):
    return claim(title, EXACT, size, limit)


def in_words(ours):
    return Verdict("It slides", EXACT, "it does", ours, Outcome.PASS)


def test_report_json_says_all_and_comes_back(changing, capsys):
    assert changing.report("--json") == 0
    text = (changing.out / "report.json").read_text()
    assert capsys.readouterr().out == text == text_of(changing.record())
    told = json.loads(text)
    assert told["outcomes"] == {"pass": 2, "finding": 1, "fail": 0, "not decided": 0, "broken": 0}
    assert [(one["outcome"], one["ours"]) for one in told["verdicts"]] == [("pass", "73.48"), ("finding", "80"), ("pass", "73.5")]
    assert len({one["id"] for one in told["verdicts"]}) == 3
    void = {"id": "first.void", "study": "first", "name": "void", "value": "NaN", "tolerance": 1e-6}
    assert told["numbers"][1] == void | {"known": None, "known_within": 0.0}
    assert math.isnan(changing.record().numbers[1].value)
    assert [file for one in told["figures"] for file in one["files"] if not (changing.out / file).exists()] == []


LOCKED = re.search(r"^pydantic==(.+)$", (ROOT / "requirements.lock").read_text(), re.MULTILINE)


@pytest.mark.skipif(LOCKED is None or version("pydantic") != LOCKED[1], reason="other words of another pydantic")
def test_the_published_schema_is_that_of_the_classes():
    assert json.loads((ROOT / "docs/report.schema.json").read_text()) == json.loads(json.dumps(report_schema()))


def test_every_verdict_and_number_is_a_case_of_junit(changing):
    verdicts = (found(1e-9), found(3e-6, title="Grips hold \x1b & <go>"), *result().verdicts)
    make_report(changing.out)
    baseline.take(changing.out)
    assert changing.report(now=answered(verdicts=verdicts, numbers={"T": Number(74.0), "new": Number(1.0)})) == 3
    (suite,) = xml.parse(changing.out / "junit.xml").getroot()
    assert [suite.get(name) for name in ("name", "tests", "failures", "errors")] == ["first", "8", "3", "0"]
    failed = {case.get("name"): case.find("failure").get("message") for case in suite if case.find("failure") is not None}
    assert list(failed.values()) == [
        "Grips hold ? & <go>: expected below 1 · 10^−6, found 3 · 10^−6",
        "first: T: expected 73.4721449 ± 7.4e-05, found 74",
        "first: void: expected nan, found none",
    ]
    assert list(failed)[1:] == ["number T", "number void"]
    findings = [case for case in suite if (case.findtext("system-out") or "").startswith("finding")]
    assert [case.find("failure") for case in findings] == [None]


def test_a_table_as_csv_has_every_digit_and_no_heading_twice():
    heading = [("model", ""), ("T", "transits"), ("error", "relative"), ("Δμ", "σ"), ("error", "relative"), ("error", "relative")]
    columns = [Column(title, unit) for title, unit in heading]
    rows = [("`dg:7`, r_{c}", 73.47214494429114, None, 1e-300, math.nan, 3)]
    csv.writer(text := io.StringIO()).writerows(Table("", tuple(columns), tuple(rows)).sheet)
    head, row = csv.reader(io.StringIO(text.getvalue()))
    assert head == [
        "model",
        "T [transits]",
        "T [transits]: error [relative]",
        "Δμ [σ]",
        *(f"Δμ [σ]: error [relative]{n}" for n in ("", " 2")),
    ]
    assert row == ["dg:7, rc", "73.47214494429114", "", "1e-300", "nan", "3"]


def test_the_patch_gives_the_baseline_that_take_would_write(changing, tmp_path):
    """Numbers that moved, came and went; of a study whose numbers have not moved the baseline stays byte for byte."""
    place = tmp_path / "checkout/reports/baseline"
    place.mkdir(parents=True)
    changing.report()
    baseline.take(changing.out)
    committed = (baseline.FOLDER / "first.json").read_text()
    (place / "first.json").write_text(committed)
    assert changing.report(now=answered(numbers={"T": Number(73.0, 1e-7), "λ_{1}": Number(math.inf)})) == 3
    subprocess.run(["git", "init", "-q"], cwd=tmp_path / "checkout", check=True)
    subprocess.run(["git", "apply", changing.out / "baseline.patch"], cwd=tmp_path / "checkout", check=True)
    baseline.take(changing.out)
    assert (place / "first.json").read_text() == (baseline.FOLDER / "first.json").read_text() != committed
    assert changing.report() == 0
    assert not (changing.out / "baseline.patch").exists()


@pytest.mark.parametrize(
    ("before", "now", "word", "status"),
    [
        (found(5e-7), found(1e-7), "better", 0),
        (found(1e-7), found(5e-7), "worse", 3),
        (found(1.0e-7), found(1.9e-7), "same", 0),
        (found(5e-7), found(2e-6), "worse", 3),
        (found(5e-7), found(5e-7, title="Others stay"), "new", 0),
        (Number(73.0, 1e-6), Number(73.00002, 1e-9), "same", 0),
        (Number(73.0, 1e-9), Number(73.001, 1e-9), "moved", 0),
        (stated(0.0, 1e-12), stated(5.0, 1e-12), "moved", 0),
        (stated(0.0, 1e-12), stated(1.9e-12, 1e-12), "same", 0),
        (Number(73.0, 1e-9, known=72.0), Number(72.5, 1e-9, known=72.0), "better", 0),
        (Number(72.5, 1e-9, known=72.0), Number(math.nan, 1e-9, known=72.0), "worse", 3),
        (in_words("yes"), in_words("so"), "not comparable", 0),
        (in_words("2").with_margin(2.0, 9.0, "of times"), in_words("8").with_margin(8.0, 9.0, "of times"), "not comparable", 0),
    ],
)
def test_against_an_earlier_report(changing, tmp_path, capsys, before, now, word, status):
    def of(one):
        return answered(numbers={"T": one}) if isinstance(one, Number) else answered(verdicts=(one,))

    changing.report(now=of(before))
    changing.out.rename(tmp_path / "earlier")
    changing.report(now=of(now))
    capsys.readouterr()
    assert changing.report("--against", str(tmp_path / "earlier")) == max(status, 3 * (now == found(2e-6)))
    said = capsys.readouterr().out.splitlines()
    changes = changing.record().changes
    assert changes.counts.get(word) == 1
    assert [change.word for change in changes.listed][:1] == [word] * (word != "same")
    assert f"1 {word}" in said[1]
    shown = [line.removeprefix("first: ").split()[1:] for line in said[3:]]
    assert len(shown) == sum(change.word != "not comparable" for change in changes.listed)
    assert [word in words for words in shown[:1]] == [True] * len(shown[:1])


@pytest.mark.parametrize(
    ("text", "why"),
    [(None, "no such file"), ("{", "is no report.json of format 1"), ('{"format": 2}', "is no report.json of format 1")],
)
def test_what_is_no_report_is_refused_before_anything_runs(fake, tmp_path, capsys, text, why):
    fake.add("first")
    if text is not None:
        (tmp_path / "report.json").write_text(text)
    assert main(["report", "--out", str(tmp_path / "out"), "--against", str(tmp_path / "report.json")]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"slipwave: --against = '{tmp_path / 'report.json'}': ")
    assert why in said
    assert said.count("\n") == 1
    assert fake.runs == []
    assert not (tmp_path / "out").exists()


def test_a_table_of_models_is_a_line_for_each_number(changing):
    changing.report(now=answered(model_tables=(models(),)))
    (record,) = changing.record().model_tables
    assert record.table == models()
    lines = [*csv.DictReader(io.StringIO((changing.out / record.csv).read_text()))]
    names = ("model", "log10_r", "regime", "quantity", "value", "error", "cost", "advice")
    told = [",".join(line[name] for name in names) for line in lines]
    assert told[0] == "delay,-2.7,periodic,T,70.0,,,use"
    assert told[6:] == [
        "quasidynamic,-2.7,slides steadily,,,,,avoid",
        "quasidynamic,-2.6,slides steadily,,,,0.05,avoid",
        "quasidynamic,-2.5,periodic,T,43.2,-0.4,,avoid",
        "quasidynamic,-2.5,periodic,Δμ,0.21,0.05,,avoid",
    ]


def test_two_reports_are_the_same_but_for_run_times(changing, tmp_path):
    """Times in a column, in words and in a figure change; a value and a figure without times change too."""

    def told(seconds, value):
        columns, rows = "model | run [ms] .0f | T .9g", [("delay", seconds, value)]
        verdicts = (holding("It is fast", EXACT, "1 s", f"~{{{seconds} s}}", seconds < 9.0),)
        figures = (Figure("cost", "Costs.", lambda: draw(seconds), timed=True), Figure("cycle", "A cycle.", lambda: draw(value)))
        answer = f"It takes ~{{{seconds} s}}."
        tables = (table("costs", "Costs.", columns, rows),)
        return answered(answer, verdicts, tables=tables, figures=figures, numbers={"T": Number(value)})

    digests = []
    for seconds, value in ((1.0, 73.0), (2.0, 73.0), (3.0, 73.0), (2.0, 74.0)):
        changing.report(now=told(seconds, value))
        assert "time" in (changing.out / "index.html").read_text()
        digests.append(lasting_digest(changing.out))
        changing.out.rename(tmp_path / str(len(digests)))
    assert len(set(digests[:3])) == 1
    assert digests[3] != digests[0]


def failing(claim):
    return Verdict(claim, Evidence.EXACT, "below 10^{-9}", "3 · 10^{-4}", Outcome.FAIL, "at `r`\n= 1")


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """The folder of the baseline, for this test only."""
    monkeypatch.setattr(baseline, "FOLDER", tmp_path / "baseline")
    return tmp_path / "baseline"


def tally(out):
    """The numbers at the page's head: what holds, findings, fails, studies that did not finish."""
    head = re.search(r'<p class="tally">(.*?)</p>', (out / "index.html").read_text())[1]
    return [int(number) for number in re.findall(r"(\d+) (?:hold|finding|fail|stud)", head)]


def test_every_reason_has_its_line(fake, kept, tmp_path, capsys):
    out = tmp_path / "out"
    values = [73.0, 5.0]

    def measured(budget):
        return answered(numbers={"T_{1}": Number(values[0], 1e-6), "v": Number(values[1], 1e-3)})

    fake.add("first", measured)
    make_report(out)
    baseline.take(out)
    fake.add("second", lambda budget: answered(verdicts=(failing("Waves *stay*"), *result().verdicts, failing("Grips hold"))))
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
        r"third: failed: ZeroDivisionError: division by zero \(test_report_files.py, line \d+, in <lambda>\)", lines[3]
    )
    assert last == f"slipwave: the report is red for 4 reasons: see {out / 'index.html'}"
    assert tally(out) == [2, 1, 2, 1]
    (error,) = xml.parse(out / "junit.xml").getroot().iter("error")
    assert error.get("message") == lines[3].removeprefix("third: failed: ")
    assert xml.parse(out / "badge.svg").getroot().get("aria-label") == "slipwave: 2 hold, 1 findings, 4 red"


def test_a_stored_failure_stays_red(fake, kept, tmp_path):
    fake.add("first", lambda budget: answered(verdicts=(failing("Waves stay"),)))
    fake.add("second")
    for words in ([], ["--only", "second"], []):
        assert main(["report", "--out", str(tmp_path), *words]) == 3
    assert fake.runs == ["first", "second"]


@pytest.mark.parametrize(("status", "ends"), [(0, 0), (3, 3)])
def test_ci_runs_the_tests_and_the_report_and_goes_red_with_it(tmp_path, status, ends):
    make = tmp_path / "make"
    make.write_text(f'#!/bin/sh\necho "$@" >> {tmp_path}/asked\n[ "$1" != report ] || exit {status}\n')
    make.chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run([ROOT / ".ci" / "run"], env=os.environ | {"PATH": path}, check=False)
    assert done.returncode == ends
    assert {"test", "studies", "slow", "report QUICK=1"} <= set((tmp_path / "asked").read_text().splitlines())
