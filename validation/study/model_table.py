"""The table that answers which model may be used: every model at every place, its errors, its regime, what it costs, and advice.

    ModelTable     `columns` are the places (one r each), in groups of one regime of the exact motion; `rows` are the models
    ModelRow       a model: one cell for each column, its onset, its costs, and the advice that follows from them
    ModelCell      a model at a place: its regime in words, and the quantities of its cycles where it has any
    Compared       one quantity: its value, its error against the reference model, and how well that is known

`words_of` says what a cell shows, `shade_of` how bad that is, `cell_records` has the table as one line for each number.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from validation.study.text import Cell, minus, plain

SHADES = {"none": 1e-3, "pale": 1e-2, "amber": 0.1}
"""How a cell is shaded: the first whose limit its relative error does not reach; "red" above all; "wrong" in the wrong regime."""

_CERTAIN = 1e-6
"""A standard error below this, relative, is that of a computation; it is not shown."""


@dataclass(frozen=True)
class Compared:
    """A quantity of a model at a place: `value` in the quantity's unit; signed relative `error` against the reference model's
    value, None for the reference itself; `standard_error` of that error, relative (of the reference: of its own value). For means
    over cycles it is the statistical one, of both means; for orbits the error of their computation."""

    value: float
    error: float | None
    standard_error: float


@dataclass(frozen=True)
class ModelCell:
    """A model at a place. `regime`: what its motion is, in words (`slipwave.observe.verdict`, or "runs away"); `right`: whether
    the reference's motion is of that regime too; `cycles`: how many a mean is over, 0 for an orbit; `figures`: symbol of a
    quantity (`ModelTable.quantities`) -> what was found, empty where there are no cycles."""

    regime: str
    right: bool
    cycles: int = 0
    figures: dict[str, Compared] = field(default_factory=dict)


@dataclass(frozen=True)
class ModelColumn:
    """A place: its `title` (log10 r, or another name), log10 r, r over the onset of the reference, the `group` of columns that it
    stands in, which is the regime of the reference there, "periodic" or "torus, irregular"; and `settings`, the options of the
    command line that make this place of the table's scene."""

    title: str
    log10_r: float
    over_onset: float
    group: str
    settings: str = ""


@dataclass(frozen=True)
class ModelQuantity:
    """A quantity that is compared: its `symbol` is the key in `ModelCell.figures`."""

    symbol: str
    title: str
    unit: str


@dataclass(frozen=True)
class ModelRow:
    """A model: `cells` in the order of the columns; `onset`, log10 of the r where its steady sliding loses stability, with the
    relative error of r itself, None if it never does; `costs`, processor time over the reference's at the places
    `ModelTable.costed`, None if not measured; `advice`, "use", "use as witness" or "avoid", and `why` in a few words."""

    model: str
    cells: tuple[ModelCell, ...]
    onset: Compared | None
    costs: tuple[float | None, ...]
    advice: str
    why: str


@dataclass(frozen=True)
class ModelTable:
    """Models over places. `name` is that of the scene; `reference` is the model that errors are against, and its row is one of
    the `rows`; `costed` are the titles of the columns at which costs are measured; `sentences` say what to use, what to avoid
    and what is new, computed from the table. Captions use the small markup of `validation.study.text`."""

    name: str
    caption: str
    parameter: str
    quantities: tuple[ModelQuantity, ...]
    columns: tuple[ModelColumn, ...]
    costed: tuple[str, ...]
    reference: str
    rows: tuple[ModelRow, ...]
    sentences: tuple[str, ...] = ()

    def row(self, model: str) -> ModelRow:
        """The row of `model`; KeyError if there is none."""
        return {row.model: row for row in self.rows}[model]


def words_of(cell: ModelCell, symbol: str) -> str:
    """What the cell shows of a quantity: the error in per cent down to 0.1 %, below as a power of ten, with two standard errors
    where it is a mean; the value for the reference, likewise; the regime where there is no cycle. In the small markup."""
    found = cell.figures.get(symbol)
    if found is None:
        return cell.regime
    bar = 2.0 * found.standard_error
    if found.error is None:
        return _with_bar(found.value, bar * abs(found.value), 2, 0) if bar > _CERTAIN else f"{found.value:.5g}"
    if bar > _CERTAIN:
        return minus(f"{_with_bar(100 * found.error, 100 * bar, 1, 1, '+')} %")
    return minus(f"{100 * found.error:+.1f} %") if abs(found.error) >= 1e-3 else plain(found.error, "+.0e")


def _with_bar(value: float, bar: float, digits: int, least: int, sign: str = "") -> str:
    """A value and its bar, with as many decimals as show so many digits of the bar, and so many at least."""
    places = max(least, digits - 1 - math.floor(math.log10(bar)))
    return f"{value:{sign}z.{places}f} ± {bar:.{places}f}"


def shade_of(cell: ModelCell, symbol: str) -> str:
    """A key of SHADES, "red" or "wrong"; "" for the reference and where nothing is compared in the right regime. An error within
    its two standard errors may be none."""
    if not cell.right:
        return "wrong"
    found = cell.figures.get(symbol)
    if found is None or found.error is None:
        return ""
    if abs(found.error) <= 2.0 * found.standard_error:
        return "none"
    return next((shade for shade, limit in SHADES.items() if abs(found.error) < limit), "red")


def cell_records(table: ModelTable) -> Iterator[dict[str, Cell]]:
    """One line for each model, place and quantity, for a file; no figures: one line with an empty symbol."""
    for row in table.rows:
        for column, cell in zip(table.columns, row.cells, strict=True):
            place: dict[str, Cell] = {"model": row.model, "log10_r": column.log10_r, "group": column.group, "regime": cell.regime}
            place |= {"regime_right": int(cell.right), "cycles": cell.cycles}
            cost = dict(zip(table.costed, row.costs, strict=True)).get(column.title)
            for symbol, found in cell.figures.items() or {"": None}.items():
                numbers = (found.value, found.error, found.standard_error) if found else (None, None, None)
                named = dict(zip(("quantity", "value", "error", "standard_error"), (symbol, *numbers), strict=True))
                yield place | named | {"cost": cost, "advice": row.advice}
