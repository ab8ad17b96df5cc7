"""The delay system's branch of orbits folds back and forth: evidence from two meshes and from direct runs, which settle or
wander, and show the multipliers. About a kernel, the orbits of `reduced`.

Each run near a special point begins near an orbit on one side of it, displaced in the direction of the critical multiplier, which
is measured by how the run departs or returns.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import slipwave as sw
from reduced.continuation.special import Special, critical
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable, floquet
from reduced.orbit.periodic import figures_of
from slipwave.observe import HistoryObserver
from slipwave.observe.statistics import Estimate
from slipwave.solve import follow
from validation.chart import DOTTED, ORANGE, Chart, Look, Panel, Scale, Trace
from validation.chart.looks import model_look
from validation.chart.thin import staying
from validation.measure import memo
from validation.measure.over_r import COMPARED, Branch, branch_of, parts, scene_at
from validation.models.build import build
from validation.models.orbit_start import BEGIN, state_on
from validation.references.published import reference
from validation.report import (
    ASYMPTOTIC,
    PROGRAM,
    SELF,
    WITNESS,
    Answers,
    Budget,
    Cell,
    Figure,
    StudyResult,
    Table,
    Verdicts,
    claim,
    every,
    holding,
    minus,
    plain,
    table,
)
from validation.report.branch_drawing import branch_keys, branch_traces
from validation.report.known import numbered_period

NAME = "snaking"
QUESTION = "How many orbits does the exact system have at one r, and which of them are stable?"
SCENES = ("paper",)
SECONDS = (12.0, 54.0)

_FINER, _SHORT = 1e-8, 0.01
_NUDGES = (0.5, 2.0)
"""Sizes of the nudges of runs that may end on different orbits."""

_BEFORE, _BEYOND = -2.659, -2.6565
"""log10 r of direct runs on both sides of the first torus point, where the branch has one orbit."""


class _DirectRun(NamedTuple):
    """A run from a nudge of this `size`: the periods of the cycles of its last part (transits), whether they settled, and the
    period of the branch's `orbit` nearest to its last cycle, of the stable ones if there are any."""

    log10_r: float
    size: float
    last: np.ndarray
    settled: bool
    orbit: float


def run(budget: Budget) -> StudyResult:
    """Follow the branch twice, list the orbits at some r, and run the delay system near the first torus point."""
    branch = branch_of("delay", -2.3, budget.plan(quick=78.5, full=85.0))
    budget.report(0.5)
    finer = branch_of("delay", -2.3, budget.plan(quick=75.2, full=78.3), _FINER, _SHORT)
    budget.report(0.9)
    shown = budget.plan(quick=(-2.66,), full=(-2.66, -2.65, -2.64, -2.63, -2.62))
    orbits = {log10_r: branch.orbits_at(log10_r) for log10_r in shown}
    coexist = budget.plan(quick=(-2.66,), full=(-2.6655, -2.66, -2.6595))
    starts = [(log10_r, size) for log10_r in coexist for size in _NUDGES]
    before, *others, beyond = (
        _run_at(log10_r, size, branch.orbits_at(log10_r))
        for log10_r, size in ((_BEFORE, _NUDGES[0]), *starts, (_BEYOND, _NUDGES[0]))
    )
    return StudyResult(
        answers=_answers(branch, max(map(len, orbits.values()))),
        figures=(
            Figure("snake", _SNAKE, lambda: _snake(branch, [before, beyond]), zoom=True, beside="orbits"),
            Figure("orbits", _ORBITS, lambda: _orbits_along(branch), zoom=True),
        ),
        tables=(_window_table(branch), _coexisting_table(orbits)),
        verdicts=(
            *_fold_claims(branch, finer),
            *_of_runs([before, *others], beyond, sides(branch, *budget.plan(quick=(1, 4), full=(0, 1)))),
        ),
        notes=(_WHY,),
        numbers={
            f"T at {log10_r:g}, orbit {n}": numbered_period(closed)
            for log10_r, coexisting in orbits.items()
            for n, closed in enumerate(coexisting, 1)
        },
    )


def _answers(branch: Branch, most: int) -> Answers:
    torus, last = branch.of_kind("NS")[0].point, branch.points[-1].closed.cycle.period
    return {
        (
            f"The exact system has up to {most} orbits at one r. Its branch folds back and forth, with "
            f"{len(_fold_pairs(branch))} pairs of folds up to T = {last:.1f} transits; where two of its orbits are "
            "stable, the start decides."
        ): ("Special points depend", "Folds come in pairs", "Two stable orbits coexist"),
        minus(
            f"Its orbits are stable up to a torus point at log_{{10}} r = {torus.parameter:.7f}, except between the folds of "
            "a pair; beyond it they are stable in short windows only."
        ): ("Before the first torus point", "Beyond the first torus point", "On both sides", "A run on the torus"),
    }


_SNAKE = (
    "Period T of the delay system’s orbits over r: the bifurcation diagram, enlarged. Thick and solid: stable; thin and dotted: "
    "unstable. Orange: periods of direct runs, with bars from the least to the largest: one settles, the other does not. "
    "Right: the number of multipliers outside the unit circle along the branch."
)
_ORBITS = (
    "Stress over one period of orbits along the branch, from its low end (below) to its high one, each raised above the one "
    "before. Solid: stable; dotted: unstable."
)
_WHY = (
    "Ripples of one transit decorate the cycle. As r grows, T grows, and a new ripple enters the cycle about once per transit of "
    "T; each time the branch turns to smaller r and back. Such snakes are known of other systems with long delays."
)

_ALONG, _RAISED, _POINTS = 24, 0.15, 400  # orbits, their distance, points of each
_LEAST = 74.0
"""Period (transits) from which the branch is shown."""


def _window_table(branch: Branch) -> Table:
    rows = []
    for stable, part in parts(branch.corners):
        if stable and part[-1].period > _LEAST:
            low, high = sorted([part[0].value, part[-1].value])
            rows.append((part[0].period, part[-1].period, low, high, high - low))
    heading = "T from [transits] .4f | to [transits] .4f | log_{10} r from .7f | to .7f | width [log_{10} r] .2e"
    return table("windows", "Parts of the branch with stable orbits, in order along the branch.", heading, rows)


def _orbits_along(branch: Branch) -> Chart:
    """The stress of some orbits in order along the branch, each offset by `_RAISED`."""
    points = [point for point in branch.points if point.closed.cycle.period > _LEAST]
    traces = []
    for k, n in enumerate(np.linspace(0, len(points) - 1, _ALONG).astype(int)):
        closed = points[n].closed
        cycle = memo.cycle_of(closed, 0.0, 0.0)
        name = minus(f"T = {closed.cycle.period:.3f}, log10 r = {points[n].parameter:.5f}")
        look = model_look("delay", dashes=DOTTED if points[n].unstable else "-", width=0.8)
        kept = staying(cycle.time, cycle.stress, _POINTS)
        traces.append(Trace(name, cycle.time[kept], cycle.stress[kept], look, shift=(0.0, _RAISED * k)))
    raised = rf"$\mu$, each orbit {_RAISED:g} above the one before"
    return Chart([Panel("", Scale("time since the slip event (transits)"), Scale(raised), traces)], 6.0)


def _snake(branch: Branch, runs: Iterable[_DirectRun]) -> Chart:
    """T over log10 r, with the periods of direct runs, and the number of unstable multipliers."""
    corners = [corner for corner in branch.corners if corner.period > _LEAST]
    periods, r = [corner.period for corner in corners], [corner.value for corner in corners]
    ends = np.array([(run.log10_r, run.last.min(), run.last.max()) for run in runs]).T
    middle, half = 0.5 * (ends[1] + ends[2]), 0.5 * (ends[2] - ends[1])
    seen = Trace("direct run, all its periods", ends[0], middle, Look(ORANGE, "", "o", hollow=True), y_error=half)
    outside = Trace("", [corner.unstable or 0 for corner in corners], periods, Look(kind="steps-pre", width=1.0))
    up = Scale("$T$ (transits)", limits=(_LEAST, max(periods)))
    across = Scale(r"$\log_{10} r$", limits=(min(r) - 0.002, max(r) + 0.002))
    panels = (
        Panel("", across, up, [*branch_traces(branch, "period"), seen], grid=True),
        Panel("", Scale("count outside", ticks={0.0: "0", 1.0: "1", 2.0: "2"}), up, [outside], grid=True),
    )
    keys = [*branch_keys(("LP", "NS")), seen]
    return Chart(panels, 6.4, 2, widths=(4.0, 1.0), legend="outside upper left", legend_columns=4, keys=keys)


_MOST = 9000.0
_LAST = 0.7  # share of a run after which its cycles are judged
_TORUS = 16000.0
_CYCLES, _SAMPLES = 4, 300  # of a run near a special point; samples of a cycle
_OFF = 1e-6  # largest component of the state by which such a run is off its orbit
_REAL = 1e-9  # imaginary part below which a multiplier is real

_MESHES = 1e-10
_ONE = 0.2  # distance from 1 of the last growth of T
_SAME = 2e-9  # the rest of the run
_ROTATION = 5e-4
_PASSES = 4e-6
_WANDERS = 1e-2  # transits, on both sides of the unstable orbit's period


def _run_at(log10_r: float, size: float, orbits: Sequence[Closed]) -> _DirectRun:
    """A run of the delay system until its cycles stop changing, 9000 transits at most; `orbits`: those of the branch there."""
    scene = scene_at(log10_r)
    settled = memo.settled("delay", replace(scene, start=replace(scene.start, size=size)), 1e-10, 1e-8, _MOST)
    last = settled.observer.events(_LAST * settled.transits).period
    known = [orbit.cycle.period for orbit in orbits if count_unstable(orbit) == 0] or [orbit.cycle.period for orbit in orbits]
    return _DirectRun(log10_r, size, last, settled.settled, min(known, key=lambda period: abs(period - last[-1])))


def _torus_at(log10_r: float) -> tuple[float, Estimate]:
    """The rotation number of the delay system's run at `log10_r`, and its mean period (transits) with its margin."""
    run = sw.run(sw.read("paper", {"slab.log10_r": log10_r}), model="delay", until=_TORUS, tol=1e-8).summary
    return run["rotation_number"] or math.nan, Estimate(run["period"]["mean"], run["margins"]["period"])


def _multiplier_seen(apart: np.ndarray, turns: bool) -> complex:
    """The multiplier m of the distance `apart` (cycles, values) of two runs, by least squares: d_(n+1) = m d_n or, if it `turns`,
    the one above the real axis of d_(n+2) = 2 Re(m) d_(n+1) - |m|^2 d_n."""
    first, second, third = (apart[k : apart.shape[0] + k - turns - 1].ravel() for k in (0, 1, 1 + turns))
    if not turns:
        return complex(second @ first / (first @ first))
    twice, square = np.linalg.lstsq(np.column_stack([second, -first]), third, rcond=None)[0]
    return complex(0.5 * twice, np.sqrt(max(square - 0.25 * twice**2, 0.0)))


def sides(branch: Branch, first: int = 0, stride: int = 1) -> list[tuple[float, complex, complex]]:
    """The points of the delay branch before and beyond its special points, from the `first` special point on with this `stride`:
    log10 r, and the critical multiplier, of the orbit and as seen in runs."""
    number, points = {id(point): n for n, point in enumerate(branch.points)}, []
    for special in branch.special[first::stride]:
        for point in (branch.points[number[id(special.point)] + beside] for beside in (-1, 1)):
            values, vectors = np.linalg.eig(point.closed.monodromy)
            others = np.delete(values, np.abs(values - 1.0).argmin())
            passing = critical(special.kind, others.astype(complex))
            vector = vectors[:, np.abs(values - passing).argmin()].real
            direction = vector / np.abs(vector).max()
            apart = _cycles(point.closed, _OFF * direction) - _cycles(point.closed, -_OFF * direction)
            points.append((point.parameter, passing, _multiplier_seen(apart, abs(passing.imag) > _REAL)))
    return points


def _cycles(closed: Closed, change: np.ndarray) -> np.ndarray:
    """z and psi (cycles, 2 samples) in the cycles of a run that begins on the orbit displaced by a `change` of its state."""
    cycle, period = closed.flow.march(closed.cycle.start + change, closed.cycle.period), closed.cycle.period
    solver = build("delay", closed.flow.scene, tolerance=1e-11)
    solver.restore(state_on(solver, replace(closed, cycle=cycle)))
    history = HistoryObserver(solver.scene.law, solver.nodes)
    times = BEGIN + 1.0 + np.linspace(0.0, period, _SAMPLES, endpoint=False)
    follow(solver, float(times[-1]) + _CYCLES * period, [history])
    return np.array([history.at(times + n * period)[1:3].ravel() for n in range(_CYCLES + 1)])


def _fold_pairs(branch: Branch) -> list[tuple[Special, Special]]:
    """Pairs of folds after the first: where the branch turns to smaller r, and where it turns back."""
    folds = branch.of_kind("LP")[1:]
    return list(zip(folds[::2], folds[1::2], strict=False))


def _fold_claims(branch: Branch, finer: Branch) -> Verdicts:
    """Verdicts: the special points agree with those on a finer mesh with shorter steps; the growth of T from pair to pair of
    folds."""
    title = "Special points depend neither on the mesh nor on the length of steps"
    both = list(zip(branch.special, finer.special, strict=False))
    off = max(abs(special.point.parameter - other.point.parameter) for special, other in both)
    sizes = " and ".join(str(special.point.closed.flow.size) for special in both[-1])
    mesh = f"mesh: largest change of log_{{10}} r of {len(both)} points, states of {sizes} values at the last one"
    yield claim(title, SELF, off, _MESHES, mesh)
    kinds, others = ([special.kind for special in some.special[: len(both)]] for some in (branch, finer))
    last = finer.points[-1].closed.cycle.period
    beyond, finely = sum(point.point.closed.cycle.period < last for point in branch.special), len(finer.special)
    up_to = f"steps of half the length: special points up to T = {last:.1f} transits"
    verdict = holding(title, SELF, f"{beyond} points", f"{finely} points", kinds == others and beyond == finely, up_to)
    yield verdict.with_margin(abs(finely - beyond), 1.0)
    growth = np.diff([turn.point.closed.cycle.period for turn, _ in _fold_pairs(branch)]).tolist()
    yield claim(
        "Folds come in pairs, and T grows by one transit from pair to pair: each pair lets one more ripple into the cycle",
        ASYMPTOTIC,
        growth[-1],
        _ONE,
        f"T grows by {', '.join(f'{factor:.3f}' for factor in growth)}; the last is judged",
        near=1.0,
    )


def _coexisting_table(coexisting: dict[float, list[Closed]]) -> Table:
    """Figures and largest multiplier of the orbits of the branch, by log10 r."""
    rows: list[tuple[Cell, ...]] = []
    for log10_r, orbits in coexisting.items():
        for closed in orbits:
            lead, figures = floquet(closed.monodromy)[0][0], figures_of(closed)
            words = plain(lead.real, ".4f") + (f" ± {plain(abs(lead.imag), '.4f')} i" if lead.imag else "")
            rows.append((log10_r, *(figures[name] for name in COMPARED), float(count_unstable(closed)), words))
    heading = "log_{10} r .2f | T [transits] .7f | Δμ [σ] .7f | Δy [σ] .7f | unstable .0f | largest multiplier"
    caption = "Orbits of the branch that coexist at one r; unstable: multipliers outside the unit circle."
    return table("coexisting", caption, heading, rows)


def _of_runs(settle: Sequence[_DirectRun], wander: _DirectRun, beside: Sequence[tuple[float, complex, complex]]) -> Verdicts:
    """Runs before the torus point against the orbits of the branch, and one beyond; runs on both sides of special points; those
    from different nudges at one r; a long one beyond the first torus point against the independent program's."""
    for run in settle:
        title = "Before the first torus point direct runs settle on orbits of the branch"
        remark = minus(f"log_{{10}} r = {run.log10_r:g}, nudge {run.size:g}: T of the run over that of the orbit")
        yield claim(title, WITNESS, run.last[-1] / run.orbit if run.settled else math.nan, _SAME, remark, near=1.0)
    low, high = wander.last.min(), wander.last.max()
    apart = min(wander.orbit - low, high - wander.orbit)
    yield holding(
        "Beyond the first torus point a direct run does not settle, and its periods lie on both sides of the unstable orbit’s",
        WITNESS,
        f"around {wander.orbit:.4f}",
        f"{low:.3f} to {high:.3f}",
        not wander.settled and apart > _WANDERS,
        minus(f"log_{{10}} r = {wander.log10_r:g}, T in transits; at least {_WANDERS:g} apart"),
    ).with_margin(_WANDERS / apart if apart > 0.0 else math.inf, 1.0)
    title = "On both sides of special points, direct runs depart or come back by the multiplier that passes there"
    off = max(abs(seen / orbit - 1.0) for _, orbit, seen in beside)
    yield claim(title, WITNESS, off, _PASSES, f"largest relative difference, {len(beside)} sides")
    title = "Two stable orbits coexist at one r: the size of the nudge decides on which a run settles"
    for log10_r in dict.fromkeys(run.log10_r for run in settle[1:]):
        periods = {run.size: run.orbit for run in settle[1:] if run.log10_r == log10_r}
        listed = ", ".join(f"{period:.4f} from {size:g}" for size, period in periods.items())
        count = len({round(period, 6) for period in periods.values()})
        yield every(title, WITNESS, count, 2, minus(f"log_{{10}} r = {log10_r:g}: T {listed}"), "orbits")
    title = "A run on the torus has the rotation number and the mean period that another program finds"
    known = reference()["torus"]
    rotation, period = _torus_at(known["log10_r"])
    where = minus(f"log_{{10}} r = {known['log10_r']:g}")
    yield claim(title, PROGRAM, rotation, _ROTATION, f"rotation number, {where}", near=known["rotation_number"])
    yield claim(title, PROGRAM, period.value, period.error, f"mean T with its margin, {where}", near=known["mean_period"])
