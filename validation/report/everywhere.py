"""Models over so many scenes that a table has one row a model: how often each is right, its largest errors, and which is the
first that may be used everywhere. Motions are on record (`validation.measure.on_record`)."""

import math
from collections.abc import Callable, Iterable, Sequence

from slipwave.observe.statistics import Estimate
from validation.measure.on_record import on_record
from validation.measure.regimes import UNDECIDED, Regime
from validation.report import ROUNDING, SELF, WITNESS, Table, Verdict, every, minus, plain, table
from validation.report.compared import GOOD, JUDGED, compared_table, decided, is_good
from validation.report.known import ERRORS
from validation.report.model_table import ModelCell, ModelColumn, ModelTable

_SHORT = 20000.0  # transits


def recorded_table(
    name: str, columns: Sequence[ModelColumn], models: Iterable[str], costed: str, costs: dict[str, float]
) -> ModelTable:
    """The motions on record of every model in the scenes of the `columns`, against the exact ones; `costs` in the column
    titled `costed`. A model without a motion there counts as undecided."""
    motions = {model: [on_record(model, column.settings) or Regime(UNDECIDED) for column in columns] for model in models}
    return compared_table(name, "", "scene", columns, motions, {}, {costed: costs})


def summary(model_table: ModelTable, where: str, remark: str = "") -> Table:
    """One row a model; the largest errors by the groups of the columns. `where` names the scenes, `remark` ends the caption."""
    groups = list(dict.fromkeys(column.group for column in model_table.columns))
    rows = []
    for row in model_table.rows[1:]:
        cells = decided(model_table, row)
        right = sum(cell.right for _, cell in cells)
        largest = [_largest(cells, symbol, group) for group in groups for symbol in JUDGED]
        good, of = _good(model_table, row.model)
        rows.append([row.model, f"{right}/{len(cells)}", *largest, f"{good}/{of}", row.costs[0]])
    each = " | ".join(f"{group}: T [%] | Δμ [%]" for group in groups)
    caption = (
        f"Reduced models {where}: in how many the regime is the exact one; the largest errors, with two standard errors where "
        f"they are of means; in how many the model is good (right regime, T and Δμ right to {100.0 * GOOD:g} % or to that and "
        f"two standard errors); processor time over that of the delay system in {model_table.costed[0]}.{remark}"
    )
    return table("models", caption, f"model | right regime | {each} | good | cost [of times] .2g", rows)


def first_in_words(model_table: ModelTable, ladder: Sequence[str], where: str) -> str:
    """Which model of the ladder is the first that is right everywhere, and in how many scenes the others are."""
    first = _first(model_table, ladder)
    beyond = ladder[ladder.index(first) :]
    others = ", ".join(
        f"`{row.model}` in {_good(model_table, row.model)[0]}" for row in model_table.rows[1:] if row.model not in beyond
    )
    return (
        f"`{first}` is the first ODE right to {100.0 * GOOD:g} % {where} ({_good(model_table, first)[1]} motions); "
        f"of the others good are {others}."
    )


def first_good(model_table: ModelTable, ladder: Sequence[str], title: str) -> Verdict:
    """Whether a model of the `ladder` is good everywhere."""
    first = _first(model_table, ladder)
    return every(title, WITNESS, *_good(model_table, first), f"`{first}`, every motion that both decide", "motions")


def repeated(title: str, again: Sequence[tuple[str, ModelColumn]], motion_at: Callable[[str, str, float], Regime]) -> Verdict:
    """Whether the present code has the motions on record of some models in columns: orbits but for rounding, means within their
    errors. The remark names those that it has not."""
    missed = []
    for model, column in again:
        known, now = on_record(model, column.settings), motion_at(model, column.settings, _SHORT)
        if not (known and all(_same(known, now, symbol) for symbol in JUDGED)):
            missed.append(f"`{model}`, {column.title}")
    remark = f"T and Δμ: orbits to {plain(ROUNDING)}, means within {ERRORS:g} standard errors"
    return every(title, SELF, len(again) - len(missed), len(again), "; not: ".join([remark, *missed]), "motions")


def _same(known: Regime, now: Regime, symbol: str) -> bool:
    if not {symbol} <= known.figures.keys() & now.figures.keys():
        return False
    old, new = known.figures[symbol], now.figures[symbol]
    return abs(new.value - old.value) <= (ERRORS * new.error if known.cycles else ROUNDING * abs(old.value))


def motion_cells(motion: Regime, clock: float = 1.0) -> list[str | None]:
    """A motion in a table: its words, and T, times `clock`, and the stress drop."""
    return [motion.words, _with_bar(motion.figures.get("T"), clock), _with_bar(motion.figures.get("Δμ"))]


def _with_bar(estimate: Estimate | None, scale: float = 1.0) -> str | None:
    """A figure times `scale`, with the digits that its error leaves, and with two standard errors if it is a mean."""
    if estimate is None:
        return None
    bar = 2.0 * estimate.error * scale
    digits = min(6, max(2, 1 - math.floor(math.log10(bar)))) if bar > 0.0 else 6
    return f"{estimate.value * scale:.{digits}f}" + (f" ± {bar:.{digits}f}" if bar > 1e-6 else "")


def _largest(cells: Sequence[tuple[ModelColumn, ModelCell]], symbol: str, group: str) -> str | None:
    """The largest error of a quantity in a group, in per cent, with two standard errors if it is one of means."""
    errors = [cell.figures[symbol] for column, cell in cells if column.group == group and symbol in cell.figures]
    errors = [figure for figure in errors if figure.error is not None]
    if not errors:
        return None
    worst = max(errors, key=lambda figure: figure.size)
    bar = 200.0 * worst.standard_error
    return minus(f"{100.0 * (worst.error or 0.0):+.2g}") + (f" ± {bar:.1g}" if bar > 1e-4 else "")


def _good(model_table: ModelTable, model: str) -> tuple[int, int]:
    """In how many scenes the model is good, of how many."""
    cells = [cell for _, cell in decided(model_table, model_table.row(model))]
    return sum(map(is_good, cells)), len(cells)


def _first(model_table: ModelTable, ladder: Sequence[str]) -> str:
    return next((model for model in ladder if len(set(_good(model_table, model))) == 1), ladder[-1])
