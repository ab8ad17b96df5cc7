"""The period of stick-slip over the delay r, the paper's Fig 8, from the onset to log10 r = -2.3."""

import math
from typing import Any, NamedTuple

import slipwave
from reduced.orbit.multipliers import count_unstable
from slipwave.observe.statistics import Estimate
from slipwave.scene import Scene
from validation.references.onset import onset_of
from validation.references.published import half_digit, reference
from validation.study import Budget, Cell, Figure, Number, StudyResult, Table, memo, stated, table
from validation.study.branch_drawing import draw_branch, special_keys
from validation.study.drawing import Drawing, key, line, ruled, style_of, subplots
from validation.study.known import OTHERS, PeriodRanges, order_of_periods
from validation.study.over_r import FAR, Branch, branch_of, numbered_period, scene_at
from validation.study.text import minus
from validation.study.verdict import ASYMPTOTIC, EXACT, WITNESS, Verdict, claim

NAME = "period-against-delay"
QUESTION = "How does the period of stick-slip depend on the delay, in the exact system, the paper’s ODE and the blocks?"
SCENES = ("paper",)
SECONDS = (5.0, 18.0)

MASSES = {"block8": 8.0, "block12": 12.0}
"""M of each block."""

_ITERATIONS = 200
_CONVERGED = 1e-12

WAVES = ("kelvin-voigt", "delay")
"""Models with reverberations; their orbits lose stability."""

_TOLERANCE = 1e-8
_ONSET = 1e-12  # the onset is bracketed to 1e-13
_SETTLED = 1e-9  # orbits of branches to their own tolerance
_THICK_LAW = 0.025


class Periods(NamedTuple):
    """At one r, by model (transits): periods of all `orbits` found, and where none of these is stable, the mean over the cycles
    of a run, with the number of its cycles; `first`: the first of the orbits with its error."""

    log10_r: float
    orbits: dict[str, list[float]]
    means: dict[str, memo.Means]
    first: dict[str, Number]

    @property
    def ranges(self) -> PeriodRanges:
        """Lowest and highest period, two standard errors of a mean included."""
        ode, delay, *blocks = map(self._range, (*WAVES, *MASSES))
        return PeriodRanges(self.log10_r, ode, delay, (min(low for low, _ in blocks), max(high for _, high in blocks)))

    def _range(self, model: str) -> tuple[float, float]:
        mean = self.means.get(model)
        ends = [mean.period.value + share * mean.period.error for share in (-2.0, 2.0)] if mean else []
        values = [*self.orbits.get(model, []), *ends]
        return min(values), max(values)


_ENDS = {True: {"kelvin-voigt": (-2.64, FAR), "delay": (-2.3, 74.6)}, False: {"kelvin-voigt": (-2.3, FAR), "delay": (-2.3, 80.0)}}
"""Quick report -> model -> log10 r and the period (transits) at which its branch ends."""

_GRID = {
    True: (-2.69, -2.68, -2.65, -2.5, -2.3),
    False: (-2.695, -2.69, -2.68, -2.67, -2.66, -2.65, -2.64, -2.62, -2.6, -2.575, -2.55, -2.5, -2.45, -2.4, -2.35, -2.3),
}
_UNTIL = {True: 6000.0, False: 20000.0}
_THICK = (-2.5, -2.3, -2.0, -1.5, -1.0, -0.5, 0.0)
_RUN = (
    ("delay", -2.69),
    ("delay", -2.68),
    ("kelvin-voigt", -2.69),
    ("kelvin-voigt", -2.65),
    ("block8", -2.5),
    ("block12", -2.3),
)


def run(budget: Budget) -> StudyResult:
    """Follow both branches, find the blocks' orbits, and run where no orbit is stable."""
    quick = budget.quick
    branches = {model: branch_of(model, *_ENDS[quick][model]) for model in budget.each(_ENDS[quick], end=0.7)}
    listed = [periods_at(log10_r, branches, _UNTIL[quick]) for log10_r in _GRID[quick]]
    budget.report(0.9)
    ratios = {model: {x: own_period(model, x).value / period_of(scene_at(x), model) for x in _THICK} for model in MASSES}
    runs = {run: settled_period(*run) for run in _RUN}
    return StudyResult(
        answer=_answer(listed),
        figures=(
            Figure(
                "over-r",
                _CAPTION,
                lambda: _periods_over_r(branches, listed, ratios),
                paper="Fig 8",
                carries=("P3 ", "P4 ", "P7 ", "P12 "),
                zoom=True,
            ),
        ),
        tables=(_period_table(listed), _mean_table(listed)),
        verdicts=(order(listed), known(listed), runs_settle(listed, runs), at_onset(branches), thick(ratios)),
        notes=(_ENERGY,),
        numbers=_numbers(listed),
    )


def _answer(listed: list[Periods]) -> str:
    first = listed[0]
    apart = first.ranges.blocks[1] / first.ranges.kelvin_voigt[0] - 1.0
    return (
        f"It grows with r, fastest near the onset, where the models agree: within {100 * apart:.0f} % at log_{{10}} r = "
        f"{first.log10_r:g}. Further on the ODE’s period hardly grows and the blocks’ grows too much; the exact system’s lies "
        "between them."
    ).replace("= -", "= −")


def _numbers(listed: list[Periods]) -> dict[str, Number]:
    return {f"{model} T at {one.log10_r:g}": found for one in listed for model, found in one.first.items()}


_CAPTION = (
    "Period of stick-slip over the delay r, the paper’s Fig 8. Left: orbits of the delay system and of the ODE by continuation "
    "from the Hopf point, stable ones thick and solid, unstable ones thin and dotted; means over the cycles of runs, with two "
    "standard errors, where no orbit is stable; the blocks, whose orbits are all stable; grey: the law for thick slabs. Right: "
    "the blocks’ periods over that law."
)
_ENERGY = (
    "The paper explains the order by the energy that fast oscillations take. The law for thick slabs says the same: a block "
    "loses nothing and swings through, so that the elastic drop is twice the fall of friction; slabs keep part of the energy in "
    "waves."
)

_TICKS = (50, 60, 70, 80, 90, 100, 120, 140)
_LOWEST, _HIGHEST = 47.0, 145.0
_LAW: dict[str, Any] = {"color": "#777777", "linewidth": 0.9}
_MEAN: dict[str, Any] = {"fmt": "o", "markerfacecolor": "white", "markersize": 4.0, "linewidth": 1.0, "capsize": 2.0}
_LAW_FROM = -2.55
"""log10 r from which the law is drawn."""
_PAPER: dict[str, Any] = {"color": "#d55e00", "marker": "x", "markersize": 7.0, "markeredgewidth": 1.5, "linestyle": "none"}


def _period_table(listed: list[Periods]) -> Table:
    models = (*WAVES, *MASSES)
    rows = [
        (one.log10_r, *(_first(one, model) for model in models), *(period_of(scene_at(one.log10_r), model) for model in MASSES))
        for one in listed
    ]
    heading = " | ".join(
        ["log_{10} r .4f", *(f"T [{model}] .9g" for model in models), *(f"law [{model}] .4g" for model in MASSES)]
    )
    caption = (
        "Periods in transits, by Newton’s method: the orbit of lowest period known at each r, stable or not. A dash: beyond the "
        "part of the branch that was followed. Law: the asymptotic period of the blocks for thick slabs; it is no approximation "
        "near the onset."
    )
    return table("periods", caption, heading, rows)


def _first(one: Periods, model: str) -> Cell:
    found = one.orbits.get(model)
    return found[0] if found else None


def _mean_table(listed: list[Periods]) -> Table:
    found = ((model, one, mean) for model in WAVES for one in listed if (mean := one.means.get(model)))
    rows = (
        (model, one.log10_r, mean.period.value, mean.period.error, float(mean.cycles), _first(one, model))
        for model, one, mean in found
    )
    caption = (
        "Mean period over the cycles of a run where no orbit is known to be stable, with its standard error, which allows for "
        "the dependence of a cycle on those before it; and the unstable orbit, where it is known."
    )
    heading = "model | log_{10} r .4f | mean T [transits] .6g | error .1e | cycles .0f | T of the orbit [transits] .8g"
    return table("deep", caption, heading, rows)


def _periods_over_r(branches: dict[str, Branch], listed: list[Periods], ratios: dict[str, dict[float, float]]) -> Drawing:
    figure, (left, right) = subplots(4.6, 1, 2, r"$\log_{10} r$", "$T$ (transits)", width_ratios=(1.7, 1.0))
    for model, branch in branches.items():
        draw_branch(left, model, branch.corners, "period")
    for model in MASSES:
        look, law = style_of(model), _LAW | {"linestyle": style_of(model).dashes}
        x, y = [one.log10_r for one in listed], [one.orbits[model][0] for one in listed]
        left.plot(x, y, **line(model))
        right.plot(*zip(*ratios[model].items(), strict=True), look.marker, color=look.color, linestyle=look.dashes)
        beyond = [value for value in x if value >= _LAW_FROM]
        left.plot(beyond, [period_of(scene_at(value), model) for value in beyond], **law)
    for model in WAVES:
        at, means = zip(*((one.log10_r, one.means[model].period) for one in listed if model in one.means), strict=True)
        values, bars = [mean.value for mean in means], [2.0 * mean.error for mean in means]
        left.errorbar(at, values, bars, color=style_of(model).color, **_MEAN)
    paper = reference()["paper"]
    left.plot([-2.68, -2.68], [paper["T_ode"], paper["T_dde"]], **_PAPER)
    left.set(yscale="log", ylim=(_LOWEST, _HIGHEST))
    left.set_yticks(_TICKS, [str(tick) for tick in _TICKS], minor=False)
    left.minorticks_off()
    right.axhline(1.0, **_LAW)
    right.set_title("$T$ of the blocks over the law")
    ruled(left, right)
    figure.legend(handles=_keys(), loc="outside upper left", ncols=4, handlelength=2.4)
    return figure


def _keys() -> list[Any]:
    lines = [key(**line(model)) for model in (*WAVES, *MASSES)]
    mean = key(marker="o", color="#555555", markerfacecolor="white", linestyle="none", label="mean of a run")
    law = key(label="law for thick slabs", **_LAW)
    return [*lines, *special_keys(()), mean, law, key(label="the paper’s values", **_PAPER)]


def period_of(scene: Scene, model: str) -> float:
    """The period (transits) of the block called `model`, for alike plain slabs and the ageing law; NaN where the law has none."""
    a, b = float(scene.law.a), float(scene.law.b)
    velocity, r, epsilon = scene.velocity, scene.transit, scene.upper.epsilon
    drop = 1.0
    for _ in range(_ITERATIONS):
        healed = drop / (epsilon * velocity) * r
        fastest = 0.5 * math.sqrt(MASSES[model]) * drop / epsilon
        if not healed * fastest > 1.0:
            break
        fall = a * math.log(epsilon * velocity / (r * b)) + b * math.log(healed) + (b - a) * math.log(fastest)
        new = 2.0 * fall * (1.0 - 0.5 * math.log(healed * fastest) / (r * drop / epsilon))
        if abs(new - drop) < _CONVERGED:
            return new / (epsilon * velocity)
        drop = new
    return math.nan


def periods_at(log10_r: float, branches: dict[str, Branch], until: float) -> Periods:
    """All models at one r; runs last `until` (transits)."""
    closed = {model: branches[model].orbits_at(log10_r) for model in WAVES}
    blocks = {model: own_period(model, log10_r) for model in MASSES}
    first = {model: numbered_period(found[0]) for model, found in closed.items() if found}
    first |= {model: stated(period.value, period.error) for model, period in blocks.items()}
    orbits = {model: [one.cycle.period for one in found] for model, found in closed.items() if found}
    orbits |= {model: [period.value] for model, period in blocks.items()}
    unstable = [model for model in WAVES if all(count_unstable(one) for one in closed[model])]
    means = {model: memo.means(model, scene_at(log10_r), until) for model in unstable}
    return Periods(log10_r, orbits, means, first)


def own_period(model: str, log10_r: float) -> Estimate:
    """The period of the orbit near a run, by Newton's method."""
    return memo.own_orbit(model, scene_at(log10_r), _TOLERANCE).orbit.period


def settled_period(model: str, log10_r: float) -> float:
    """The period on which a direct run settles."""
    return memo.settled(model, scene_at(log10_r), 1e-10, 1e-9).orbit.period.value


def order(listed: list[Periods]) -> Verdict:
    """P7 over the whole range of r."""
    means = sum(bool(one.means) for one in listed)
    remark = (
        f"all orbits that are known at an r, stable or not; at {means} r, where no orbit of a model is stable, also the mean "
        "over a long run, with two standard errors"
    )
    return order_of_periods([one.ranges for one in listed], remark)


def known(listed: list[Periods]) -> Verdict:
    """Verdict: the periods against those of other programs."""
    pairs = [
        (one.orbits[model][0], entry["period"])
        for model in (*WAVES, *MASSES)
        for entry in reference()["orbits"][model]
        for one in listed
        if one.log10_r == entry["log10_r"] and model in one.orbits
    ]
    errors = [(abs(ours / known - 1.0), half_digit(known) / known + OTHERS) for ours, known in pairs]
    off, allowed = max(errors, key=lambda one: one[0] / one[1])
    remark = f"{len(pairs)} orbits of four models, against AUTO-07p, variational shooting and lifted shooting"
    return claim("Periods are those of other programs", WITNESS, off, allowed, remark)


def runs_settle(listed: list[Periods], runs: dict[tuple[str, float], float]) -> Verdict:
    """Direct runs where orbits are stable."""
    at = {one.log10_r: one for one in listed}
    off = max(abs(period / at[log10_r].orbits[model][0] - 1.0) for (model, log10_r), period in runs.items())
    cases = ", ".join(f"{model} at {log10_r:g}".replace(" -", " −") for model, log10_r in runs)
    return claim("Direct runs settle on these periods", WITNESS, off, _SETTLED, f"relative difference of T; {cases}")


def at_onset(branches: dict[str, Branch]) -> Verdict:
    """Where the curves begin, against the closed forms."""
    scene = slipwave.read("paper")
    closed = onset_of(scene.law, scene.upper.epsilon, scene.velocity)
    critical = {"delay": closed.r_delay, "kelvin-voigt": closed.r_kelvin_voigt}
    off = [abs(branches[model].onset.period * closed.omega_c * r / (2.0 * math.pi) - 1.0) for model, r in critical.items()]
    remark = "relative; roots of the characteristic equation against ω_{c} (20) and r_{c} (27), (39)"
    return claim("The curves begin with T = 2π/(ω_{c} r_{c})", EXACT, max(off), _ONSET, remark)


def thick(ratios: dict[str, dict[float, float]]) -> Verdict:
    """The law for thick slabs: T over it, by model and log10 r."""
    values = list(ratios["block8"])
    began, ended = (max(abs(found[value] - 1.0) for found in ratios.values()) for value in (values[0], values[-1]))
    where = minus(f"relative difference at log_{{10}} r = {values[-1]:g}; it is {began:.3f} at {values[0]:g}")
    title = "The blocks’ periods approach the law T = Δy/(εV) with the full overshoot as the slabs become thick"
    return claim(title, ASYMPTOTIC, ended, _THICK_LAW, f"{where}. No number of the law is fitted")
