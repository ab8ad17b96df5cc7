"""Everything a study shows, as plain lines, so that a page of some fifty figures and tables is looked at whole.

`records` holds the lines against the committed ones.
"""

import itertools
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from drawn import drawn, number

from slipwave.input import source
from validation.report.sources import sources_of
from validation.run import timing
from validation.studies import load
from validation.study import Budget, Figure, StudyResult, Table, Verdict
from validation.study.drawing import styled

REPORTED: dict[str, list[float]] = {}
READ: dict[str, set[str]] = {}
"""By name, for the studies that were run."""


def quick(name: str) -> StudyResult:
    """A study's quick run by a clock of its own: the n-th reading is n^2 ms, so that run times are the same on every machine.
    `REPORTED` has the shares of its work that it reported on the way, which rise to 1 at most, `READ` the gallery scenes it read,
    which must be in the key of its result."""
    shares, scenes, study = list[float](), set[str](), load(name)
    REPORTED[name], READ[name] = shares, scenes
    with pytest.MonkeyPatch.context() as patch:
        readings = itertools.count()
        patch.setattr(timing, "_spent", lambda: 1e-3 * next(readings) ** 2)
        patch.setattr(source, "load", watched(source.load, scenes))
        result = study.run(Budget(quick=True, report=shares.append))
    assert all(before < after for before, after in itertools.pairwise([0.0, *shares, 1.0 + 1e-9])), shares
    assert scenes <= {path.stem for path in sources_of(study) if path.suffix == ".toml"}
    return result


def watched(read: Callable[..., Any], scenes: set[str]) -> Callable[..., Any]:
    """`read` (`slipwave.input.source.load`), which notes the gallery scenes it is asked for in `scenes`."""

    def reading(name: object, *rest: Any) -> Any:
        scenes.update({str(name)} & set(source.gallery_names()))
        return read(name, *rest)

    return reading


def shown(name: str, result: StudyResult) -> list[str]:
    """Answer, verdicts, notes, omissions, numbers, tables, figures, and shares of the work that were reported."""
    reported = ", ".join(number(share) for share in REPORTED.get(name, []))
    return [line.rstrip() for line in (*_shown(result), f"reported: {reported}")]


def _shown(result: StudyResult) -> Iterator[str]:
    yield f"answer: {result.answer}"
    for verdict in result.verdicts:
        yield from _verdict(verdict)
    yield from (f"note: {note}" for note in result.notes)
    yield from (f"omission: {omission.what} {omission.why}" for omission in result.omissions)
    for name, one in result.numbers.items():
        yield f'number "{name}": {number(one.value)} within {number(one.tolerance)}'
    for table in result.tables:
        yield from _table(table)
    for figure in result.figures:
        yield from _figure(figure)


def _verdict(verdict: Verdict) -> Iterator[str]:
    yield f"verdict {verdict.outcome.value}: {verdict.claim} ({verdict.evidence.value})"
    size, limit = (f"; {number(value)}" if value is not None else "" for value in (verdict.size, verdict.limit))
    yield f"  expected: {verdict.expected}{limit}"
    yield f"  ours: {verdict.ours}; {verdict.remark}{size}"


def _table(table: Table) -> Iterator[str]:
    yield f"table {table.name}: {table.caption}"
    yield f"{table.name}: " + " | ".join(f"{column.title} [{column.unit}] {column.format}" for column in table.columns)
    for count, row in enumerate(table.rows):
        cells = ("-" if cell is None else cell if isinstance(cell, str) else number(cell) for cell in row)
        yield f"{table.name}: {'bold ' * (count in table.emphasis)}{' | '.join(cells)}"


def _figure(figure: Figure) -> Iterator[str]:
    yield f"figure {figure.name}{' (lead)' * figure.lead}: {figure.caption}"
    with styled():
        yield from (f"{figure.name}: {line}" for line in drawn(figure.draw()))
