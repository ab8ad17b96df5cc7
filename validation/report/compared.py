"""Fills the table of models (`validation.report.model_table`): errors against the exact system, onsets, costs; and advice.

The rule: a model is good in a column (one r) if its regime is that of the reference, and T and Δμ err by less than 1 %, or by no
more than 1 % and two standard errors of the difference. Good everywhere: "use". Good up to some column: "use up to" its r over
the reference's onset. Not good in the first column: "avoid". A full wave, which serves to check the exact system, is for "use as
witness"; it solves the same equations, so that only a difference beyond `_BY_CHANCE` speaks against it.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from slipwave.family import Exact
from slipwave.observe.statistics import Estimate
from slipwave.scene import Scene
from validation.measure.costs import march_times
from validation.measure.memo import critical_r
from validation.measure.regimes import UNKNOWN, Regime
from validation.models.by_name import family_of
from validation.report.model_table import Compared, ModelCell, ModelColumn, ModelQuantity, ModelRow, ModelTable
from validation.report.text import minus, plain

EXACT_MODEL = "delay"
"""The reference model of errors."""

QUANTITIES = (
    ModelQuantity("T", "period", "transits"),
    ModelQuantity("Δμ", "stress drop", "σ"),
    ModelQuantity("v_{max}", "largest slip rate", "V*"),
)
GOOD = 1e-2
JUDGED = ("T", "Δμ")
_BY_CHANCE = 4.0
"""Standard errors by which the largest of some hundred differences may miss by chance, as the verdicts on means allow."""
AS_CHEAP = 1.1
"""Ratio of costs that counts as equal: run times of one program vary by a tenth."""
_TRANSITS, _BEFORE = 1000.0, 500.0  # that are timed, and marched before
_TOLERANCE = 1e-9
_EXACTLY = 1e-12  # relative error of an onset


def compared_table(
    name: str,
    caption: str,
    parameter: str,
    columns: Sequence[ModelColumn],
    regimes: Mapping[str, Sequence[Regime]],
    onsets: Mapping[str, Compared | None],
    costs: Mapping[str, Mapping[str, float]],
) -> ModelTable:
    """The table, with advice and sentences, of models whose `regimes` in the columns are known, the exact system's among them;
    `costs` by the title of a column, which is the `parameter`. A column without a group is in that of the exact regime."""
    exact = regimes[EXACT_MODEL]
    rows = []
    for model, motions in regimes.items():
        cells = tuple(
            _cell(regime, None if model == EXACT_MODEL else other) for regime, other in zip(motions, exact, strict=True)
        )
        rows.append(ModelRow(model, cells, onsets.get(model), tuple(known.get(model) for known in costs.values()), "", ""))
    grouped = (
        replace(column, group=column.group or ("torus, irregular" if regime.cycles else regime.words))
        for column, regime in zip(columns, exact, strict=True)
    )
    table = ModelTable(name, caption, parameter, QUANTITIES, tuple(grouped), tuple(costs), EXACT_MODEL, tuple(rows))
    advised = ((row, advice_on(row, table)) for row in table.rows)
    done = replace(table, rows=tuple(replace(row, advice=advice, why=why) for row, (advice, why) in advised))
    return replace(done, sentences=tuple(_sentences(done)))


def _cell(ours: Regime, exact: Regime | None) -> ModelCell:
    others = exact.figures if exact else {}
    figures = {symbol: against(own, others.get(symbol)) for symbol, own in ours.figures.items()}
    return ModelCell(ours.words, exact is None or ours.agrees(exact), ours.cycles, figures, ours.command)


def against(ours: Estimate, exact: Estimate | None) -> Compared:
    """A quantity of a model compared with the exact system's, if known."""
    own = ours.error / abs(ours.value)
    if exact is None:
        return Compared(ours.value, None, own)
    ratio = ours.value / exact.value
    return Compared(ours.value, ratio - 1.0, ratio * math.hypot(own, exact.error / exact.value))


def onset(model: str, scene: Scene) -> Compared | None:
    """Onset of a model, log10 of its critical r, with the relative error of r itself; None if it has none."""
    own, exact = (critical_r(name, scene) for name in (model, EXACT_MODEL))
    return Compared(math.log10(own), None if model == EXACT_MODEL else own / exact - 1.0, _EXACTLY) if own > 0.0 else None


def relative_costs(models: Collection[str], cells: Mapping[str, int], scene: Scene, rounds: int) -> dict[str, float]:
    """Processor time of 1000 transits of march and event detection on the motion that each model has settled on, over that of the
    exact system: medians over `rounds` in which all are timed in turn. `cells`: of the full waves."""
    settings = [(model, {"cells": cells[model]} if model in cells else {"tol": _TOLERANCE}) for model in models]
    times = march_times(settings, scene, _TRANSITS, rounds + 1, _BEFORE)[1:]
    shares = np.median(times / times[:, [[*models].index(EXACT_MODEL)]], axis=0)
    return dict(zip(models, shares.tolist(), strict=True))


def is_good(cell: ModelCell, bars: float = 2.0, symbols: Sequence[str] = JUDGED) -> bool:
    """Whether the model may be used there for these quantities, allowing `bars` standard errors."""
    return cell.right and all(not _is_off(cell, symbol, bars) for symbol in symbols)


def _is_off(cell: ModelCell, symbol: str, bars: float = 2.0) -> bool:
    figure = cell.figures.get(symbol)
    return figure is not None and figure.size > GOOD + bars * figure.standard_error


def advice_on(row: ModelRow, table: ModelTable, symbols: Sequence[str] = JUDGED) -> tuple[str, str]:
    """(advice, why) for these quantities, from the columns where the reference's regime and its own are decided."""
    if row.model == table.reference:
        return "use", "exact"
    witness = _is_witness(row)
    known = [(column.over_onset, cell) for column, cell in decided(table, row)]
    bad = [pair for pair in known if not is_good(pair[1], _BY_CHANCE if witness else 2.0, symbols)]
    first, fault = min(bad, key=lambda pair: pair[0], default=(math.inf, None))
    below = [over_onset for over_onset, _ in known if over_onset < first]
    if not below:
        return "avoid", _trouble(row, table, symbols)
    if fault:
        return f"use up to {max(below):.2f} r_{{c}}", f"then {_fault(fault, symbols)}"
    return ("use as witness", "full wave") if witness else ("use", f"as an ODE, off by {_most(_largest(row, symbols))}")


def decided(table: ModelTable, row: ModelRow) -> list[tuple[ModelColumn, ModelCell]]:
    """The cells of a model in the columns where its regime and the reference's are known."""
    cells = zip(table.columns, table.row(table.reference).cells, row.cells, strict=True)
    return [(column, cell) for column, exact, cell in cells if {exact.regime, cell.regime}.isdisjoint(UNKNOWN)]


def _is_witness(row: ModelRow) -> bool:
    family = family_of(row.model)
    return family is not None and family.exact is not Exact.NEVER


def _most(error: float) -> str:
    """An error rounded up to one digit."""
    unit = 10.0 ** math.floor(math.log10(error)) if error else 1.0
    return plain(unit * math.ceil(error / unit - 1e-9), ".0e")


def _fault(cell: ModelCell, symbols: Sequence[str]) -> str:
    """Text on why a cell is not good."""
    if not cell.right:
        return cell.regime
    worst = max((symbol for symbol in symbols if symbol in cell.figures), key=lambda symbol: cell.figures[symbol].size)
    return f"{worst} {_span([cell.figures[worst].error])}"


def _trouble(row: ModelRow, table: ModelTable, symbols: Sequence[str]) -> str:
    """Why a model is to be avoided: up to where it has no cycles, and the range of its errors of the first quantity that is off
    somewhere."""
    silent = [
        (cell.regime, column)
        for cell, column in zip(row.cells, table.columns, strict=True)
        if not cell.figures and cell.regime not in UNKNOWN
    ]
    symbol = next((symbol for symbol in symbols if any(_is_off(cell, symbol) for cell in row.cells)), symbols[0])
    errors = [cell.figures[symbol].error for cell in row.cells if symbol in cell.figures]
    words = []
    if silent:
        regimes = " or ".join(dict.fromkeys(regime for regime, _ in silent))
        words.append(regimes + (f" up to {silent[-1][1].over_onset:.2f} r_{{c}}" if errors else ""))
    if errors:
        words.append(f"{symbol} {_span(errors)}")
    return ", then ".join(words)


def _span(errors: Sequence[float | None]) -> str:
    """The smallest and the largest error, in per cent."""
    ends = sorted((100.0 * error for error in errors if error is not None), key=abs)
    shown = list(dict.fromkeys(f"{end:+.{0 if abs(end) >= 10.0 else 1}f}" for end in (ends[0], ends[-1])))
    return minus(" to ".join(shown)) + " %"


def _largest(row: ModelRow, symbols: Sequence[str] = JUDGED) -> float:
    """The largest error of orbits; errors of means are limited by their scatter."""
    orbits = [cell.figures for cell in row.cells if not cell.cycles]
    return max((figures[symbol].size for figures in orbits for symbol in symbols if symbol in figures), default=0.0)


def costs_of_good_reductions(table: ModelTable) -> list[float]:
    """Costs, in every column where they are known, of the models without a grid that are good everywhere."""
    return [cost for row in _good_reductions(table) for cost in row.costs if cost is not None]


def _good_reductions(table: ModelTable) -> list[ModelRow]:
    return [row for row in table.rows if row.advice == "use" and row.model != table.reference]


def _sentences(table: ModelTable) -> Iterator[str]:
    """Sentences: what to use, a remark on costs, what to avoid."""
    good, also = _good_reductions(table), list[str]()
    if good:
        names, off = ([f"`{row.model}`" for row in good], [_most(_largest(row)) for row in good])
        also.append(f"{' or '.join(names)} (off by at most {' or '.join(dict.fromkeys(off))} where orbits repeat)")
    partly = [row for row in table.rows if row.advice.startswith("use up to") and not _is_witness(row)]
    also += [f"`{row.model}` {row.advice.removeprefix('use ')}" for row in partly]
    yield f"Use `{table.reference}`: it is exact{_news(table)}{'; where an ODE is needed, ' if also else ''}{', '.join(also)}."
    avoid = [f"`{row.model}` ({row.why})" for row in table.rows if row.advice == "avoid"]
    if avoid:
        yield f"Avoid {', '.join(avoid)}."


def _news(table: ModelTable) -> str:
    """Sentence on whether the exact system costs as little as any ODE that is good everywhere."""
    costs = costs_of_good_reductions(table)
    if not costs:
        return ""
    times = f"~{{{' to '.join(dict.fromkeys(f'{cost:.2g}' for cost in (min(costs), max(costs))))}}} times as long"
    if min(costs) * AS_CHEAP >= 1.0:
        return f" and costs as little as any ODE that is right to {100 * GOOD:g} % (those take {times})"
    return f"; ODEs that are right to {100 * GOOD:g} % take {times}"
