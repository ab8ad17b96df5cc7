"""The committed baseline, the numbers of an earlier full report: changes since, and other reasons that make a report red.

python -m validation.report.baseline reports        # take the numbers of reports/ as the new baseline
"""

import difflib
import json
import sys
from pathlib import Path
from typing import Any

from slipwave.errors import NumericsError
from slipwave.sources import ROOT
from validation.report import Number, Outcome, Verdict
from validation.report.record import Change, Record, Word, read_report
from validation.report.text import bare

FOLDER = ROOT / "reports" / "baseline"
LEFT = (Word.GONE, Word.MOVED, Word.BETTER, Word.WORSE)
"""The words of a number that left its baseline."""


class RedReport(NumericsError):
    """The report was written, to `page`, but is red: `lines` has one line for each reason."""

    def __init__(self, lines: list[str], page: Path) -> None:
        super().__init__(f"the report is red for {len(lines)} reason{'s' if len(lines) > 1 else ''}: see {page}")
        self.lines, self.page = lines, page


def as_report(now: Record) -> Record:
    """The baseline as a report to compare `now` with: numbers alone."""
    numbers = [
        Number(**one, id=f"{study.name}.{name}", study=study.name, name=name)
        for study in now.studies
        if (path := FOLDER / f"{study.name}.json").exists()
        for name, one in json.loads(path.read_text(encoding="utf-8")).items()
    ]
    return now.model_copy(update={"numbers": tuple(numbers), "verdicts": ()})


def red_lines(report: Record, red: tuple[Word, ...]) -> list[str]:
    """One line for each failed study, failed verdict and change under one of the words `red`: its name, what was expected and
    what was found."""
    lines = []
    for study in report.studies:
        lines += [f"{study.name}: failed: {study.error}"] if study.error else []
        cases = [case for verdict in report.verdicts if verdict.study == study.name for case in verdict.rows]
        lines += [f"{study.name}: {reason(case)}" for case in cases if case.outcome is Outcome.FAIL]
        changes = sorted(report.changes.of(*red), key=lambda change: red.index(change.word))
        lines += [line_of(change) for change in changes if change.study == study.name]
    return [" ".join(bare(line).split()) for line in lines]


def reason(verdict: Verdict) -> str:
    """A verdict in one line: what was expected and what was found."""
    remark = f" ({verdict.remark})" if verdict.remark else ""
    return f"{verdict.claim}: expected {verdict.expected}, found {verdict.ours}{remark}"


def line_of(change: Change) -> str:
    """A change in one line."""
    before, now = (f"{value:.9g}" if isinstance(value, float) else value or "none" for value in (change.before, change.now))
    bar = f" ± {change.bar:.1e}" if change.bar else ""
    return f"{change.study}: {change.name}: expected {before}{bar}, found {now}"


def patch_of(report: Record) -> str:
    """A patch for `git apply` that updates the numbers that left the baseline and, from a full report, adds new ones."""
    taken = (*LEFT, *(() if report.quick else (Word.NEW,)))
    changes = [change for change in report.changes.of(*taken) if change.kind == "number"]
    now = {number.id: number for number in report.numbers}
    parts: list[str] = []
    for study in dict.fromkeys(change.study for change in changes):
        path = FOLDER / f"{study}.json"
        before = path.read_text(encoding="utf-8") if path.exists() else ""
        numbers = json.loads(before) if before else {}
        for change in changes:
            if change.study == study:
                numbers.pop(change.name, None) if change.now is None else numbers.update({change.name: _kept(now[change.id])})
        file = f"reports/baseline/{path.name}"
        parts += difflib.unified_diff(
            before.splitlines(True), _text(numbers).splitlines(True), f"a/{file}" if before else "/dev/null", f"b/{file}"
        )
    return "".join(parts)


def _kept(number: Number) -> dict[str, Any]:
    """The entry of a number in the baseline."""
    return {"value": number.value, "tolerance": number.tolerance}


def _text(numbers: dict[str, Any]) -> str:
    return json.dumps(numbers, indent=1, ensure_ascii=False) + "\n"


def take(out: Path) -> list[Path]:
    """Write the numbers of out/report.json as the baseline; returns the files written."""
    report = read_report(out, "the report")
    FOLDER.mkdir(parents=True, exist_ok=True)
    written = []
    for study in dict.fromkeys(number.study for number in report.numbers):
        written.append(FOLDER / f"{study}.json")
        kept = {number.name: _kept(number) for number in report.numbers if number.study == study}
        written[-1].write_text(_text(kept), encoding="utf-8")
    return written


if __name__ == "__main__":
    print("\n".join(str(path) for path in take(Path(sys.argv[1]))))
