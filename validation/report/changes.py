"""Compares the numbers and verdicts of a report with an earlier one."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Literal, TypeVar

from validation.commands.result import aligned, rounded
from validation.report import RUN_TIMES, Number, Outcome, Verdict
from validation.report.record import Change, Changes, Record, Word
from validation.report.text import bare

One = TypeVar("One", Number, Verdict)

_OF_LIMIT = 0.1
"""Share of a verdict's limit by which its value must move to count as changed."""


def changes_since(before: Record, now: Record, since: str) -> Changes:
    """Every number and verdict of the present studies, in `before` and now; `since` identifies `before`."""
    done = {study.name for study in now.studies if not study.error}
    scenes = {study.name: study.scenes for study in before.studies}
    other = {study.name for study in now.studies if scenes.get(study.name, study.scenes) != study.scenes}
    whole = set() if now.quick else done
    every = [*_compared(before.numbers, now.numbers, whole)]
    every += _compared(_rows(before), _rows(now), whole) if before.verdicts else ()  # the baseline tells none
    uncompared = {"word": Word.NOT_COMPARABLE, "why": "another scene of the same name"}
    every = [change.model_copy(update=uncompared) if change.study in other else change for change in every]
    listed = sorted((change for change in every if change.word is not Word.SAME), key=lambda change: -change.over)
    return Changes(since=since, counts=dict(Counter(change.word for change in every)), listed=tuple(listed))


def _rows(report: Record) -> list[Verdict]:
    return [case for verdict in report.verdicts for case in verdict.rows]


def _compared(before: Sequence[One], now: Sequence[One], whole: set[str]) -> Iterator[Change]:
    """The change of each; an entry can be gone only if its study is `whole`."""
    old: dict[str, One] = {one.id: one for one in before}
    new: dict[str, One] = {one.id: one for one in now}
    for name in dict.fromkeys([*new, *old]):
        there, here = old.get(name), new.get(name)
        if isinstance(there, Number) and isinstance(here, Number):
            yield _number(there, here)
        elif isinstance(there, Verdict) and isinstance(here, Verdict):
            yield _verdict(there, here)
        elif here:
            yield _change(here, (None, _value(here)), 0.0, Word.NEW)
        elif there and there.study in whole:
            yield _change(there, (_value(there), None), 0.0, Word.GONE)


def _value(one: Number | Verdict) -> float | str:
    return one.value if isinstance(one, Number) else one.outcome.value


def _number(before: Number, now: Number) -> Change:
    tolerance = 0.5 * (before.tolerance + now.tolerance)  # of numbers that state their errors: the sum of both errors
    bar = tolerance * max(abs(before.value), abs(now.value))
    word = Word.MOVED if Number(now.value, tolerance).differs(before.value) else Word.SAME
    if word is Word.MOVED and now.known is not None:
        nearer = abs(before.value - now.known) - abs(now.value - now.known)
        if not abs(nearer) <= 2.0 * now.known_within:
            word = Word.BETTER if nearer > 0.0 else Word.WORSE
    return _change(now, (before.value, now.value), bar, word)


def _verdict(before: Verdict, now: Verdict) -> Change:
    """Change by the outcome, if that changed (a finding is no failure), otherwise by the measured error."""
    if before.outcome is not now.outcome:
        word = {before.outcome: Word.BETTER, now.outcome: Word.WORSE}.get(Outcome.FAIL, Word.MOVED)
        return _change(now, (before.outcome.value, now.outcome.value), 0.0, word)
    if before.found is None or now.found is None or before.limit is None or now.limit is None:
        same = before.ours == now.ours
        word, why = (Word.SAME, "") if same else (Word.NOT_COMPARABLE, "the claim is one in words; its outcome is the same")
        return _change(now, (before.ours, now.ours), 0.0, word, why)
    if now.unit in RUN_TIMES:
        return _change(now, (before.ours, now.ours), 0.0, Word.NOT_COMPARABLE, "a run time; its outcome is the same")
    bar = _OF_LIMIT * max(before.limit, now.limit)
    values, word, why = (before.found, now.found), Word.SAME, ""
    if before.unit != now.unit:
        word, why = Word.NOT_COMPARABLE, f"was in {before.unit or 'a pure number'}, is in {now.unit or 'a pure number'}"
    elif abs(now.found - before.found) > bar:
        word = Word.BETTER if now.found < before.found else Word.WORSE
    return _change(now, values, bar, word, why)


def _change(
    one: Number | Verdict,
    values: tuple[float | str | None, float | str | None],
    bar: float,
    word: Word,
    why: str = "",
) -> Change:
    kind: Literal["number", "verdict"] = "number" if isinstance(one, Number) else "verdict"
    name = one.name if isinstance(one, Number) else one.claim
    before, now = values
    return Change(id=one.id, study=one.study, name=name, kind=kind, before=before, now=now, bar=bar, word=word, why=why)


def change_lines(changes: Changes) -> Iterator[str]:
    """Printed lines: the number of changes by word, and every listed change."""
    counts = ", ".join(f"{changes.counts[word]} {word}" for word in Word if word in changes.counts)
    yield f"Since {changes.since}: {counts or 'nothing to compare'}."
    rows = [
        [bare(f"{one.study}: {one.name}"), one.word, _shown(one.before), _shown(one.now), f"{one.over:.2g}".replace("inf", "-")]
        for one in changes.listed
        if one.word is not Word.NOT_COMPARABLE
    ]
    if rows:
        yield from aligned(["number or claim", "is", "before", "now", "moved by bars"], rows)


def _shown(value: float | str | None) -> str:
    return rounded(value, 7) if isinstance(value, float | None) else value
