"""Every model from the onset to where the motion is irregular, and in other scenes: errors, regimes, costs; what to use."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product

import numpy as np

import slipwave
from validation.chart import WIDTH, Chart, Panel, Scale, Trace
from validation.chart.looks import model_marks
from validation.measure.memo import critical_r
from validation.measure.on_record import on_record
from validation.measure.over_r import scene_at
from validation.report import (
    Budget,
    Cell,
    Figure,
    Number,
    StudyResult,
    Table,
    Verdicts,
    minus,
    places,
    power,
    stated,
)
from validation.report import table as tabled
from validation.report.compared import EXACT_MODEL, GOOD, compared_table, onset, relative_costs
from validation.report.model_table import ModelColumn, ModelRow, ModelTable
from validation.studies.which_model import judged, laws, periods
from validation.studies.which_model.judged import ByModel
from validation.studies.which_model.motions import CELLS, TOLERANCE, WAVE, paper_at, regime_at, regime_in

ELSEWHERE = {
    "unlike": "slabs that differ, the lower one with twice the round trip and three times the impedance",
    "grip": "outer faces in grips that reflect half of every wave but keep the load",
    "machine": "slabs driven by a testing machine: spring, dashpot and mass",
    "layered": "slabs of two layers, the outer one with twice the impedance",
    "slip-law": "the paper’s slabs under Ruina’s slip law",
    "rock": "Table 1’s rock in SI, at 1 cm/s",
}
"""Scene of the gallery -> its description."""
OVER_ONSET = (1.02, 1.25)
"""r over the onset of the exact system, both slabs scaled together."""
_NONE = 1e-3  # a bias that is not mentioned
_NUDGE = 0.5  # of ψ: a small one grows for thousands of transits near the onset; from 2 the ODE runs away under the slip law

NAME = "which-model"
QUESTION = "Which model may I use, at what error, at what cost?"
SCENES = ("paper", *ELSEWHERE)
SECONDS = (12.0, 30.0)

ORBITS = ("modal:8", "modal:4", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12")
"""The reductions with a stable orbit wherever the exact system has one."""
EVERY = (EXACT_MODEL, WAVE, *ORBITS, "quasidynamic", "quasistatic")
IN_SCENES = (*EVERY[:6], "fitted:4", *EVERY[6:])
"""The rows of the table of the paper's scene; that of the others has a rational fit besides."""
SHOWN = (-2.69, -2.68, -2.66)
"""log10 r at which the exact system's orbit is stable; the second one is the paper's."""
BEYOND = (-2.65, -2.6, -2.55, -2.5, -2.4, -2.3)
_COSTED = (-2.68, -2.5)
_LEAST = 1e-13  # the smallest error that is drawn


def run(budget: Budget) -> StudyResult:
    """Every model's regime, orbits and means at every r, and its cost at two; in other scenes; over r; laws of the errors."""
    beyond, rounds = budget.plan(quick=(-2.65, -2.5), full=BEYOND), budget.plan(quick=3, full=7)
    grid, there = (*SHOWN, *beyond), places_of(budget.plan(quick=["unlike", "grip", "rock"], full=[*ELSEWHERE]))
    regimes = {
        model: {x: on_record(model, paper_at(x)) or regime_at(model, x) for x in grid} for model in budget.each(EVERY, 0.4)
    }
    table = _the_table(regimes, {_title(x): _costs_at(x, rounds) for x in _COSTED})
    others = _in_scenes(there, budget)
    branches = periods.branches_of(*budget.plan(quick=(-2.64, 74.6), full=(-2.3, 80.0)))
    budget.report(0.8)
    seen = periods.periods_of(branches, regimes)
    onsets = laws.measure_onsets(scene_at(SHOWN[1]))
    scales = budget.plan(quick=(2.0, laws.HALF), full=(2.0, 1.0, laws.HALF, 0.25, 0.125))
    cycles = [laws.measure_cycle(scene_at(SHOWN[1]), scale) for scale in budget.each(scales, begin=0.85)]
    return StudyResult(
        answers={
            " ".join(table.sentences): _RESTS_ON,
            _scene_answer(others): ("The ODEs that", "No model that"),
            periods.period_answer(seen): ("P7 ", "Periods over r"),
            laws.law_answer(onsets, cycles): ("A reduction’s", "The paper’s ODE tends"),
        },
        figures=(
            Figure("cost-error", _COST_ERROR, lambda: _cost_and_error(table), timed=True),
            Figure("over-r", periods.CAPTION, lambda: periods.over_r(branches, seen), paper="Fig 8", carries=_CARRIES, zoom=True),
            Figure("laws", laws.CAPTION, lambda: laws.fall(onsets, cycles)),
        ),
        tables=(_bias_table(others),),
        verdicts=(
            *_verdicts(table, others, regimes, there),
            *judged.record_verdicts(),
            *periods.period_verdicts(seen),
            *laws.law_verdicts(onsets, cycles),
        ),
        numbers=_numbers(table, regimes)
        | _scene_numbers(others, ("kelvin-voigt", "modal:4", "fitted:4", "block12"))
        | periods.period_numbers(seen, beyond)
        | laws.law_numbers(cycles),
        model_tables=(table, others),
    )


_RESTS_ON = (
    "Runs ",
    "The full ",
    "Where cycles ",
    "The slabs’ ",
    "Every ",
    "The quasi",
    "No ODE ",
    "The paper’s ODE falls",
    "Means ",
)
_CARRIES = ("P3 ", "P4 ", "P7 ", "P12 ")


def place(name: str, over_onset: float) -> ModelColumn:
    """The column of a scene with both slabs scaled together to r = `over_onset` times the onset of the exact system."""
    own = slipwave.read(name)
    factor = over_onset * critical_r(EXACT_MODEL, own) / own.transit
    if own.upper.material and own.units:
        settings = [f"slab.thickness={factor * 0.5 * own.transit * own.units.time * own.upper.material.wave_speed:.6g}"]
    else:
        slabs = {"slab": own.upper} if own.alike else {"upper": own.upper, "lower": own.lower}
        settings = [f"{key}.r={factor * slab.round_trip:.7g}" for key, slab in slabs.items()]
    settings.append(f"start.size={_NUDGE:g}")
    scene, words = slipwave.read(name, settings), " ".join(f"--set {setting}" for setting in settings)
    return ModelColumn(name, math.log10(scene.transit), over_onset, f"r = {over_onset:.2f} r_{{c}}", f"{name} {words}")


def places_of(names: Iterable[str] = tuple(ELSEWHERE)) -> list[ModelColumn]:
    """Columns of the table of scenes, by r over the onset."""
    return [place(name, over_onset) for over_onset, name in product(OVER_ONSET, names)]


def _title(log10_r: float) -> str:
    return places([log10_r], ".2f")


def _the_table(regimes: ByModel, costs: Mapping[str, Mapping[str, float]]) -> ModelTable:
    """The first table of the page."""
    paper = scene_at(SHOWN[1])
    onsets = {model: onset(model, paper) for model in regimes}
    exact = math.log10(critical_r(EXACT_MODEL, paper))
    columns = [ModelColumn(_title(x), x, 10.0 ** (x - exact), "", paper_at(x)) for x in regimes[EXACT_MODEL]]
    caption = (
        f"Errors relative to the exact delay system, in the paper’s scene (V = {paper.velocity:g} V*) from its onset at "
        f"log_{{10}} r_{{c}} = {places([exact], '.5f')} on; r: round trip of a wave through one slab, in L/V*; cost: processor "
        f"time. {_CAPTION}"
    )
    rows = {model: list(by_r.values()) for model, by_r in regimes.items()}
    return compared_table("paper", caption, "log_{10} r", columns, rows, onsets, costs)


_CAPTION = (
    "Where no orbit of the delay system is stable: means over cycles with two standard errors (±), of v_{max} medians; elsewhere"
    f" orbits. A model is good at an r if its regime is that of the delay system and T and Δμ err by less than {100 * GOOD:g} "
    "%, or by no more than that and two standard errors (a full wave: four); the advice is to use it up to the last r before the "
    "first at which it is not. Long means are on record; on another kind of processor the commands of irregular motions give "
    "other digits, within the errors. Cost: of 1000 transits, the median of several rounds, over that of the delay system."
)


def _costs_at(log10_r: float, rounds: int) -> dict[str, float]:
    """Cost of every model with a lasting motion there."""
    return relative_costs([model for model in EVERY if model != "quasistatic"], {WAVE: CELLS}, scene_at(log10_r), rounds)


def _in_scenes(others: Sequence[ModelColumn], budget: Budget) -> ModelTable:
    """The same models in other scenes."""
    regimes = {
        model: [on_record(model, column.settings) or regime_in(model, column.settings) for column in others]
        for model in budget.each(IN_SCENES, 0.7, 0.4)
    }
    words = "; ".join(f"`{name}`: {what}" for name, what in ELSEWHERE.items() if any(name == column.title for column in others))
    caption = (
        f"Errors at r over the onset r_{{c}} of the exact system, by runs from a nudge of {_NUDGE:g}, with advice by the rule of "
        f"the first table, in other scenes ({words}); –: not for this scene."
    )
    return compared_table("scenes", caption, "scene", others, regimes, {}, {})


def _verdicts(paper: ModelTable, elsewhere: ModelTable, regimes: ByModel, others: Sequence[ModelColumn]) -> Verdicts:
    """All verdicts on both tables."""
    grid = [*regimes[WAVE]]
    coarse = (
        (paper, lambda column: regime_at(WAVE, grid[column], cells=CELLS - 1), TOLERANCE),
        (elsewhere, lambda column: regime_in(WAVE, others[column].settings, cells=CELLS - 1), TOLERANCE),
    )
    for table, on_coarse, run_error in coarse:
        yield from judged.regime_verdicts(table)
        yield from judged.wave_verdicts(table, on_coarse, CELLS, run_error)
        yield from judged.mean_verdicts(table)
    yield from judged.paper_verdicts(paper, [_title(x) for x in SHOWN], _title(SHOWN[1]))
    yield judged.run_verdict(regimes)
    yield from judged.scene_verdicts(elsewhere)


def _numbers(table: ModelTable, regimes: ByModel) -> dict[str, Number]:
    """Errors of orbits and onsets; figures of the quasi-dynamic orbits. Means of irregular motions differ between machines."""
    shown = {_title(x): x for x in SHOWN}
    numbers = {
        f"{row.model} error of {symbol} at {shown[column.title]}": stated(figure.error, figure.standard_error)
        for column, row, cell in judged.cells_of(table, *ORBITS)
        if column.title in shown
        for symbol, name in _NAMES.items()
        if (figure := cell.figures.get(name)) and figure.error is not None
    }
    damped = {x: regime.figures["T"] for x, regime in regimes["quasidynamic"].items() if regime.figures}
    numbers |= {f"quasidynamic T at {x}": stated(period.value, period.error) for x, period in damped.items()}
    known = {row.model: row.onset.error for row in table.rows if row.onset and row.onset.error}
    return numbers | {f"{model} error of onset": Number(off, max(1e-6, 1e-13 / abs(off))) for model, off in known.items()}


def _bias_table(table: ModelTable) -> Table:
    """Bias and scatter of each model over all scenes."""
    ranges = (("T", OVER_ONSET[0]), ("Δμ", OVER_ONSET[0]), ("T", OVER_ONSET[1]))
    rows: list[list[Cell]] = [
        [row.model, *(100.0 * value for what in ranges for value in _bias_and_scatter(table, row, *what))]
        for row in table.rows[1:]
    ]
    numbers = "bias [%] .2f | scatter [%] .2f | statistical [%] .2f"
    heading = " | ".join(["model", *(f"{symbol}, {over_onset:g} r_{{c}}: {numbers}" for symbol, over_onset in ranges)])
    caption = (
        "Bias (mean error) and scatter (standard deviation) of each model over these scenes, and the part of the scatter that "
        "means themselves have (root mean square of their standard errors). A dash: no cycles."
    )
    return tabled("bias", caption, heading, rows)


def _bias_and_scatter(table: ModelTable, row: ModelRow, symbol: str, over_onset: float) -> tuple[float, float, float]:
    """(mean, standard deviation over scenes, root mean square of the standard errors) of the errors of a quantity at this r over
    the onset; NaN for too few errors."""
    cells = [cell for column, cell in zip(table.columns, row.cells, strict=True) if column.over_onset == over_onset]
    errors = [figure for cell in cells if (figure := cell.figures.get(symbol)) and figure.error is not None]
    values, own = (np.array([getattr(figure, name) for figure in errors], dtype=float) for name in ("error", "standard_error"))
    if not values.size:
        return math.nan, math.nan, math.nan
    return values.mean(), values.std(ddof=1) if values.size > 1 else math.nan, np.sqrt((own**2).mean())


def _scene_answer(table: ModelTable) -> str:
    """Whether the advice holds in these scenes, and how far off the models to be avoided are near the onset."""
    good = [f"`{row.model}`" for row in table.rows[1:] if row.advice == "use"]
    known = ((row.model, _bias_and_scatter(table, row, "T", OVER_ONSET[0])) for row in table.rows if row.advice == "avoid")
    words = [
        f"`{model}` " + minus(f"{100 * bias:+z.1f}{f' ± {100 * scatter:.1f}' if math.isfinite(scatter) else ''} %")
        for model, (bias, scatter, _) in known
        if abs(bias) > _NONE
    ]
    count, near = len({column.title for column in table.columns}), f"{OVER_ONSET[0]:g} r_{{c}}"
    return (
        f"The advice holds in {count} other scenes: {', '.join(good)} are right to 1 %. Bias and scatter of T at {near} "
        f"are {', '.join(words)}; `quasidynamic` slides steadily."
    )


def _scene_numbers(table: ModelTable, models: Sequence[str]) -> dict[str, Number]:
    """Errors of T of these models where cycles repeat, with the accuracy of runs."""
    return {
        f"{column.title}: {row.model} error of T at {column.over_onset:g}": Number(
            figure.error, max(1e-3, 3e-7 / abs(figure.error))
        )
        for row in table.rows
        for column, exact, cell in zip(table.columns, table.rows[0].cells, row.cells, strict=True)
        if row.model in models and not cell.cycles and not exact.cycles and (figure := cell.figures.get("T")) and figure.error
    }


_NAMES = {"T": "T", "drop": "Δμ", "v_max": "v_{max}"}
_COST_ERROR = (
    f"Error of the period over cost at log_{{10}} r = {places(_COSTED)} (filled, open), against the exact delay system, which "
    f"is drawn at {power(_LEAST)}: one point for each model that has cycles there. Bars: two standard errors of means."
)


def _cost_and_error(table: ModelTable) -> Chart:
    """One point for each model and each of the two r."""
    titles, traces, keys = [column.title for column in table.columns], list[Trace](), dict[str, Trace]()
    for row in table.rows:
        for number, (title, cost) in enumerate(zip(table.costed, row.costs, strict=True)):
            figure = row.cells[titles.index(title)].figures.get("T")
            if figure and cost is not None:
                size, bar = (
                    [figure.size],
                    [2.0 * figure.standard_error] if number and figure.error is not None else None,
                )
                name, look = row.model, model_marks(row.model, hollow=bool(number))
                traces.append(Trace(f"{name}, {title}" if number else name, [cost], size, look, y_error=bar))
                keys.setdefault(row.model, traces[-1])
    ticks = {value: f"{value:g}" for value in (0.1, 0.3, 1.0, 3.0)}
    axes = Scale("cost, delay system = 1", "log", ticks=ticks), Scale("relative error of $T$", "log", floor=_LEAST)
    panel, width = Panel("", *axes, traces, grid=True), 0.75 * WIDTH
    return Chart([panel], 2.9, width=width, legend="outside right center", keys=[*keys.values()])
