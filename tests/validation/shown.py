"""Everything a study shows, as plain lines, so that a page of some fifty figures and tables is looked at whole.

`records` holds the lines against the committed ones.
"""

import ast
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest
from drawn import drawn, number

from slipwave.sources import ROOT, import_closure
from validation.run import timing
from validation.studies import load
from validation.study import Budget, Figure, Study, StudyResult, Table, Verdict
from validation.study.drawing import styled

_STUDIES = ROOT / "validation" / "studies"


def quick(name: str) -> StudyResult:
    """A study's quick run by a clock of its own: the n-th reading is n^2 ms, so that run times are the same on every machine."""
    with pytest.MonkeyPatch.context() as patch:
        readings = itertools.count()
        patch.setattr(timing, "_spent", lambda: 1e-3 * next(readings) ** 2)
        return load(name).run(Budget(quick=True))


def shown(result: StudyResult) -> list[str]:
    """Answer, verdicts, notes, omissions, numbers, tables and figures."""
    return [line.rstrip() for line in _shown(result)]


def settings(name: str) -> list[str]:
    """The constants of a study's modules, sentences left out: grids, windows and limits, those of the full report too."""
    return [f"setting {line}" for module in _modules(load(name)) for line in _constants(module)]


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


def _modules(study: Study) -> list[ModuleType]:
    own = Path(str(study.__file__))
    files = [path for path in import_closure([own], packages=False) if path.is_relative_to(_STUDIES)]
    return [import_module(".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")) for path in files]


def _constants(module: ModuleType) -> Iterator[str]:
    for node in ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8")).body:
        for name in (one.id for one in ast.walk(node) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)):
            value = vars(module).get(name)
            if name.isupper() and not isinstance(value, str):
                yield f"{module.__name__.removeprefix('validation.studies.')} {name} = {_told(value)}"


def _told(value: object) -> str:
    """A constant in words and numbers; what is neither is told by its kind."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_told(key)}: {_told(one)}' for key, one in value.items())}}}"
    if isinstance(value, tuple | list | frozenset | range):
        return f"({', '.join(map(_told, value))})"
    if isinstance(value, bool | str | int | None):
        return str(value)
    if isinstance(value, float):
        return f"{value:.12g}"
    if is_dataclass(value):
        return f"{type(value).__name__}({', '.join(_told(getattr(value, field.name)) for field in fields(value))})"
    return getattr(value, "__name__", type(value).__name__)
