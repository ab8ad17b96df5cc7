"""The table that answers which model may be used: errors, regime, cost and advice for every model at every value of a parameter.

    ModelTable     `columns`: one r each, in groups of one regime of the exact motion; `rows`: the models
    ModelRow       a model: one cell for each column, its onset, its costs, and the advice that follows from them
    ModelCell      a model in a column: its regime in words, and the quantities of its cycles, if any
    Compared       one quantity: its value, its error against the reference model, and how well that is known

What a cell shows (`words`), and how bad that is (`shade`), are said by the cell; what is joined on the page, and the lines of the
table's file (`records`), by the table.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import groupby

from validation.report.text import Cell, minus, plain

SHADES = {"none": 1e-3, "pale": 1e-2, "amber": 0.1}
"""Shade of a cell: the first whose limit exceeds its relative error; "red" above all; "open" where its bar reaches over the
limit of a good model; "wrong" in the wrong regime."""

_MANIFOLD = 10.0
"""An error from which on its size alone is shown."""
_CERTAIN = 1e-6
"""A standard error below this, relative, is that of a computation; it is not shown."""


@dataclass(frozen=True)
class Compared:
    """A quantity of a model in a column: `value` in the quantity's unit; signed relative `error` against the reference model's
    value, None for the reference itself; `standard_error` of that error, relative (of the reference: of its own value). For means
    over cycles it is the statistical one, of both means; for orbits the error of their computation."""

    value: float
    error: float | None
    standard_error: float

    @property
    def size(self) -> float:
        """Size of the error; 0 for the reference."""
        return abs(self.error or 0.0)


def _with_bar(value: float, bar: float, digits: int, least: int, sign: str = "") -> str:
    """A value and its bar, with decimals for `digits` digits of the bar, and at least `least`."""
    decimals = max(least, digits - 1 - math.floor(math.log10(bar)))
    return f"{value:{sign}z.{decimals}f} ± {bar:.{decimals}f}"


@dataclass(frozen=True)
class ModelCell:
    """A model in a column. `regime`: in words (`slipwave.observe.verdict`, or "runs away"); `right`: whether the reference has
    this regime too; `cycles`: number of cycles of a mean, 0 for an orbit; `figures`: symbol of a quantity
    (`ModelTable.quantities`) -> what was found, empty where there are no cycles; `command` and options that print it."""

    regime: str
    right: bool
    cycles: int = 0
    figures: dict[str, Compared] = field(default_factory=dict)
    command: str = ""

    def command_for(self, row: "ModelRow", column: "ModelColumn") -> str:
        """The whole command that repeats the cell, its digits included; "" where the model was not tried."""
        name, _, options = self.command.partition(" ")
        return f"slipwave {name} {column.settings} --model {row.model} {options}" if name else ""

    def words(self, symbol: str) -> str:
        """Text of a quantity in the small markup: the error in per cent down to 0.1 %, below as a power of ten, with two standard
        errors where it is a mean; of a value more than tenfold, how many times as large it is; the value for the reference; the
        regime where there is no cycle."""
        figure = self.figures.get(symbol)
        if figure is None:
            return self.regime
        bar = 2.0 * figure.standard_error
        if figure.error is None:
            return _with_bar(figure.value, bar * abs(figure.value), 2, 0) if bar > _CERTAIN else f"{figure.value:.5g}"
        if abs(figure.error) >= _MANIFOLD:
            return f"{plain(1.0 + figure.error, '.0e')} times"
        if bar > _CERTAIN:
            return minus(f"{_with_bar(100 * figure.error, 100 * bar, 1, 1, '+')} %")
        return minus(f"{100 * figure.error:+.1f} %") if abs(figure.error) >= 1e-3 else plain(figure.error, "+.0e")

    def shade(self, symbol: str) -> str:
        """A key of SHADES, "red", "open" or "wrong"; "" for the reference and where nothing is compared in the right regime. An
        error may be larger by its two standard errors; whether these decide on the limit of a good model is open if it lies
        between."""
        if not self.right:
            return "wrong"
        figure = self.figures.get(symbol)
        if figure is None or figure.error is None:
            return ""
        size, bar = figure.size, 2.0 * figure.standard_error if abs(figure.error) < _MANIFOLD else 0.0
        if size - bar < SHADES["pale"] <= size + bar and bar > _CERTAIN:
            return "open"
        return next((shade for shade, limit in SHADES.items() if size + bar < limit), "red")


@dataclass(frozen=True)
class ModelColumn:
    """A column: its `title` (log10 r, or another name), log10 r, r over the onset of the reference; its `group`, the regime of
    the reference, "periodic" or "torus, irregular"; and `settings`, the words that give it in a command: a scene
    and options."""

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
    relative error of r itself, None if it never does; `costs`, processor time over the reference's in the columns
    `ModelTable.costed`, None if not measured; `advice`, "use", "use as witness" or "avoid", and `why` in a few words."""

    model: str
    cells: tuple[ModelCell, ...]
    onset: Compared | None
    costs: tuple[float | None, ...]
    advice: str
    why: str


@dataclass(frozen=True)
class ModelTable:
    """Models over columns. `name`: of the scene; `reference`: the model that errors refer to, one of the `rows`; `costed`: titles
    of the columns with measured costs; `sentences`, computed from the table, say what to use and what to avoid. Captions use the
    small markup of `validation.report.text`."""

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

    def records(self) -> Iterator[dict[str, Cell]]:
        """One record per model, column and quantity, for a file; without figures one record with an empty symbol."""
        nothing = dict.fromkeys(("value", "error", "standard_error"))
        for row in self.rows:
            costs = dict(zip(self.costed, row.costs, strict=True))
            for column, cell in zip(self.columns, row.cells, strict=True):
                for symbol, figure in cell.figures.items() or [("", None)]:
                    yield {
                        "model": row.model,
                        "log10_r": column.log10_r,
                        "group": column.group,
                        "regime": cell.regime,
                        "regime_right": int(cell.right),
                        "cycles": cell.cycles,
                        "command": cell.command_for(row, column),
                        "quantity": symbol,
                        **(vars(figure) if figure else nothing),
                        "cost": costs.get(column.title),
                        "advice": row.advice,
                    }

    @property
    def groups(self) -> list[tuple[str, list[ModelColumn]]]:
        """Groups of neighbouring columns."""
        return [(group, list(columns)) for group, columns in groupby(self.columns, lambda column: column.group)]

    def cost_at(self, row: ModelRow, column: ModelColumn) -> float | None:
        """The model's cost in the nearest column with measured costs."""
        away = {other.title: abs(other.log10_r - column.log10_r) for other in self.columns}
        return row.costs[self.costed.index(min(self.costed, key=away.__getitem__))] if self.costed else None

    def joined(self, row: ModelRow, symbol: str) -> Iterator[tuple[ModelColumn, ModelCell, int]]:
        """Cells of a row as they are shown, with their first column and the number of columns that they span: neighbours without
        numbers and of one regime, in one group, are one."""
        pairs = zip(self.columns, row.cells, strict=True)
        for _, alike in groupby(pairs, lambda pair: (pair[0].group, pair[1].regime, symbol in pair[1].figures and pair[0].title)):
            (column, cell), *others = alike
            yield column, cell, 1 + len(others)
