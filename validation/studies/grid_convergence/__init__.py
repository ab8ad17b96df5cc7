"""Every full-wave family against the delay system: order in space in every output, and run time against error; then the error in
time, by the two marches of one grid."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from itertools import combinations
from typing import TypeAlias

import numpy as np

from fullwave.families import FullWave
from slipwave.family import Exact
from slipwave.observe.pieces import Array
from slipwave.sources import ROOT, import_closure
from validation.compute.models import FAMILIES, GRIDS, grid_of
from validation.measure.grid_ladders import FLOOR_IN_SPACE, GENTLE, LADDERS, ROUGH, ROUGH_FROM, STEEP, STEEP_FROM, LadderRun
from validation.measure.grids.in_space import climb_of, delay_reference, without_error_in_time
from validation.measure.order_fit import FEWEST_DENSE, TREND
from validation.measure.orders import ALMOST, KNOWN, QUANTITIES, RESOLVED, Climb, climb
from validation.studies.grid_convergence import in_time, orbits
from validation.study import Budget, Cell, Figure, StudyResult, Table, stated, table
from validation.study.drawing import Drawing, grid_styles, ruled, subplots
from validation.study.grid_verdicts import order_verdict
from validation.study.text import places, plain, run_time

NAME = "grid-convergence"
QUESTION = "Do four discretisations of the wave agree with the delay system, and at what cost?"
SCENES = ("paper",)
SECONDS = (12.0, 52.0)

_DRAWN = ("fd", "sbp:2", "sbp:4", "sbp:6", "fem:2", "fem:4", "fem:7", "dg:2", "dg:4", "dg:7")
"""Families of the figure."""

_QUICK = ("fd", "sbp:2", "sbp:4", "sbp:6", "fem:7", "dg:2", "dg:7")
"""Families whose orders the quick report fits."""

_THINNED = 2
"""Thinning of the grids in the figure, which compares all families on the gentler scene."""

_ENOUGH = 1e-4  # error of the state for which run times are given

_FLOOR = 1e-14
_MARCH = {"fullwave.lines.motion": "the right-hand side with its faces", "fullwave.lines.kernel": "the time stepper"}
COMPARED = tuple(family.name for family in FAMILIES if family.exact is not Exact.NEVER)
_SCENES = {GENTLE.log10_r: "s", ROUGH.log10_r: "r", STEEP.log10_r: "t"}

Curves: TypeAlias = Mapping[str, tuple[Array, Array, Array]]
"""Family -> points per slab, seconds, error of the state."""


def run(budget: Budget) -> StudyResult:
    """Climb every ladder, fit its orders; then the figure's grids, the grids' own orbits and the error in time."""
    climbs = [climb_of(model) for model in budget.each(judged_models(budget.quick), end=0.7)]
    curves = {model: _curve(model, climbs) for model in (*_DRAWN, *_others(_DRAWN))}
    families, marches = orbits.FAMILIES[budget.quick], [in_time.marches_of(model) for model in in_time.GRIDS]
    own = orbits.grid_orbits(families)
    compared = orbits.as_r_grows(orbits.ORBITS_AT[budget.quick], orbits.MEANS_AT[budget.quick])
    return StudyResult(
        answer=_answer(climbs, own, curves),
        figures=(Figure("families", _CAPTION, lambda: _convergence_and_cost(curves), timed=True),),
        tables=(
            orders_table(climbs, [family for family in GRIDS if not family.ladder]),
            finest_table(climbs),
            orbits.grid_orbit_table(own),
            *([orbits.growth_table(compared)] if compared else []),
            in_time.time_table(marches),
            code_table(),
        ),
        verdicts=(
            *(order_verdict(climbed) for climbed in climbs),
            *orbits.orbit_verdicts(own, families),
            *orbits.growth_verdicts(compared),
            *in_time.time_verdicts(marches),
        ),
        notes=(code_note(), in_time.TIME_NOTE, *_NOTES),
        numbers={
            f"{climbed.ladder.model} order": stated(together.order, together.half_width)
            for climbed in climbs
            if not climbed.lost
            for together in [climbed.fit_together()]
        },
    )


def judged_models(quick: bool) -> tuple[str, ...]:
    """The members whose order is fitted: in a quick report some of those below, and one of every other family with a ladder."""
    return (*_QUICK, *_others(_QUICK)) if quick else tuple(LADDERS)


def _others(models: Iterable[str]) -> list[str]:
    """The first rung of every family with a ladder that has no member among `models`."""
    seen = {model.partition(":")[0] for model in models}
    return [family.called(next(iter(family.ladder))) for family in GRIDS if family.ladder and family.name not in seen]


def _curve(model: str, climbs: list[Climb]) -> tuple[Array, Array, Array]:
    """(points per slab, seconds, error of the state) on the figure's grids, from its climb if that used their scene."""
    run = replace(GENTLE, density=GENTLE.density // _THINNED)
    found = next((one for one in climbs if one.ladder.model == model and one.ladder.run.scene is GENTLE.scene), None)
    climbed = found or climb(replace(LADDERS[model], run=run), delay_reference(GENTLE), without_error_in_time)
    family, number = grid_of(model)
    shown = slice(None, None, _THINNED if found else 1)
    return climbed.cells[shown] * family.points(number), climbed.seconds[shown], climbed.errors["state"][shown]


def _answer(climbs: list[Climb], own: list[orbits.GridOrbit], curves: Curves) -> str:
    off = ", ".join(f"{_NAMED[model]} to {plain(error, '.0e')}" for model, error in orbits.finest(own).items())
    short = sum(bool(climbed.shortfall()) for climbed in climbs)
    orders = "every family tried reaches its order" if not short else f"{short} of {len(climbs)} families miss their order"
    return f"Period and stress drop of full waves’ own orbits are the delay system’s: {off}; {orders}. {_cost(curves)}"


def _cost(curves: Curves) -> str:
    """Text on run times for one error of the state, where it is reached."""
    times = {model: float(seconds[error < _ENOUGH].min(initial=np.inf)) for model, (_, seconds, error) in curves.items()}
    listed = ", ".join(
        f"{1e3 * times[model]:.0f} ms with `{model}`" for model in ("fd", *_NAMED) if np.isfinite(times.get(model, np.inf))
    )
    return f"An error of the state below {plain(_ENOUGH, '.0e')} costs {run_time(listed)}."


_NAMED = {"sbp:6": "summation by parts", "fem:4": "finite elements", "dg:7": "discontinuous Galerkin"}


_NOTES = (
    "Orders are those of space: from order 3 on families are marched exactly in time. At order 2, explicit steps of order 4 "
    "leave at most 3 % of the error in space on 48 cells, and less on finer grids. The leapfrog runs at CFL 0.5; at CFL 1 it is "
    "the delay system itself. `fem:1` (lumped mass) and `sbp:2` are algebraically the same scheme, so their rows must agree.",
    "A fixed rule selects the grids used in a fit. The first is the coarsest from which on every error is below "
    f"{RESOLVED:g}^{{−order}}; the last is the finest whose error is above {plain(FLOOR_IN_SPACE, '.0e')}; the reference is "
    "right to 10^{−12}. Of these, coarse grids are dropped while a parabola through the logarithms is significantly curved (95 "
    f"%) and {FEWEST_DENSE} remain. There are {GENTLE.density} (scene s) or {ROUGH.density} (scenes r and t) grids per doubling "
    "of the cells, fewer where whole numbers of cells allow no more.",
    "A family passes under two conditions. First, the 95 % interval of all outputs together reaches the promised order and "
    f"begins less than {KNOWN:g} below it (for order 2 it contains 2 and is narrower than ± {KNOWN:g}); a miss by {ALMOST:g} is "
    "always allowed, and so is a fit below the promised order whose local orders rise to it: with error ~ h^{p} e^{bh}, the "
    f"order p at h = 0 is the promised one within {TREND:g}, and known that well. Second, no single output is fitted lower than "
    f"promised by more than {GENTLE.slack:g} (scene s) or {ROUGH.slack:g} (scenes r and t): high orders have only seven to "
    "twenty numbers of cells between resolution and rounding, over which a single output still scatters.",
    "Elements promise order P + 1 at the interface and reach nearly 2 P: 4, 6 and 8 at degrees 2, 3 and 4, 11 to 13 at degree 7, "
    "where only the finest grids show it.",
    "The scenes, the factor 3, the density of grids and the allowance for single outputs were chosen after trials. The orders "
    "of the highest degrees are therefore shown, not proven.",
)

_CAPTION = (
    f"Error of the state (ψ, ln v, μ over the last {GENTLE.window:g} of {GENTLE.until:g} transits, relative to their range) at V "
    f"= {GENTLE.scene.velocity:g}, log_{{10}} r = {places([GENTLE.log10_r])}, smooth start, against the delay system: left over "
    "points per slab, right over run time; from order 3 on marched exactly in time. Numbers after a family’s name are its order "
    "(summation by parts) or polynomial degree (finite elements, discontinuous Galerkin)."
)


def orders_table(climbs: list[Climb], unjudged: Iterable[FullWave] = ()) -> Table:
    """One row per family: every quantity's order with its interval, or the reason for none."""
    rows: list[tuple[Cell, ...]] = []
    for one in climbs:
        grids, together = None, f"no order: {one.lost}"
        orders: list[Cell] = [None] * len(QUANTITIES)
        if not one.lost:
            grids = f"{one.cells[one.resolved]:.0f}\u2060–\u2060{one.cells[-1]:.0f}"
            orders, together = [one.fit(name).rounded for name in QUANTITIES], one.fit_together().rounded
        rows.append((one.ladder.model, _scene(one), grids, f"{one.ladder.declared:g}", *orders, together))
    for family in unjudged:
        declared = f"{family.order_interface(family.usual):g}"
        rows.append((family.example, None, None, declared, *([None] * len(QUANTITIES)), "not judged: declares no ladder"))
    orders_in = [f"order in {symbol}" if name != "state" else "in the state" for name, symbol in QUANTITIES.items()]
    heading = " | ".join(["family | scene | cells | declared", *orders_in, "all together"])
    caption = (
        "Fitted orders with their 95 % confidence intervals, rounded up. T, Δμ, Δy, v_{max}: period, stress drop, elastic drop "
        "and largest rate, errors as root mean squares over all complete cycles; state: ψ, ln v and μ over the last transits; "
        "all together: geometric mean of the five errors. Cells: grids on which the waves are resolved. Smooth start, V = "
        f"{GENTLE.scene.velocity:g}; scene s: log_{{10}} r = {_run_text(GENTLE)}; scene r (rougher, for orders from "
        f"{ROUGH_FROM:g} on): {_run_text(ROUGH)}; scene t (steeper still, for orders from {STEEP_FROM:g} on): {_run_text(STEEP)}."
    )
    return table("orders", caption, heading, rows)


def _run_text(run: LadderRun) -> str:
    return f"{places([run.log10_r])}, {run.until:g} transits"


def finest_table(climbs: list[Climb]) -> Table:
    """One row per family: errors and run time of the finest grid."""
    rows: list[tuple[Cell, ...]] = []
    for one in (one for one in climbs if one.cells.size):
        last = [float(values[-1]) for values in (one.cells, 1e3 * one.seconds, *(one.errors[name] for name in QUANTITIES))]
        rows.append((one.ladder.model, _scene(one), *last))
    errors_of = [f"error of {symbol} [relative] .0e" for symbol in QUANTITIES.values()]
    heading = " | ".join(["family | scene | cells [a slab] .0f | run [ms] .0f", *errors_of])
    caption = (
        "Relative errors on the finest grid tried, and the run’s time. A ladder ends with the first grid whose error of the "
        f"state is below {plain(FLOOR_IN_SPACE, '.0e')}, where the fits end. Scenes as above."
    )
    return table("finest", caption, heading, rows)


def _scene(climb: Climb) -> str:
    return _SCENES[climb.ladder.run.log10_r]


def _convergence_and_cost(curves: Curves) -> Drawing:
    figure, (left, right) = subplots(4.3, 1, 2, "points per slab", "error of the state", sharey=True)
    for model, own in grid_styles(curves).items():
        points, seconds, error = curves[model]
        look = {"color": own.color, "marker": own.marker, "linestyle": own.dashes, "linewidth": 1.1, "markersize": 4}
        shown = np.maximum(error, _FLOOR)
        left.loglog(points, shown, label=own.label, **look)
        right.loglog(1e3 * seconds, shown, **look)
    right.set_xlabel("run time (ms)")
    ruled(left, right)
    figure.legend(loc="outside upper left", ncols=4, handlelength=3.0)
    return figure


def modules_of(family: str) -> frozenset[str]:
    """Modules of the project that a family's solver uses, as `fullwave.lines.march`."""
    module = next(facts.module for facts in FAMILIES if facts.name == family)
    start = ROOT.joinpath(*module.split(".")).with_suffix(".py")
    files = (path.relative_to(ROOT).with_suffix("") for path in import_closure([start], packages=False))
    return frozenset(".".join(path.parts).removesuffix(".__init__") for path in files)


def shared(one: str, other: str) -> tuple[str, ...]:
    """Modules outside `slipwave` that two families share, without the tables of facts, which compute nothing."""
    common = modules_of(one) & modules_of(other)
    return tuple(sorted(name for name in common if not name.startswith("slipwave") and not name.endswith(".families")))


def code_table() -> Table:
    """One row per pair of families."""
    rows = (
        (f"`{one}`, `{other}`", len(common), ", ".join(name.removeprefix("fullwave.") for name in common) or "none")
        for one, other in combinations(COMPARED, 2)
        for common in [shared(one, other)]
    )
    caption = (
        "Modules of the solvers that two families share, read from their imports; all share `slipwave` (the scene, friction, the "
        "interface condition, the event detection). Comparing two families cannot reveal a mistake in what they share."
    )
    return table("code", caption, "pair | modules .0f | in common", rows)


def code_note() -> str:
    """Text on the independence of the pairs."""
    alike = set(shared("sbp", "fem")) & set(shared("sbp", "dg"))
    leapfrog = shared("fd", "sbp")
    exact = max(len(shared("delay", family)) for family in COMPARED[1:])
    return (
        f"`sbp`, `fem` and `dg` have {len(alike)} modules in common, {_march_in(alike)}: they are witnesses of each other’s "
        f"operators in space only. The leapfrog has {len(leapfrog)} modules in common with them, {_march_in(leapfrog)}. "
        f"The delay system, which every error is measured against, has no grid and {exact or 'no'} solver modules in common "
        "with any of them."
    )


def _march_in(modules: Collection[str]) -> str:
    parts = [words for module, words in _MARCH.items() if module in modules]
    return f"among them {' and '.join(parts)}" if parts else f"but not {' nor '.join(_MARCH.values())}"
