"""Compares the numbers and verdicts of a report with an earlier one, or its numbers with the committed baseline, those of an
earlier full report: changes since, and other reasons that make a report red.

python -m validation.report.baseline reports        # take the numbers of reports/ as the new baseline
"""

import difflib
import json
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from slipwave.errors import NumericsError
from slipwave.sources import ROOT
from validation.commands.result import aligned, rounded
from validation.report import RUN_TIMES, Number, Outcome, Verdict
from validation.report.record import Change, Changes, Record, Word, read_report
from validation.report.text import bare

FOLDER = ROOT / "reports" / "baseline"
LEFT = (Word.GONE, Word.MOVED, Word.BETTER, Word.WORSE)
"""The words of a number that left its baseline."""


Entry: TypeAlias = Number | Verdict
_OF_LIMIT = 0.1
"""Share of a verdict's limit by which its value must move to count as changed."""


class RedReport(NumericsError):
    """The report was written, to `page`, but is red: `lines` has one line for each reason."""

    def __init__(self, lines: list[str], page: Path) -> None:
        super().__init__(f"the report is red for {len(lines)} reason{'s' if len(lines) > 1 else ''}: see {page}")
        self.lines, self.page = lines, page


def changes_since(before: Record, now: Record, since: str) -> Changes:
    """Every number and verdict of the present studies, in `before` and now; `since` identifies `before`."""
    scenes = {study.name: study.scenes for study in before.studies}
    other = {study.name for study in now.studies if scenes.get(study.name, study.scenes) != study.scenes}
    whole = set() if now.quick else {study.name for study in now.studies if not study.error}
    pairs = [*_pairs(before.numbers, now.numbers), *(_pairs(_rows(before), _rows(now)) if before.verdicts else ())]
    every = []  # the baseline tells no verdicts
    for there, here in pairs:
        entry = here or there
        if entry and (here or entry.study in whole):  # an entry can be gone only if its study is whole
            name, kind = (entry.name, "number") if isinstance(entry, Number) else (entry.claim, "verdict")
            told = {"bar": 0.0, "why": ""} | _change(there, here)
            told |= {"word": Word.NOT_COMPARABLE, "why": "another scene of the same name"} if entry.study in other else {}
            every.append(Change.model_validate({"id": entry.id, "study": entry.study, "name": name, "kind": kind} | told))
    listed = sorted((change for change in every if change.word is not Word.SAME), key=lambda change: -change.over)
    return Changes(since=since, counts=dict(Counter(change.word for change in every)), listed=tuple(listed))


def _rows(report: Record) -> list[Verdict]:
    return [case for verdict in report.verdicts for case in verdict.rows]


def _pairs(before: Sequence[Entry], now: Sequence[Entry]) -> Iterator[tuple[Entry | None, Entry | None]]:
    """Entries of the same id, before and now."""
    old, new = {entry.id: entry for entry in before}, {entry.id: entry for entry in now}
    return ((old.get(name), new.get(name)) for name in dict.fromkeys([*new, *old]))


def _change(before: Entry | None, now: Entry | None) -> dict[str, Any]:
    """What became of an entry, as fields of `Change`."""
    if isinstance(before, Number) and isinstance(now, Number):
        return _of_number(before, now)
    if isinstance(before, Verdict) and isinstance(now, Verdict):
        return _of_verdict(before, now)
    old, new = (entry.value if isinstance(entry, Number) else entry and entry.outcome.value for entry in (before, now))
    return {"before": old, "now": new, "word": Word.NEW if now else Word.GONE}


def _of_number(before: Number, now: Number) -> dict[str, Any]:
    tolerance = 0.5 * (before.tolerance + now.tolerance)  # of numbers that state their errors: the sum of both errors
    bar = tolerance * max(abs(before.value), abs(now.value))
    word = Word.MOVED if Number(now.value, tolerance).differs(before.value) else Word.SAME
    if word is Word.MOVED and now.known is not None:
        nearer = abs(before.value - now.known) - abs(now.value - now.known)
        if not abs(nearer) <= 2.0 * now.known_within:
            word = Word.BETTER if nearer > 0.0 else Word.WORSE
    return {"before": before.value, "now": now.value, "bar": bar, "word": word}


def _of_verdict(before: Verdict, now: Verdict) -> dict[str, Any]:
    """Change by the outcome, if that changed (a finding is no failure), otherwise by the measured error."""
    if before.outcome is not now.outcome:
        word = {before.outcome: Word.BETTER, now.outcome: Word.WORSE}.get(Outcome.FAIL, Word.MOVED)
        return {"before": before.outcome.value, "now": now.outcome.value, "word": word}
    told: dict[str, Any] = {"before": before.ours, "now": now.ours, "word": Word.NOT_COMPARABLE}
    if before.found is None or now.found is None or before.limit is None or now.limit is None:
        why = "the claim is one in words; its outcome is the same"
        return told | ({"word": Word.SAME} if before.ours == now.ours else {"why": why})
    if now.unit in RUN_TIMES:
        return told | {"why": "a run time; its outcome is the same"}
    bar = _OF_LIMIT * max(before.limit, now.limit)
    told |= {"before": before.found, "now": now.found, "bar": bar}
    if before.unit != now.unit:
        return told | {"why": f"was in {before.unit or 'a pure number'}, is in {now.unit or 'a pure number'}"}
    nearer = Word.BETTER if now.found < before.found else Word.WORSE
    return told | {"word": nearer if abs(now.found - before.found) > bar else Word.SAME}


def change_lines(changes: Changes) -> Iterator[str]:
    """Printed lines: the number of changes by word, and every listed change."""
    counts = ", ".join(f"{changes.counts[word]} {word}" for word in Word if word in changes.counts)
    yield f"Since {changes.since}: {counts or 'nothing to compare'}."
    rows = [
        [
            bare(f"{change.study}: {change.name}"),
            change.word,
            _shown(change.before),
            _shown(change.now),
            f"{change.over:.2g}".replace("inf", "-"),
        ]
        for change in changes.listed
        if change.word is not Word.NOT_COMPARABLE
    ]
    if rows:
        yield from aligned(["number or claim", "is", "before", "now", "moved by bars"], rows)


def _shown(value: float | str | None) -> str:
    return rounded(value, 7) if isinstance(value, float | None) else value


def as_report(now: Record) -> Record:
    """The baseline as a report to compare `now` with: numbers alone."""
    numbers = [
        Number(**stored, id=f"{study.name}.{name}", study=study.name, name=name)
        for study in now.studies
        if (path := FOLDER / f"{study.name}.json").exists()
        for name, stored in json.loads(path.read_text(encoding="utf-8")).items()
    ]
    return now.model_copy(update={"numbers": tuple(numbers), "verdicts": ()})


def red_lines(report: Record, red: tuple[Word, ...]) -> list[str]:
    """One line for each failed study, failed verdict and change under one of the words `red`: its name, what was expected and
    what was found."""
    lines = []
    for study in report.studies:
        lines += [f"{study.name}: failed: {study.error}"] if study.error else []
        cases = [case for verdict in report.verdicts if verdict.study == study.name for case in verdict.rows]
        lines += [f"{study.name}: {case.line}" for case in cases if case.outcome is Outcome.FAIL]
        changes = sorted(report.changes.of(*red), key=lambda change: red.index(change.word))
        lines += [line_of(change) for change in changes if change.study == study.name]
    return [" ".join(bare(line).split()) for line in lines]


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
