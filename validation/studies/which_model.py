"""Every model from the onset to where the motion is irregular: errors, regimes, costs; what to use and what to avoid."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import pairwise, product
from typing import Any, cast

import numpy as np

from reduced.impedance import reduction_of
from reduced.impedance.fit import exact_impedance
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate
from validation.compute.settle import estimate
from validation.references.onset import onset_of
from validation.study import Budget, Figure, Number, Omission, StudyResult, memo, stated
from validation.study.advice import AS_CHEAP, GOOD, costs_of_good_reductions
from validation.study.compared import Sight, against, compared_table, relative_costs
from validation.study.drawing import WIDTH, Drawing, line, ruled, style_of, subplots
from validation.study.known import ERRORS, OTHERS, as_known, error_after, error_of
from validation.study.memo import cycle_of, own_orbit
from validation.study.model_table import ModelTable
from validation.study.over_r import begun_at, scene_at
from validation.study.regimes import AWAY, STEADY, CycleFigures, Regime, regime_of
from validation.study.text import places, plain, power
from validation.study.verdict import EXACT, PAPER, SELF, WITNESS, Outcome, Verdict, claim, every, holding, in_range
from validation.timing import Setting, warm_up

NAME = "which-model"
QUESTION = "Which model may I use, at what error, at what cost?"
SCENES = ("paper",)
SECONDS = (8.0, 20.0)

MODELS = ("block12", "block8", "kelvin-voigt", "modal:1", "modal:2", "modal:4", "modal:8")
"""The reductions with a stable orbit wherever the exact system has one."""
DAMPED = "quasidynamic"
"""Model that slides steadily up to its own onset, and has a stable orbit beyond."""
WAVE, CELLS = "dg:7", 3
"""The full wave, propagated exactly in time, and its cells per slab: its orbit is accurate to ten digits."""
SHOWN = (-2.69, -2.68, -2.66)
"""log10 r at which the exact system's orbit is stable."""
TARGETS = {"modal:1": 1e-3, "modal:2": 1e-5}
"""Model -> largest error of the period of the paper's scene."""
SHORT = (0.35, 0.6)
"""Least and largest share by which the quasi-dynamic period is short beyond its onset."""
RUN_AT = -2.5
"""log10 r of a direct run of the quasi-dynamic model."""
TOLERANCE = 1e-9

_JUDGED = ("period", "drop")
_LADDER = ("modal:1", "modal:2", "modal:4", "modal:8")
_AS_WAVES = (WAVE, "modal:4", "modal:8")
_REPEATING = ("block12", "block8", "kelvin-voigt", "modal:1")
_PRINTED = 1.0 - 70.73 / 73.5
_HALF_DIGITS = 0.05 / 73.5 + 0.005 / 70.73
_SHIFT, _SAMPLES = 0.2, 400  # of the line on which the impedance is sampled, per transit
_FITTED = 1e-12  # relative error of a rational fit
_REPEATED = 4000.0  # transits of a run whose cycles repeat

ByModel = Mapping[str, Sequence[Regime]]
"""model -> its regime at every r in turn."""
Runs = dict[str, dict[float, CycleFigures | None]]
"""model -> log10 r -> its orbit, or its mean; None where there is none."""

EVERY = ("delay", WAVE, "modal:8", "modal:4", "modal:2", "modal:1", "kelvin-voigt", "block8", "block12", DAMPED, "quasistatic")
"""The rows of the table."""
_NEAR_ONSET: dict[bool, tuple[float, ...]] = {True: (), False: (-2.699, -2.695)}
"""Quick report -> log10 r of further orbits, from the onset at -2.69955; the exact orbit loses stability at -2.6575."""
_BEYOND = {True: (-2.65, -2.5), False: (-2.65, -2.6, -2.55, -2.5, -2.4, -2.3)}
_UNTIL = {True: 6000.0, False: 10000.0}
_SETTLED = 4000.0  # transits of a run to a stable orbit
_COSTED, _ROUNDS = (-2.68, -2.5), {True: 3, False: 7}
_LEAST = 1e-13
"""The smallest error that is drawn."""
_WAVE_COLOUR = "#a6761d"  # its own plot style is as black and round as the delay system's
_DRAWN = ("delay", "modal:1", "kelvin-voigt", "block12")
_AROUND = 4.0  # transits before and after the cycle that is drawn


def run(budget: Budget) -> StudyResult:
    """Every model's regime, orbits and means at every r, and its cost at two."""
    places_of_r = (*SHOWN, *_BEYOND[budget.quick])
    regimes = {
        model: [regime_at(model, x, _SETTLED if x in SHOWN else _UNTIL[budget.quick]) for x in places_of_r]
        for model in budget.each(EVERY, end=0.7)
    }
    orbits, means = parted(regimes, places_of_r)
    for model in ("delay", *MODELS, "fitted:4"):
        more = SHOWN if model == "fitted:4" else _NEAR_ONSET[budget.quick]
        orbits[model] = {x: own_figures_of(model, x) for x in more} | orbits.get(model, {})
    table = _the_table(regimes, places_of_r, _ROUNDS[budget.quick])
    return StudyResult(
        answer=" ".join(table.sentences),
        figures=(
            Figure("cycle", _CYCLE, one_period),
            Figure("cost-error", _COST_ERROR, lambda: cost_and_error(table), timed=True),
            Figure("errors", _CAPTION, lambda: _errors_over_r(orbits)),
            Figure("deep", _DEEP_CAPTION, lambda: _errors_of_means(means)),
        ),
        verdicts=verdicts_on_models(orbits, means, table),
        numbers=_numbers(orbits, means, table),
        omissions=omissions(orbits),
        model_tables=(table,),
    )


def _the_table(regimes: ByModel, grid: tuple[float, ...], rounds: int) -> ModelTable:
    exact, _ = log10_onsets()
    sights = [Sight(places([x], ".2f"), scene_at(x), 10.0 ** (x - exact), f"--set slab.log10_r={x:g}") for x in grid]
    costs = {places([x], ".2f"): costs_at(x, rounds) for x in _COSTED}
    return compared_table("paper", _caption(), sights, regimes, costs)


def _caption() -> str:
    """What the table shows, of which scene."""
    scene, (onset, _) = scene_at(SHOWN[0]), log10_onsets()
    return (
        f"Errors relative to the exact delay system, in the paper’s scene (V = {scene.velocity:g} V*) from its onset at "
        f"log_{{10}} r_{{c}} = {places([onset], '.5f')} on; r: round trip of a wave through one slab, in L/V*; cost: processor "
        f"time. {_TABLE}"
    )


def costs_at(log10_r: float, rounds: int) -> dict[str, float]:
    """Cost of every model with a lasting motion there."""
    timed = [model for model in EVERY if model != "quasistatic"]
    cells = {WAVE: CELLS}
    for model in timed:
        warm_up(Setting(model, cells=cells.get(model)), scene_at(log10_r))
    return relative_costs(timed, cells, scene_at(log10_r), rounds)


def _numbers(orbits: Runs, means: Runs, table: ModelTable) -> dict[str, Number]:
    """Errors of orbits and onsets; figures of the quasi-dynamic orbits. Means of irregular motions differ between machines."""
    found = {
        f"{model} error of {symbol} at {log10_r}": stated(off.value, off.error)
        for model in MODELS
        for log10_r in SHOWN
        for symbol, name in (("T", "period"), ("drop", "drop"), ("v_max", "v_max"))
        for off in [error_against_delay(orbits, model, log10_r, name)]
    }
    damped = {x: figures.period for x, figures in means[DAMPED].items() if figures}
    found |= {f"{DAMPED} T at {x}": stated(period.value, period.error) for x, period in damped.items()}
    known = {row.model: row.onset.error for row in table.rows if row.onset and row.onset.error}
    return found | {f"{model} error of onset": Number(off, max(1e-6, 1e-13 / abs(off))) for model, off in known.items()}


_TABLE = (
    "Bars (±): two standard errors of means over cycles, where no orbit of the delay system is stable; elsewhere orbits, by"
    " Newton’s method, the full wave’s by a run. The row of the delay system has its own values. A regime is the verdict on"
    " a run. A model is good at an r if its regime is that of the delay system, and T and Δμ err by less than 1 %, or by no"
    " more than 1 % and two standard errors (a full wave: four); the advice is to use it everywhere, up to the last r "
    "before the first where it is not good, or not at all. Cost: processor time of 1000 transits over that of the delay "
    "system, the median of several rounds."
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
_SPREAD = 0.003  # log10 r: horizontal offset of models at one r, which separates their bars


def omissions(orbits: Runs) -> tuple[Omission, ...]:
    """Orbits that were not computed, with the reason."""
    lost = [f"`{model}` at {places([x])}" for model in ("delay", *MODELS) for x, orbit in orbits[model].items() if not orbit]
    return (Omission("Points where no orbit was found.", f"{', '.join(lost)}."),) if lost else ()


def one_period() -> Drawing:
    """Stress over one cycle of some models."""
    figure, axes = subplots(2.9, 1, 1, "time since the slip event (transits)", r"stress $\mu$ ($\sigma$)", 0.75 * WIDTH)
    for model in _DRAWN:
        cycle = cycle_of(own_orbit(model, begun_at(SHOWN[1]), TOLERANCE).closed, _AROUND, _AROUND)
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
            look, size, bar = style_of(row.model), abs(found.error or 0.0), 2.0 * found.standard_error
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


def _errors_over_r(orbits: Runs) -> Drawing:
    figure, panels = _panels("relative error")
    for axes, quantity in zip(panels, _QUANTITIES, strict=True):
        for model in MODELS:
            look = line(model, marker=style_of(model).marker, linewidth=1.1)
            axes.semilogy(list(orbits["delay"]), column(orbits, model, quantity), **look)
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=4, handlelength=3.0)
    return figure


def _errors_of_means(means: Runs) -> Drawing:
    figure, panels = _panels("difference of the means (%)")
    grid = np.array(list(means["delay"]))
    for axes, quantity in zip(panels, _QUANTITIES, strict=True):
        for k, model in enumerate((*MODELS, DAMPED)):
            values = 100.0 * column(means, model, quantity, lambda one: one.value)
            bars = 200.0 * column(means, model, quantity, lambda one: one.error)
            at = grid + _SPREAD * (k - 0.5 * len(MODELS))
            look = line(model, linestyle="none", linewidth=1.0, marker=style_of(model).marker)
            axes.errorbar(at, values, bars, capsize=2.0, **look)
        axes.axhline(0.0, color="#111111", linewidth=0.8)
    figure.legend(handles=panels[0].containers, loc="outside upper left", ncols=4, handlelength=3.0)
    return figure


def _panels(shown: str) -> tuple[Drawing, Any]:
    """Two panels, the `shown` errors of period and drop over r."""
    figure, panels = subplots(4.4, 1, 2, r"$\log_{10} r$", shown, sharey=True)
    for axes, title in zip(panels, _QUANTITIES.values(), strict=True):
        axes.set_title(title)
        ruled(axes)
    return figure, panels


def regime_at(model: str, log10_r: float, until: float) -> Regime:
    """The regime of a run of the model; the reductions' orbits by Newton's method."""
    grid = {"cells": CELLS} if model == WAVE else {"tolerance": TOLERANCE}
    return regime_of(model, scene_at(log10_r), until, **cast(Any, grid))


def parted(regimes: ByModel, grid: Sequence[float]) -> tuple[Runs, Runs]:
    """(orbits where the exact one is stable, figures beyond)."""
    at = {model: {x: one.figures for x, one in zip(grid, found, strict=True)} for model, found in regimes.items()}
    inside = {model: {x: one for x, one in by_r.items() if x in SHOWN} for model, by_r in at.items()}
    return inside, {model: {x: one for x, one in by_r.items() if x not in SHOWN} for model, by_r in at.items()}


def own_figures_of(model: str, log10_r: float, cells: int | None = None) -> CycleFigures | None:
    """The model's own orbit by Newton's method; None if it has none."""
    try:
        return CycleFigures.of(memo.own_orbit(model, begun_at(log10_r), TOLERANCE, cells).orbit)
    except NumericsError:
        return None


def mean_at(model: str, log10_r: float) -> CycleFigures:
    """Means over the last cycles of a run."""
    return CycleFigures.of(estimate(memo.late_cycles(model, scene_at(log10_r), _REPEATED)))


def run_of_damped() -> CycleFigures:
    """The cycle on which a direct run of the quasi-dynamic model settles."""
    return CycleFigures.of(memo.settled(DAMPED, scene_at(RUN_AT), TOLERANCE, 1e-9).orbit)


@cache
def log10_onsets() -> tuple[float, float]:
    """log10 r from which on the exact system and the quasi-dynamic model stick and slip, by their closed forms."""
    scene = scene_at(SHOWN[0])
    found = onset_of(scene.law, scene.upper.epsilon, scene.velocity)
    return math.log10(found.r_delay), math.log10(found.r_quasidynamic)


def error_against_delay(runs: Runs, model: str, log10_r: float, quantity: str) -> Estimate:
    """Signed relative error of `period` or `drop` against the delay system; NaN where either has none."""
    ours, exact = runs[model].get(log10_r), runs["delay"].get(log10_r)
    if ours is None or exact is None:
        return Estimate(math.nan, math.nan)
    found = against(getattr(ours, quantity), getattr(exact, quantity))
    return Estimate(math.nan if found.error is None else found.error, found.standard_error)


def column(runs: Runs, model: str, quantity: str, part: Callable[[Estimate], float] = lambda one: abs(one.value)) -> Array:
    """A part of the errors of `model` at every r of the delay system, or their sizes."""
    return np.array([part(error_against_delay(runs, model, log10_r, quantity)) for log10_r in runs["delay"]])


def apart(one: CycleFigures | None, other: CycleFigures | None) -> float:
    """The larger relative difference of period and drop; NaN where one is missing."""
    if not one or not other:
        return math.nan
    return max(abs(one.period.value / other.period.value - 1.0), abs(one.drop.value / other.drop.value - 1.0))


def within(one: CycleFigures | None, other: CycleFigures | None) -> float:
    """How far the two may be apart by their errors."""
    return max(error_of(getattr(one, name), getattr(other, name)) for name in _JUDGED) if one and other else math.nan


def error_claims(orbits: Runs) -> Iterator[Verdict]:
    """Verdicts on the errors of the orbits at log10 r = -2.68, and on their decrease with the number of modes."""
    for model, limit in TARGETS.items():
        off = abs(error_against_delay(orbits, model, -2.68, "period").value)
        where = f"`{model}` at log_{{10}} r = −2.68, against the delay system"
        title = "The slabs’ exact modes give the period of the paper’s scene"
        yield claim(title, WITNESS, off, limit, where)
    short = -error_against_delay(orbits, "kelvin-voigt", -2.68, "period").value
    title = "The paper’s ODE falls short of the exact period by some 4 %"
    where = "printed: 70.73 against 73.5 transits, log_{10} r = −2.68; half of the last printed digits is allowed"
    expected, off = f"{100 * _PRINTED:.2f} ± {100 * _HALF_DIGITS:.2f} %", abs(short - _PRINTED)
    yield holding(title, PAPER, expected, f"{100 * short:.2f} %", off < _HALF_DIGITS, where).with_margin(off, _HALF_DIGITS)
    largest = [[float(np.nanmax(column(orbits, model, name))) for model in _LADDER] for name in _JUDGED]
    left = float(np.max([later / sooner for series in largest for sooner, later in pairwise(series)]))
    title = "Every doubling of the number of modes reduces the largest error over the range of r"
    where = "period and drop; 1, 2, 4, 8 modes. At a single r the error need not fall, since it changes sign along r"
    shown = f"of the period: {', '.join(plain(value, '.0e') for value in largest[0])}"
    yield claim(title, WITNESS, left, 1.0, where, shown, unit="of the error before")


def mean_claims(means: Runs, ran: dict[str, CycleFigures]) -> Iterator[Verdict]:
    """Means of wandering motions against the delay system's, and of orbits at the least r, computed by Newton's method, against
    the means `ran` over the cycles of a run there."""
    found = [error_against_delay(means, *one) for one in product(_AS_WAVES, means["delay"], _JUDGED)]
    off = max(abs(one.value) / one.error for one in found)
    title = (
        "Where no orbit is stable, the full wave, four and eight modes have the delay system’s mean period and mean stress drop"
    )
    where = f"the largest of {len(found)} differences, at {places(means['delay'])}"
    yield claim(title, WITNESS, off, ERRORS, where, unit="standard errors")
    first = min(means["delay"])
    differ = {model: apart(one, means[model][first]) for model, one in ran.items()}
    limits = {model: within(one, means[model][first]) for model, one in ran.items()}
    worst = max(differ, key=lambda model: differ[model] / limits[model])
    title = "Runs whose cycles repeat have the period and the stress drop of the model’s orbit"
    where = f"{', '.join(f'`{model}`' for model in differ)} at log_{{10}} r = {places([first])}; shown: `{worst}`"
    yield claim(title, WITNESS, differ[worst], limits[worst], where)


def damped_claims(orbits: Runs, means: Runs, run: CycleFigures) -> Iterator[Verdict]:
    """Where the quasi-dynamic model slides steadily, how short its period is beyond, and that a direct run has it too."""
    (_, onset), known = log10_onsets(), orbits[DAMPED] | means[DAMPED]
    right = sum((found is not None) == (log10_r > onset) for log10_r, found in known.items())
    short = [-error_against_delay(means, DAMPED, log10_r, "period").value for log10_r in means["delay"]]
    where = f"`{DAMPED}`; onset, r = ε/(b − a − εV/2), at log_{{10}} r = {places([onset], '.3f')}; orbits at {places(known)}"
    yield every(
        "The quasi-dynamic model slides steadily up to its own onset and not beyond", EXACT, right, len(known), where, "r"
    )
    title = "Beyond its onset the period of the quasi-dynamic model is about half of the exact one"
    yield in_range(title, WITNESS, SHORT, short, f"`{DAMPED}`, how much shorter, against the delay system’s means", ".0%")
    title = "A direct run of the quasi-dynamic model settles on the orbit that Newton’s method finds"
    orbit = known[RUN_AT]
    yield claim(title, WITNESS, apart(run, orbit), within(run, orbit), f"T and Δμ at log_{{10}} r = {places([RUN_AT])}")


def known_claims(periods: dict[str, Estimate]) -> Iterator[Verdict]:
    """Periods at log10 r = -2.68 against those of other programs, and of a fit against those of as many modes."""
    yield as_known(periods, -2.68, OTHERS)
    fit, modes = (periods.get(model, Estimate(math.nan, 0.0)) for model in ("fitted:4", "modal:4"))
    title = "A fit of the impedance of alike slabs has the orbit of as many exact modes"
    where = "T of `fitted:4` and `modal:4` at log_{10} r = −2.68"
    yield claim(title, WITNESS, fit.value / modes.value, error_of(fit, modes), where, near=1.0)


def fitted_modes(model: str) -> Verdict:
    """The modes of a reduction of alike slabs against the poles and residues of a rational fit of their exact impedance.

    The fit (AAA, Nakatsukasa, Sete and Trefethen 2018) uses no modes. Its input is Z(s)/epsilon on a line to the right of the
    imaginary axis.
    """
    from scipy import interpolate

    known = reduction_of(scene_at(-2.68), model)
    reach = 2.0 * np.pi * (len(known.frequencies) + 0.5)
    s = np.asarray(_SHIFT + 1j * np.linspace(-reach, reach, _SAMPLES), dtype=np.complex128)
    fit = cast(Any, interpolate).AAA(s, exact_impedance(scene_at(-2.68), s), rtol=_FITTED)
    poles, residues = fit.poles(), fit.residues()
    modes = [(0.0, known.spring), *((w, 0.5 * residue) for w, residue in zip(known.frequencies, known.residues, strict=True))]
    nearest = [(int(np.argmin(np.abs(poles - 1j * w))), w, residue) for w, residue in modes]
    off = max(max(abs(poles[k] - 1j * w), abs(residues[k] / residue - 1.0)) for k, w, residue in nearest)
    title = "A rational fit of the exact impedance of alike slabs finds their modes"
    remark = f"poles (per transit) and residues of AAA against spring and modes of `{model}`, which knows them in closed form"
    return claim(title, EXACT, float(off), ERRORS * _FITTED, remark)


def no_modes() -> Verdict:
    """A reduction without modes is the block that stands for a slab at low frequency."""
    none, block = (reduction_of(scene_at(-2.68), model) for model in ("modal:0", "block12"))
    same = none.mass == block.mass and not none.frequencies and none.damping == block.damping
    return holding("No mode at all is the ρh/12 block", EXACT, "the same equations", "same" if same else "not", same)


def wave_claims(orbits: Runs) -> Iterator[Verdict]:
    """The full wave's cycles against the delay system's orbits."""
    off = {name: max(abs(error_against_delay(orbits, WAVE, x, name).value) for x in SHOWN) for name in _JUDGED}
    coarse = {WAVE: {x: own_figures_of(WAVE, x, CELLS - 1) for x in SHOWN}, "delay": orbits["delay"]}
    left = {name: max(abs(error_against_delay(coarse, WAVE, x, name).value) for x in SHOWN) for name in _JUDGED}
    limit = {name: error_after(WAVE, error, CELLS - 1, CELLS) for name, error in left.items()}
    where = f"`{WAVE}`, {CELLS} cells, propagated exactly in time, at {places(SHOWN)}"
    yield claim("The full wave has the period of the delay system’s orbit", WITNESS, off["period"], limit["period"], where)
    yield claim("The full wave has the stress drop of the delay system’s orbit", WITNESS, off["drop"], limit["drop"], where)


def table_claims(table: ModelTable) -> Iterator[Verdict]:
    """Verdicts: regimes against onsets, which use no run; the simplest model runs away; the cost of an exact answer."""
    known = [(row, one, cell) for row in table.rows for one, cell in zip(table.columns, row.cells, strict=True) if row.onset]
    right = sum((cell.regime == STEADY) == (one.log10_r < row.onset.value) for row, one, cell in known if row.onset)
    title, where = (
        "Runs leave steady sliding where their model’s onset lies",
        "every model without a grid; onsets from its impedance",
    )
    yield every(title, WITNESS, right, len(known), f"{where}, which know no run", "points")
    same, title = (
        [cell.right for model in _AS_WAVES for cell in table.row(model).cells],
        "The full wave, four and eight modes have the exact system’s regimes",
    )
    yield every(title, WITNESS, sum(same), len(same), "verdicts on runs, at every r", "points")
    away = [cell.regime == AWAY for cell in table.row("quasistatic").cells]
    where = f"`quasistatic` at {places(x.log10_r for x in table.columns)}"
    yield every("The quasi-static model runs away", EXACT, sum(away), len(away), where, "points")
    least = min(costs_of_good_reductions(table), default=math.inf)
    yield holding(
        f"No ODE that is right to {100 * GOOD:g} % at every r shown costs less than the exact system",
        SELF,
        f"at least {1.0 / AS_CHEAP:.1f} of its time",
        f"~{{{least:.2g}}} of its time",
        least * AS_CHEAP >= 1.0,
        f"the least of {len(costs_of_good_reductions(table))} ratios of medians; run times vary by a tenth",
        Outcome.FINDING,
    ).with_margin(1.0 / AS_CHEAP / least, 1.0, "of times")


def verdicts_on_models(orbits: Runs, means: Runs, table: ModelTable) -> tuple[Verdict, ...]:
    """All verdicts in the order of the page."""
    periods = {model: orbit.period for model, by_r in orbits.items() if (orbit := by_r.get(-2.68)) and model != WAVE}
    ran = {model: mean_at(model, min(means["delay"])) for model in _REPEATING}
    of_means = (*mean_claims(means, ran), *damped_claims(orbits, means, run_of_damped()))
    of_orbits = (*error_claims(orbits), *wave_claims(orbits), *known_claims(periods))
    return (*table_claims(table), *of_orbits, *of_means, fitted_modes("fitted:4"), no_modes())
