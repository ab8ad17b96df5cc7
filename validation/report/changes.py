"""What became of the numbers and verdicts of an earlier report."""

from collections import Counter
from collections.abc import Iterator
from typing import Literal

from validation.report.record import Change, Changes, NumberRecord, Report, VerdictRecord, Word
from validation.study import Number, Outcome

_OF_LIMIT = 0.1
"""What a verdict found has changed when it moves by more than this share of what is allowed."""


def changes_since(before: Report, now: Report, since: str) -> Changes:
    """Every number and verdict of the studies that are done now, in `before` and now; `since` says which report `before` is."""
    done = {study.name for study in now.studies if not study.error}
    scenes = {study.name: study.scenes for study in before.studies}
    other = {study.name for study in now.studies if scenes.get(study.name, study.scenes) != study.scenes}
    every = [*_of_numbers(before, now, done), *_of_verdicts(before, now, done)]
    every = [_uncompared(change, "another scene of the same name") if change.study in other else change for change in every]
    listed = sorted((change for change in every if change.word is not Word.SAME), key=lambda change: -change.over)
    return Changes(since=since, counts=dict(Counter(change.word for change in every)), listed=tuple(listed))


def _uncompared(change: Change, why: str) -> Change:
    return change.model_copy(update={"word": Word.NOT_COMPARABLE, "why": why})


def _of_numbers(before: Report, now: Report, done: set[str]) -> Iterator[Change]:
    """A number that a quick report leaves out is not gone."""
    old, new = ({number.id: number for number in report.numbers} for report in (before, now))
    for name in dict.fromkeys([*new, *old]):
        here, there = new.get(name), old.get(name)
        if one := here or there:
            values = (there and there.value, here and here.value)
            if here and there:
                yield _number(there, here)
            elif here or (one.study in done and not now.quick):
                yield _change(one, "number", one.name, values, 0.0, Word.NEW if here else Word.GONE)


def _number(before: NumberRecord, now: NumberRecord) -> Change:
    tolerance = max(before.tolerance, now.tolerance)
    bar = tolerance * max(abs(before.value), abs(now.value))
    word = Word.MOVED if Number(now.value, tolerance).differs(before.value) else Word.SAME
    if word is Word.MOVED and now.known is not None:
        word = Word.BETTER if abs(now.value - now.known) < abs(before.value - now.known) else Word.WORSE
    return _change(now, "number", now.name, (before.value, now.value), bar, word)


def _of_verdicts(before: Report, now: Report, done: set[str]) -> Iterator[Change]:
    """The verdicts of a report that tells none, as the baseline, are not compared."""
    old, new = ({verdict.id: verdict for verdict in report.verdicts} for report in (before, now))
    for name in dict.fromkeys([*new, *old]) if old else ():
        here, there = new.get(name), old.get(name)
        if one := here or there:
            if here and there:
                yield _verdict(there, here)
            elif here or (one.study in done and not now.quick):
                outcomes = (there and there.outcome.value, here and here.outcome.value)
                yield _change(one, "verdict", one.claim, outcomes, 0.0, Word.NEW if here else Word.GONE)


def _verdict(before: VerdictRecord, now: VerdictRecord) -> Change:
    """By the outcome, if that changed: a finding is no failure. Otherwise by the error that it found."""
    if before.outcome is not now.outcome:
        word = {before.outcome: Word.BETTER, now.outcome: Word.WORSE}.get(Outcome.FAIL, Word.MOVED)
        return _change(now, "verdict", now.claim, (before.outcome.value, now.outcome.value), 0.0, word)
    if before.found is None or now.found is None or before.limit is None or now.limit is None:
        same = before.ours == now.ours
        word, why = (Word.SAME, "") if same else (Word.NOT_COMPARABLE, "the claim is one in words; its outcome is the same")
        return _change(now, "verdict", now.claim, (before.ours, now.ours), 0.0, word, why)
    bar = _OF_LIMIT * max(before.limit, now.limit)
    values, word, why = (before.found, now.found), Word.SAME, ""
    if before.unit != now.unit:
        word, why = Word.NOT_COMPARABLE, f"was in {before.unit or 'a pure number'}, is in {now.unit or 'a pure number'}"
    elif abs(now.found - before.found) > bar:
        word = Word.BETTER if now.found < before.found else Word.WORSE
    return _change(now, "verdict", now.claim, values, bar, word, why)


def _change(
    one: NumberRecord | VerdictRecord,
    kind: Literal["number", "verdict"],
    name: str,
    values: tuple[float | str | None, float | str | None],
    bar: float,
    word: Word,
    why: str = "",
) -> Change:
    before, now = values
    return Change(id=one.id, study=one.study, name=name, kind=kind, before=before, now=now, bar=bar, word=word, why=why)
