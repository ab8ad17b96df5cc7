"""Every full wave at its order: in space against the delay system, against an exact motion, on its own orbits, in time; and one
slip event. About kernels, whose solvers it builds."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from itertools import combinations
from typing import Any, TypeAlias

import numpy as np
from scipy.interpolate import CubicSpline

import slipwave as sw
from slipwave.solve import Solver
from slipwave.sources import ROOT, import_closure
from validation.chart import Chart, Look, Panel, Scale, Trace
from validation.chart.looks import style_of
from validation.measure.grid_ladders import FLOOR_IN_SPACE, GENTLE, LADDERS, ROUGH, STEEP, LadderRun, in_space
from validation.measure.in_words import state_at
from validation.measure.manufactured import BEGIN, UNTIL, error_of_motion, given_scene
from validation.measure.order_fit import fit_dense, fit_order
from validation.measure.orders import RESOLVED, Climb, climb, climb_of, delay_reference, errors, measure, without_error_in_time
from validation.models.build import build
from validation.models.by_name import FAMILIES, GRIDS, grid_of
from validation.report import (
    EXACT,
    SELF,
    WITNESS,
    Budget,
    Evidence,
    Figure,
    Number,
    StudyResult,
    Verdict,
    Verdicts,
    at_least,
    claim,
    every,
    plain,
    stated,
)
from validation.report.grid_verdicts import ORDER, order_verdict
from validation.report.known import declared_order, error_after, of_order

NAME = "orders"
QUESTION = "Do four discretisations of the wave agree with the delay system, at the orders that they declare?"
SCENES = ("paper", "yardstick")
SECONDS = (25.0, 90.0)


def run(budget: Budget) -> StudyResult:
    """Climb every ladder, find every orbit, march both ways, record one event."""
    climbs = [climb_of(model) for model in budget.each(_judged_models(budget.quick), 0.4)]
    other_cfls = {cfl: _leapfrog_at(cfl) for cfl in _CFLS[1:]}
    jump_cells = budget.plan(_JUMP_CELLS[:-1], _JUMP_CELLS)
    jumps = {cfl: _jump_errors(cfl, jump_cells) for cfl in _CFLS}
    grids = budget.plan(_FEW_GRIDS, _MANY_GRIDS)
    orbits = [(model, _AT, _orbit_errors(model, _AT, cells)) for model, cells in budget.each(grids.items(), 0.6, 0.4)]
    orbits_at, means_at = budget.plan(quick=((), (-2.5,)), full=((-2.699, -2.66, -2.65), (-2.5, -2.3)))
    others = [(_WAVE, log10_r, _orbit_errors(_WAVE, log10_r, (_CELLS - 1, _CELLS))) for log10_r in orbits_at]
    means = [_means_verdict(log10_r) for log10_r in means_at]
    marches = {model: _march_errors(model) for model in _TIMED}
    slabs = budget.plan(["alike"], [*_MOTION_MARCH])
    pairs = [(model, pair) for model in MOTION_GRIDS for pair in slabs]
    motions = {pair: _motion_errors(*pair) for pair in budget.each(pairs, 0.9, 0.6)}
    event = _recorded_event()
    finest = ", ".join(f"{plain(max([*ladder.values()][-1].values()), '.0e')} (`{model}`)" for model, _, ladder in orbits)
    moved = plain(min(sizes[-1] for sizes in motions.values()), ".0e")
    return StudyResult(
        answers={
            (
                "Four kinds of full wave, which share no module of a solver with it, converge to the delay system at their "
                "orders in every output; period and stress drop of their own orbits are those of the delay system within "
                f"{finest}."
            ): (ORDER, _JUMP, _INDEPENDENT, _APPROACHES, _AGREES, _MEANS),
            (
                f"They make an exact motion with waves, friction and state to {moved} of its range; the two marches of a grid "
                "agree, and waves cross the slabs unchanged."
            ): (_MADE, _STEPS, _MARCHES, _KEEPS, _STRAIGHT, _ENDED),
        },
        figures=(
            Figure("space", _SPACE, lambda: _errors_chart(map(_space_errors, climbs))),
            Figure(
                "motion",
                _MOTION,
                lambda: _errors_chart(
                    (f"{pair} slabs", model, np.array(MOTION_GRIDS[model][0]), sizes) for (model, pair), sizes in motions.items()
                ),
            ),
        ),
        verdicts=(
            *map(order_verdict, climbs),
            *(order_verdict(climbed, _evidence_at(cfl)) for cfl, climbed in other_cfls.items()),
            *(
                of_order(_JUMP, _evidence_at(cfl), fit_order(np.array(jump_cells), sizes), 1.0, f"CFL {cfl}")
                for cfl, sizes in jumps.items()
            ),
            _independence(),
            *(_approach_verdict(model, ladder) for model, _, ladder in orbits),
            *(verdict for orbit in (*orbits, *others) for verdict in _agreement_verdicts(*orbit)),
            *means,
            *(verdict for model, times in marches.items() for verdict in _time_verdicts(model, *times)),
            *(_motion_verdict(*pair, sizes) for pair, sizes in motions.items()),
            *_event_verdicts(event),
        ),
        notes=_NOTES,
        numbers=_numbers(climbs, motions),
    )


def _numbers(climbs: Iterable[Climb], motions: Mapping[tuple[str, str], np.ndarray]) -> dict[str, Number]:
    together = {climbed.ladder.model: climbed.fits["together"] for climbed in climbs if not climbed.lost}
    numbers = {f"{model} order": stated(fit.order, fit.half_width) for model, fit in together.items()}
    alike = {model: sizes for (model, pair), sizes in motions.items() if pair == "alike"}
    return numbers | {f"error, {model}, alike": Number(sizes[1], 0.02) for model, sizes in alike.items()}


def _errors_chart(curves: Iterable[tuple[str, str, np.ndarray, np.ndarray]]) -> Chart:
    """Errors over points per slab, a line for each (panel, model, cells, errors)."""
    points = Scale("points per slab", "log", ticks={n: f"{n:g}" for n in (10.0, 20.0, 50.0, 100.0, 200.0)})
    lines: dict[str, list[Trace]] = {}
    for title, model, cells, sizes in curves:
        family, number = grid_of(model)
        look = Look(style_of(model).color, "-", _MARKERS[number % len(_MARKERS)], 1.0)
        lines.setdefault(title, []).append(Trace(model, cells * family.points(number), sizes, look))
    panels = [Panel(title, points, Scale("error", "log", floor=1e-14), traces, grid=True) for title, traces in lines.items()]
    return Chart(panels, 4.3, len(panels), legend="outside upper left", legend_columns=6)


_MARKERS = "xosD^vP"  # by the number of a model
_SPACE = (
    "Geometric mean of the errors in every output against the delay system: relative root mean squares over all cycles, and of "
    "ψ, ln v and μ at the end."
)
_MOTION = (
    f"Root-mean-square errors of ln v, ψ and μ from t = {BEGIN:g} to {UNTIL:g} transits, relative to their ranges, against the "
    "exact motion. Unlike slabs: round trips as 1 to 3, impedances as 2 to 3, explicit steps."
)


def _run_text(run: LadderRun) -> str:
    return f"log_{{10}} r = {run.log10_r:g} for {run.until:g} transits".replace("-", "−")


_NOTES = (
    f"Orders in space: paper’s material, V = {GENTLE.scene.velocity:g}, smooth start, {_run_text(GENTLE)}; orders from 5 on "
    f"{_run_text(ROUGH)}, from 7 on {_run_text(STEEP)}; from order 3 on marched exactly in time. A fit begins with the coarsest "
    f"grid from which on every error is below {RESOLVED:g}^{{−order}} and ends above {plain(FLOOR_IN_SPACE, '.0e')}; coarse "
    "grids are left out while the logarithms are significantly curved. `fem:1` and `sbp:2` are algebraically the same scheme.",
    "In the exact motion no equation has a source: the state is prescribed, the ageing law gives the slip rate, friction the "
    "stress, and d’Alembert’s solution the V(t) of the outer faces that sends these waves.",
)

# in space: from a smooth start, and from a jump

_JUMP = "From a jump, which returns every transit, the leapfrog is of order 1"
_INDEPENDENT = "The delay system shares no module of a solver with any full wave"
_CFLS = (0.5, 0.9, 1.0)
_FEW = ("fd", "sbp:2", "sbp:4", "sbp:6", "fem:7", "dg:2", "dg:7")
_JUMP_UNTIL = 400.0  # transits
_JUMP_CELLS = (48, 96, 192, 384, 768)


def _judged_models(quick: bool) -> tuple[str, ...]:
    """The members whose order is fitted: in a quick report some of those with a ladder, one of every family at least."""
    seen = {model.partition(":")[0] for model in _FEW}
    others = (family.called(next(iter(family.ladder))) for family in GRIDS if family.ladder and family.name not in seen)
    return (*_FEW, *others) if quick else tuple(LADDERS)


def _leapfrog_at(cfl: float) -> Climb:
    """The leapfrog at another Courant number; at 1 it is the delay system under the midpoint rule."""
    ladder = in_space(replace(LADDERS["fd"], cfl=cfl))
    return climb(ladder, delay_reference(ladder.run), without_error_in_time)


def _space_errors(climbed: Climb) -> tuple[str, str, np.ndarray, np.ndarray]:
    """Kind of scheme, model, cells, and the geometric mean of all errors."""
    model = climbed.ladder.model
    kind = {"fem": "finite elements", "dg": "discontinuous Galerkin"}.get(grid_of(model)[0].name, "differences")
    return kind, model, climbed.cells, np.exp(np.mean(np.log([*climbed.errors.values()]), axis=0))


def _evidence_at(cfl: float) -> Evidence:
    """At CFL 1 the leapfrog carries waves without error: it is no independent witness of the delay system."""
    return SELF if cfl == 1.0 else WITNESS


def _jump_errors(cfl: float, cells: Iterable[int]) -> np.ndarray:
    """Errors of psi after `_JUMP_UNTIL` transits."""
    known = state_at("yardstick", _JUMP_UNTIL, tol=1e-11)
    return np.array([abs(state_at("yardstick", _JUMP_UNTIL, "fd", cells=n, cfl=cfl) - known) for n in cells])


def _modules_of(family: str) -> frozenset[str]:
    """Modules of the project that a family's solver uses, as `fullwave.lines.march`."""
    module = next(facts.module for facts in FAMILIES if facts.name == family)
    start = ROOT.joinpath(*module.split(".")).with_suffix(".py")
    files = (path.relative_to(ROOT).with_suffix("") for path in import_closure([start], packages=False))
    return frozenset(".".join(path.parts).removesuffix(".__init__") for path in files)


def _shared(model: str, other: str) -> tuple[str, ...]:
    """Modules outside `slipwave` that two families share, without the tables of facts, which compute nothing."""
    common = _modules_of(model) & _modules_of(other)
    return tuple(sorted(name for name in common if not name.startswith("slipwave") and not name.endswith(".families")))


def _independence() -> Verdict:
    """What the imports say."""
    waves = [family.name for family in GRIDS]
    apart = sum(not _shared("delay", name) for name in waves)
    among = ", ".join(f"`{model}` and `{other}` {len(_shared(model, other))}" for model, other in combinations(waves, 2))
    return every(_INDEPENDENT, EXACT, apart, len(waves), f"by their imports; all share `slipwave`; modules in common: {among}")


# on the grids' own periodic orbits

_APPROACHES = "The grid’s own orbit approaches the delay system’s at the declared order or faster"
_AGREES = "Discretisations of the wave agree with the delay system on the orbit’s period and stress drop"
_MEANS = "Where the motion is irregular, means of T and Δμ of the full wave are the delay system’s"
_QUANTITIES = {"period": ("T", 1e-12), "stress_drop": ("Δμ", 5e-12)}
"""The figures, their symbols, and relative errors, at the level of rounding, below which no order is fitted."""
_AT, _TOLERANCE = -2.68, 1e-11
_WAVE, _CELLS = "dg:7", 6
_FEW_GRIDS: dict[str, tuple[int, ...]] = {"dg:7": (2, 3), "fem:4": (5, 8)}
_MANY_GRIDS = {"dg:7": (2, 3, 4, 5, 6), "fem:4": (5, 8, 12, 16, 24), "sbp:6": (24, 32, 48, 64, 96, 160)}
"""By model: cells per slab of its own orbits."""
_MEANS_UNTIL, _ERRORS = 10000.0, 4.0  # transits; standard errors
_NEAR_ONSET = {"start.size": 2.0}  # a small nudge grows for thousands of transits


def _orbit_errors(model: str, log10_r: float, cells: Iterable[int]) -> dict[int, dict[str, float]]:
    """Relative errors of the figures of a grid's own orbit, stable or not, against the delay system's, by cells."""
    exact, own = _figures("delay", log10_r, None), {n: _figures(model, log10_r, n) for n in cells}
    return {n: {name: abs(figures[name] / exact[name] - 1.0) for name in _QUANTITIES} for n, figures in own.items()}


def _figures(model: str, log10_r: float, cells: int | None) -> dict[str, float]:
    near = _NEAR_ONSET if log10_r < -2.697 else {}
    own = sw.orbit("paper", model, cells=cells, tol=_TOLERANCE, **{"slab.log10_r": log10_r}, **near)
    return own.scene_orbit.periodic.orbit.values()


def _orbit_order(ladder: Mapping[int, Mapping[str, float]], quantity: str) -> float:
    """Mean order from the coarsest grid to the finest one whose error is above the floor, the second one in any case."""
    (coarse, first), *finer = ((cells, figures[quantity]) for cells, figures in ladder.items())
    fine, last = next((level for level in reversed(finer) if level[1] > _QUANTITIES[quantity][1]), finer[0])
    return math.log(first / last) / math.log(fine / coarse)


def _approach_verdict(model: str, ladder: Mapping[int, Mapping[str, float]]) -> Verdict:
    """The order of the errors on finer and finer grids."""
    least = min(_orbit_order(ladder, quantity) for quantity in _QUANTITIES)
    where = f"`{model}`, {min(ladder)} to {max(ladder)} cells a slab; the lower of T and Δμ"
    return at_least(_APPROACHES, WITNESS, least, declared_order(model), where)


def _agreement_verdicts(model: str, log10_r: float, ladder: Mapping[int, Mapping[str, float]]) -> Verdicts:
    """The errors on the finest grid, below twice what the declared order leaves of those on the one before."""
    before, last = [*ladder][-2:]
    where = f"`{model}` with {last} cells, log_{{10}} r = {log10_r:g}".replace("-", "−")
    for name, (symbol, _) in _QUANTITIES.items():
        limit = error_after(model, ladder[before][name], before, last) + _TOLERANCE
        yield claim(_AGREES, WITNESS, ladder[last][name], limit, f"{symbol}, {where}")


def _means_verdict(log10_r: float) -> Verdict:
    """Means of the full wave and of the delay system over the cycles of a run, by their standard errors."""
    (wave, known), (delay, others) = (_means_of(model, log10_r) for model in (_WAVE, "delay"))
    off = max(2.0 * abs(wave[name] - delay[name]) / math.hypot(known[name], others[name]) for name in _QUANTITIES)
    return claim(_MEANS, WITNESS, off, _ERRORS, f"log_{{10}} r = −{-log10_r:g}; the larger of both", unit="standard errors")


def _means_of(model: str, log10_r: float) -> tuple[dict[str, float], dict[str, float]]:
    """Means of the figures over the cycles of a long run, and their margins (95 %)."""
    options: dict[str, Any] = {"cells": _CELLS} if model == _WAVE else {"tol": 1e-7}
    summary = sw.run("paper", model, until=_MEANS_UNTIL, **options, **{"slab.log10_r": log10_r}).summary
    return {name: summary[name]["mean"] for name in _QUANTITIES}, {name: summary["margins"][name] for name in _QUANTITIES}


# in time: the exact and the explicit march of one grid share neither steps nor friction solve; the delay system has its friction
# step in common with the exact march

_COURANT = tuple(2.0 ** (-k / 4) for k in range(1, 9))
_REQUESTS = tuple(10.0**-k for k in range(4, 12))
"""Errors requested of the exact march."""
_TIMED = {"sbp:6": 32, "fem:4": 6, "dg:7": 3}
"""By model: cells on which the error in time is seen over several powers of ten."""
_STEPS = "On one grid the explicit march approaches the exact one at the order of its Runge-Kutta method"
_MARCHES = "The exact and the explicit march of one grid agree in every output"
_KEEPS = "The exact march keeps the error requested of it, measured by the explicit march of the same grid"
_RESOLUTION, _FLOOR, _ROUNDING = 1e-13, 2e-12, 1e-11


def _march_errors(model: str) -> tuple[np.ndarray, np.ndarray]:
    """Largest error of any output by the marches of one grid: explicit (_COURANT) against the exact march, exact (_REQUESTS)
    against the shortest explicit steps."""

    def explicit(courant: float) -> Solver:
        """The solver with steps of the share `courant` of the longest stable one."""
        return build(model, GENTLE.scene, cells=_TIMED[model], cfl=courant, time="explicit")

    def exact(request: float) -> Solver:
        """The solver with steps that resolve friction to the error `request`."""
        return without_error_in_time(model, GENTLE.scene, _TIMED[model], request)

    def largest(make: Callable[[float], Solver], settings: tuple[float, ...], other: Solver) -> np.ndarray:
        """The largest error of any output against the `other` march, by setting."""
        known = measure(other, GENTLE)
        return np.array([max(errors(measure(make(setting), GENTLE), known).values()) for setting in settings])

    return largest(explicit, _COURANT, exact(_RESOLUTION)), largest(exact, _REQUESTS, explicit(_COURANT[-1]))


def _time_verdicts(model: str, explicit: np.ndarray, exact: np.ndarray) -> Verdicts:
    """Order of the explicit march; the marches' distance, against what that order leaves of the longest steps' error; the largest
    error of an exact march over the requested one, which the explicit steps and rounding may add to."""
    (family, number), where = grid_of(model), f"`{model}` with {_TIMED[model]} cells"
    declared, apart = family.order_in_time(number), explicit[-1]
    order = fit_dense(1.0 / np.array(_COURANT), explicit, 0, _FLOOR)
    yield of_order(_STEPS, WITNESS, order, declared, where, within=0.5, above=True, widest=1.0)
    foreseen = explicit[0] * (_COURANT[-1] / _COURANT[0]) ** declared + _FLOOR
    yield claim(_MARCHES, WITNESS, apart, foreseen, where)
    share = (exact / (np.array(_REQUESTS) + apart + _ROUNDING)).max()
    yield claim(_KEEPS, WITNESS, share, 1.0, f"{where}; the largest error over its request")


# against an exact motion with waves, friction and state, imposed by the drive

_SECOND, _THIRD, _FOURTH = (32, 48, 64, 96, 128), (12, 16, 20, 24, 32), (10, 12, 14, 16, 18, 20)
MOTION_GRIDS = {
    "fd": (_SECOND, 7e-5),
    "sbp:2": (_SECOND, 4e-4),
    "sbp:4": ((32, 40, 48, 64, 96), 4e-6),
    "sbp:6": ((36, 40, 44, 48, 56, 64), 8e-7),
    "fem:1": (_SECOND, 4e-4),
    "fem:2": (_THIRD, 1e-5),
    "fem:3": (_FOURTH, 3e-6),
    "fem:4": ((6, 8, 10, 12, 16), 8e-8),
    "dg:1": ((48, 64, 80, 96, 128), 4e-4),
    "dg:2": (_THIRD, 2e-5),
    "dg:3": (_FOURTH, 1.2e-6),
    "dg:4": ((6, 7, 8, 10, 12), 7e-7),
}
"""By model: cells per slab, and a bound of the error on the finest grid, twice that measured of unlike slabs."""
_MOTION_MARCH = {"alike": "exact", "unlike": "explicit"}
"""Pair of slabs -> march in time, except for the leapfrog, which has one."""
_MADE = "Full waves make an exact motion with friction and state at their orders"
_CFL = 0.5  # of the leapfrog; at 1 it is the delay system


def _motion_errors(model: str, pair: str) -> np.ndarray:
    """The errors of a model on all its grids, for a pair of slabs."""
    options: dict[str, Any] = {"cfl": _CFL} if model == "fd" else {"time": _MOTION_MARCH[pair]}
    scene = given_scene(pair == "unlike")
    return np.array([error_of_motion(model, scene, cells, **options) for cells in MOTION_GRIDS[model][0]])


def _motion_verdict(model: str, pair: str, errors: np.ndarray) -> Verdict:
    """The order, unless the finest error is not below the bound. Schemes of order 2 must not be better either."""
    (cells, bound), declared, where = MOTION_GRIDS[model], declared_order(model), f"`{model}`, {pair} slabs"
    if errors[-1] < bound:
        return of_order(_MADE, EXACT, fit_order(np.array(cells), errors), declared, where, above=declared != 2)
    return claim(_MADE, EXACT, errors[-1], bound, f"{where}: error on {cells[-1]} cells")


# the waves of one slip event over time and depth: they cross the slabs unchanged, and the returning one ends the event

_STRAIGHT = "Waves cross the slabs on straight characteristics, unchanged"
_ENDED = "The wave of the fastest slip, back from the outer face after one transit, ends the event"
_DEGREE, _FINE = 7, 16
_EVENT_UNTIL = 8.0  # transits; the orbit begins with an event
_CURVED, _LATE = 1e-10, 0.1  # of the wave's range; transits


EventWaves: TypeAlias = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""The upper slab about one slip event: time (transits) from its fastest moment, depth of the ends of cells, the outgoing wave,
stress - epsilon velocity, over time and depth, and the slip rate over V."""


def _recorded_event() -> EventWaves:
    """The event with which a run from the periodic orbit begins; the time between samples is a wave's through half a cell."""
    scene = sw.read("paper", {"start.kind": "orbit"})
    fields = sw.run(scene, f"dg:{_DEGREE}", cells=_FINE, until=_EVENT_UNTIL, fields=True).records.fields
    assert fields
    time, upper = fields.field.time, fields.field.upper
    outgoing, fastest = upper.stress - scene.upper.epsilon * upper.velocity, np.argmax(upper.velocity[:, 0])
    rate = 2.0 * upper.velocity[:, 0] / scene.velocity
    return time - time[fastest], upper.depth[::_DEGREE], outgoing[:, ::_DEGREE], rate


def _event_verdicts(event: EventWaves) -> Verdicts:
    """The outgoing wave at each depth against that of the interface one travel time before; the time until the slip rate, twice
    the velocity at the interface, falls below V."""
    time, depths, outgoing, rate = event
    source, off = CubicSpline(time, outgoing[:, 0]), 0.0
    for depth, wave in zip(depths, outgoing.T, strict=True):
        emitted = time - 0.5 * depth
        inside = emitted >= time[0]
        off = max(off, np.abs(wave - source(emitted))[inside].max())
    where = f"`dg:{_DEGREE}`; the largest difference over the range"
    yield claim(_STRAIGHT, EXACT, off / np.ptp(outgoing[:, 0]), _CURVED, where)
    stop = time[(time > 0.0) & (rate < 1.0)].min(initial=np.inf)
    yield claim(_ENDED, EXACT, stop, _LATE, "transits from the fastest moment until v falls below V", near=1.0)
