"""Every model from the onset to where the motion is irregular: errors, regimes, costs; what to use and what to avoid."""

from typing import Any

import numpy as np

from validation.studies.which_model import measured
from validation.studies.which_model.measured import DAMPED, MODELS, SHOWN, WAVE, Runs, error, log10_onsets
from validation.study import Budget, Figure, Number, Omission, StudyResult, stated
from validation.study.compared import Sight, compared_table, relative_costs
from validation.study.drawing import WIDTH, Drawing, line, pen, ruled, subplots
from validation.study.memo import cycle_of, own_orbit
from validation.study.model_table import ModelTable
from validation.study.over_r import begun_at, scene_at
from validation.study.text import places, power
from validation.timing import Setting, warm_up

NAME = "which-model"
QUESTION = "Which model may I use, at what error, at what cost?"
SCENES = ("paper",)
SECONDS = (8.0, 20.0)

EVERY = ("delay", WAVE, "modal:8", "modal:4", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12", DAMPED, "quasistatic")
"""The rows of the table."""
_NEAR_ONSET: dict[bool, tuple[float, ...]] = {True: (), False: (-2.699, -2.695)}
"""By quick or full report: log10 r of orbits from the onset, -2.69955, on, beside those of the table; the exact one loses its
stability at -2.6575."""
_BEYOND = {True: (-2.65, -2.5), False: (-2.65, -2.6, -2.55, -2.5, -2.4, -2.3)}
_UNTIL = {True: 6000.0, False: 10000.0}
_SETTLED = 4000.0  # transits of a run to a stable orbit
_COSTED, _ROUNDS = (-2.68, -2.5), {True: 3, False: 7}
_LEAST = 1e-13
"""The smallest error that is drawn."""
_WAVE_COLOUR = "#a6761d"  # its own pen is as black and round as the delay system's
_DRAWN = ("delay", "modal:1", "kelvin-voigt", "block12")
_AROUND = 4.0  # transits before and after the cycle that is drawn


def run(budget: Budget) -> StudyResult:
    """Every model's regime, orbits and means at every r, and its cost at two."""
    places_of_r = (*SHOWN, *_BEYOND[budget.quick])
    regimes = {
        model: [measured.regime_at(model, x, _SETTLED if x in SHOWN else _UNTIL[budget.quick]) for x in places_of_r]
        for model in budget.each(EVERY, end=0.7)
    }
    orbits, means = measured.parted(regimes, places_of_r)
    for model in ("delay", *MODELS, "fitted:4"):
        more = SHOWN if model == "fitted:4" else _NEAR_ONSET[budget.quick]
        orbits[model] = {x: measured.orbit_of(model, x) for x in more} | orbits.get(model, {})
    table = the_table(regimes, places_of_r, _ROUNDS[budget.quick])
    return StudyResult(
        answer=" ".join(table.sentences),
        figures=(
            Figure("cycle", _CYCLE, one_period),
            Figure("cost-error", _COST_ERROR, lambda: cost_and_error(table), timed=True),
            Figure("errors", _CAPTION, lambda: errors_over_r(orbits)),
            Figure("deep", _DEEP_CAPTION, lambda: errors_of_means(means)),
        ),
        verdicts=measured.all_verdicts(orbits, means, table),
        numbers=_numbers(orbits, means, table),
        omissions=omissions(orbits),
        model_tables=(table,),
    )


def the_table(regimes: measured.ByModel, grid: tuple[float, ...], rounds: int) -> ModelTable:
    """The table of the first screen."""
    exact, _ = log10_onsets()
    sights = [Sight(places([x], ".2f"), scene_at(x), 10.0 ** (x - exact), f"--set slab.log10_r={x:g}") for x in grid]
    costs = {places([x], ".2f"): costs_at(x, rounds) for x in _COSTED}
    return compared_table("paper", _TABLE, sights, regimes, costs)


def costs_at(log10_r: float, rounds: int) -> dict[str, float]:
    """Cost of every model that has a motion to march there."""
    timed = [model for model in EVERY if model != "quasistatic"]
    cells = {WAVE: measured.CELLS}
    for model in timed:
        warm_up(Setting(model, cells=cells.get(model)), scene_at(log10_r))
    return relative_costs(timed, cells, scene_at(log10_r), rounds)


def _numbers(orbits: Runs, means: Runs, table: ModelTable) -> dict[str, Number]:
    """Errors of orbits and onsets; figures of the quasi-dynamic orbits. Means of irregular motions differ from machine to
    machine."""
    found = {
        f"{model} error of {symbol} at {log10_r}": stated(off.value, off.error)
        for model in MODELS
        for log10_r in SHOWN
        for symbol, name in (("T", "period"), ("drop", "drop"), ("v_max", "v_max"))
        for off in [error(orbits, model, log10_r, name)]
    }
    found |= {f"{DAMPED} T at {x}": Number(figures.period.value, 1e-8) for x, figures in means[DAMPED].items() if figures}
    known = {row.model: row.onset.error for row in table.rows if row.onset and row.onset.error}
    return found | {f"{model} error of onset": Number(off, max(1e-6, 1e-13 / abs(off))) for model, off in known.items()}


_TABLE = (
    "Relative errors against the exact delay system: of orbits where its own is stable (by Newton’s method, the full wave’s by a "
    "run), beyond of means over the cycles of a run, with two standard errors. The row of the delay system has its own values. A "
    "regime is the verdict on a run. A model is good at an r if its regime is that of the delay system, and T and Δμ err by less "
    "than 1 %, or by no more than 1 % and two standard errors; the advice is to use it everywhere, up to the last r before the "
    "first where it is not good, or not at all. Cost: processor time of 1000 transits over that of the delay system."
)
_CYCLE = (
    "One cycle of the paper’s scene: stress μ (σ) over time (transits), each model on its own orbit, from its slip event on. The "
    "full wave lies on the delay system."
)
_COST_ERROR = (
    f"Error of the period over cost at log_{{10}} r = {places(_COSTED)} (filled, open), both against the exact delay system: one "
    "point for each model that has cycles there. Bars: two standard errors of means, only upwards where the error may be zero. "
    f"The delay system itself is drawn at {power(_LEAST)}."
)
_CAPTION = (
    "Relative error of period T (left) and stress drop Δμ (right) of each reduction’s orbit against the delay system’s, by "
    "Newton’s method, over r from the onset to where the exact orbit loses stability. A dip is a change of sign."
)
_DEEP_CAPTION = (
    "The same beyond, where no orbit of the delay system is stable: signed differences of the means of T and Δμ over the "
    "cycles of a long run. Bars: two standard errors, which allow for the dependence of a cycle on those before it."
)


_QUANTITIES = {"period": "period $T$", "drop": r"stress drop $\Delta\mu$"}
_SPREAD = 0.003  # log10 r: models beside each other at one r, so that their bars can be told apart


def omissions(orbits: Runs) -> tuple[Omission, ...]:
    """Orbits that were not found."""
    lost = [f"`{model}` at {places([x])}" for model in ("delay", *MODELS) for x, orbit in orbits[model].items() if not orbit]
    return (Omission("Points where no orbit was found.", f"{', '.join(lost)}."),) if lost else ()


def one_period() -> Drawing:
    """Stress over one cycle of some models."""
    figure, axes = subplots(2.9, 1, 1, "time since the slip event (transits)", r"stress $\mu$ ($\sigma$)", 0.75 * WIDTH)
    for model in _DRAWN:
        cycle = cycle_of(own_orbit(model, begun_at(SHOWN[1]), measured.TOLERANCE).closed, _AROUND, _AROUND)
        axes.plot(cycle.time, cycle.stress, **line(model))
    figure.legend(loc="outside upper left", ncols=2, handlelength=3.0)
    return figure


def cost_and_error(table: ModelTable) -> Drawing:
    """One point for each model and each of the two r."""
    figure, axes = subplots(2.9, 1, 1, "cost, delay system = 1", "relative error of $T$", 0.75 * WIDTH)
    titles = [column.title for column in table.columns]
    for row in table.rows:
        for number, title in enumerate(table.costed):
            found, cost = row.cells[titles.index(title)].figures.get("T"), row.costs[number]
            if found is None or cost is None:
                continue
            look, size, bar = pen(row.model), abs(found.error or 0.0), 2.0 * found.standard_error
            axes.errorbar(
                [cost],
                [max(_LEAST, size)],
                None if found.error is None else [[bar if bar < size else 0.0], [bar]],
                color=_WAVE_COLOUR if row.model == WAVE else look.color,
                marker=look.marker,
                markerfacecolor="white" if number else None,
                linestyle="none",
                label=None if number else look.label,
            )
    axes.set(xscale="log", yscale="log")
    axes.set_xticks([0.1, 0.3, 1.0, 3.0], ["0.1", "0.3", "1", "3"])
    axes.minorticks_off()
    ruled(axes)
    figure.legend(loc="outside right center", fontsize=8)
    return figure


def errors_over_r(orbits: Runs) -> Drawing:
    """Absolute errors of the orbits' periods and drops; a missing orbit leaves a gap."""
    figure, panels = _panels("relative error")
    for axes, quantity in zip(panels, _QUANTITIES, strict=True):
        for model in MODELS:
            look = line(model, marker=pen(model).marker, linewidth=1.1)
            axes.semilogy(list(orbits["delay"]), measured.column(orbits, model, quantity), **look)
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=4, handlelength=3.0)
    return figure


def errors_of_means(means: Runs) -> Drawing:
    """Signed differences of the means, in per cent, with two standard errors."""
    figure, panels = _panels("difference of the means (%)")
    grid = np.array(list(means["delay"]))
    for axes, quantity in zip(panels, _QUANTITIES, strict=True):
        for place, model in enumerate((*MODELS, DAMPED)):
            values = 100.0 * measured.column(means, model, quantity, lambda one: one.value)
            bars = 200.0 * measured.column(means, model, quantity, lambda one: one.error)
            at = grid + _SPREAD * (place - 0.5 * len(MODELS))
            look = line(model, linestyle="none", linewidth=1.0, marker=pen(model).marker)
            axes.errorbar(at, values, bars, capsize=2.0, **look)
        axes.axhline(0.0, color="#111111", linewidth=0.8)
    figure.legend(handles=panels[0].containers, loc="outside upper left", ncols=4, handlelength=3.0)
    return figure


def _panels(shown: str) -> tuple[Drawing, Any]:
    """Two panels side by side, what is `shown` of period and drop over r."""
    figure, panels = subplots(4.4, 1, 2, r"$\log_{10} r$", shown, sharey=True)
    for axes, title in zip(panels, _QUANTITIES.values(), strict=True):
        axes.set_title(title)
        ruled(axes)
    return figure, panels
