"""The table of models as the page shows it: one quantity at a time, neighbouring cells of one wrong regime joined."""

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

from validation.report import Verdict
from validation.report.model_table import ModelCell, ModelColumn, ModelRow, ModelTable, shade_of, words_of
from validation.report.questions import verdicts_of
from validation.report.store import Stored


def models_of(studies: Sequence[Stored]) -> list[ModelTable]:
    """All tables of models, in the order of the studies."""
    return [table for study in studies if study.result for table in study.result.model_tables]


def groups_of(table: ModelTable) -> list[tuple[str, int]]:
    """Groups of columns, and how many columns each has."""
    return [(group, len(list(columns))) for group, columns in groupby(table.columns, lambda column: column.group)]


def starts(table: ModelTable) -> set[str]:
    """Titles of the columns with which a group begins."""
    return {next(columns).title for _, columns in groupby(table.columns, lambda column: column.group)}


def usual(table: ModelTable) -> int:
    """Index of the column that is shown first where one is shown at a time: the first with measured costs."""
    return next((n for n, column in enumerate(table.columns) if column.title in table.costed), 0)


def cost_at(table: ModelTable, row: ModelRow, column: ModelColumn) -> float | None:
    """The model's cost in the nearest column with measured costs."""
    measured = {other.title: abs(other.log10_r - column.log10_r) for other in table.columns if other.title in table.costed}
    costs = dict(zip(table.costed, row.costs, strict=True))
    return costs[min(measured, key=lambda title: measured[title])] if measured else None


def joined(table: ModelTable, row: ModelRow, symbol: str) -> Iterator[dict[str, Any]]:
    """Cells of a row as they are shown; neighbours without numbers and of one regime, in one group, are one."""

    def kind(pair: tuple[ModelColumn, ModelCell]) -> tuple[str, ...]:
        """Key that joined neighbours have in common."""
        column, cell = pair
        return (column.group, cell.regime) if symbol not in cell.figures else (column.group, cell.regime, column.title)

    for _, found in groupby(zip(table.columns, row.cells, strict=True), kind):
        pairs = list(found)
        column, cell = pairs[0]
        yield shown(table, row, column, cell, symbol) | {"span": len(pairs), "first": column.title in starts(table)}


def shown(table: ModelTable, row: ModelRow, column: ModelColumn, cell: ModelCell, symbol: str) -> dict[str, Any]:
    """Text of a cell, its shade, its regime if that is wrong, and the anchor of its evidence."""
    regime = cell.regime if symbol in cell.figures and not cell.right else ""
    facts = {"words": words_of(cell, symbol), "shade": shade_of(cell, symbol), "regime": regime}
    return facts | {"anchor": anchor(table, row, column)}


def anchor(table: ModelTable, row: ModelRow, column: ModelColumn) -> str:
    """Id of the row with the evidence of a cell: models.table.model.column."""
    return f"models.{table.name}.{row.model}.{column.title}".replace("−", "-").replace(" ", "-")


def proofs(model: str, studies: Sequence[Stored]) -> list[Verdict]:
    """The verdicts, or cases of them, that judge the model by its name."""
    rows = (row for verdict in verdicts_of(studies) for row in verdict.rows)
    return [row for row in rows if f"`{model}`" in row.claim + row.remark]


SHOWN = (anchor, cost_at, groups_of, joined, shown, starts, usual)
"""Functions for the template of the table."""
