"""Direct runs of the delay system near its branch: where they settle or wander, and the multipliers measured in them; and the
claims on the snake of folds.

Each run near a special point begins near an orbit on one side of it, displaced in the direction of the critical multiplier, which
is measured by how the run departs or returns.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from reduced.continuation.point import OrbitPoint
from reduced.continuation.special import Special, critical
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable, floquet
from slipwave.friction import unknown_of
from slipwave.observe import HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate, mean_of
from slipwave.observe.torus import rotation
from slipwave.solve import follow
from validation.compute.build import build
from validation.compute.orbit_start import BEGIN, state_on
from validation.references.published import reference
from validation.study import ASYMPTOTIC, SELF, WITNESS, Verdict, claim, every, holding, memo
from validation.study.over_r import Branch, scene_at
from validation.study.text import minus

_MOST = 9000.0
_LAST = 0.7  # share of a run after which its cycles are judged
_TRANSIENT, _TORUS = 6000.0, 16000.0
_APART = 40.0  # transits between two slip events, at least
_LINEAR = (1e-5, 1e-3)  # deviations of T (transits) between which a multiplier is fitted
_CYCLES, _SAMPLES = 4, 300  # of a run near a special point; samples of a cycle
_OFF = 1e-6  # largest component of the state by which such a run is off its orbit
_REAL = 1e-9  # imaginary part below which a multiplier is real

_MESHES = 1e-10
_ONE = 0.2  # distance from 1 of the last growth of T
_SAME = 4e-9  # the rest of the run
_PAIR = 1e-3
_ATTRACTED = 2e-9
_ROTATION = 5e-4
_PASSES = 4e-6
_RANGE = 5e-3  # transits
_WANDERS = 1e-2  # transits, on both sides of the unstable orbit's period


class PeriodsOfRun(NamedTuple):
    """A run from the scene's own start: the periods of all its cycles, and of those of its last part (transits); whether they
    settled."""

    log10_r: float
    periods: Array
    last: Array
    settled: bool


class Attractor(NamedTuple):
    """A `run` from a nudge of this `size`, and the period of the branch's stable orbit that is nearest to its last cycle."""

    size: float
    run: PeriodsOfRun
    orbit: float

    @property
    def apart(self) -> float:
        """Relative difference of both; NaN if the run has not settled."""
        return abs(float(self.run.last[-1]) / self.orbit - 1.0) if self.run.settled else float("nan")


class Torus(NamedTuple):
    """A long run that does not settle, its cycles counted from where v passes V upwards: the mean of their periods, the shortest
    and the longest (transits), and the rotation number."""

    mean: Estimate
    shortest: float
    longest: float
    rotation: float


class FoldSide(NamedTuple):
    """An orbit beside a special point, at `log10_r`: its critical multiplier, of the `orbit` and as `seen` in runs."""

    log10_r: float
    orbit: complex
    seen: complex

    @property
    def apart(self) -> float:
        """Relative difference of both multipliers."""
        return abs(self.seen / self.orbit - 1.0)


def run_at(log10_r: float, size: float | None = None) -> PeriodsOfRun:
    """A run of the delay system until its cycles stop changing, or over 9000 transits; from a nudge of this `size`, if given."""
    scene = scene_at(log10_r)
    if size is not None:
        scene = replace(scene, start=replace(scene.start, size=size))
    found = memo.settled("delay", scene, 1e-10, 1e-8, _MOST)
    periods, last = (found.observer.events(share * found.transits).period for share in (0.0, _LAST))
    return PeriodsOfRun(log10_r, periods, last, found.settled)


def attractor(log10_r: float, size: float, orbits: list[Closed]) -> Attractor:
    """The end of a run; `orbits`: those of the branch at this r."""
    run = run_at(log10_r, size)
    stable = [one.cycle.period for one in orbits if count_unstable(one) == 0]
    return Attractor(size, run, min(stable, key=lambda period: abs(period - run.last[-1])))


def torus_at(log10_r: float) -> Torus:
    """The delay system's run at `log10_r`, its transient left out."""
    solver = build("delay", scene_at(log10_r), tolerance=1e-8)
    history = HistoryObserver(solver.scene.law, solver.nodes, _TRANSIENT)
    follow(solver, _TORUS, [history])
    time, rate, *_ = history.samples(per_piece=6)
    periods = np.diff(passages(time, rate, unknown_of(solver.scene.law, solver.scene.velocity)))
    turned = rotation(periods)
    assert turned is not None
    return Torus(mean_of(periods), float(periods.min()), float(periods.max()), turned.number)


def passages(time: Array, values: Array, level: float) -> Array:
    """Times at which `values` pass the `level` upwards, the first of each cycle, by linear interpolation."""
    above = values - level
    k = np.flatnonzero((above[:-1] < 0.0) & (above[1:] >= 0.0))
    dates = time[k] - above[k] * (time[k + 1] - time[k]) / (above[k + 1] - above[k])
    return np.asarray(dates[np.diff(dates, prepend=-np.inf) > _APART])


def multiplier_of(run: PeriodsOfRun, period: float) -> complex:
    """The leading pair of multipliers (its member above the real axis) from a run that settles on the orbit of this `period`:
    the recursion of the deviations of its cycles, fitted where they are small."""
    deviations = run.periods - period
    size = np.maximum(np.abs(deviations[:-1]), np.abs(deviations[1:]))
    far, near = (int(np.nonzero(size > bound)[0][-1]) for bound in reversed(_LINEAR))
    window = deviations[far : near + 1]
    return _pair(window, 1.0 / np.hypot(window[1:-1], window[:-2]))


def multiplier_seen(apart: Array, turns: bool) -> complex:
    """The multiplier m of the distance `apart` (cycles, values) of two runs from cycle to cycle, d_(n+1) = m d_n, or the pair, if
    it `turns`."""
    first, second = apart[:-1].ravel(), apart[1:].ravel()
    return _pair(apart, np.ones_like(apart[2:])) if turns else complex(second @ first / (first @ first))


def _pair(d: Array, weights: Array) -> complex:
    """The pair m of d_(n+2) = 2 Re(m) d_(n+1) - |m|^2 d_n, by weighted least squares."""
    before = np.column_stack([(weights * d[1:-1]).ravel(), (-weights * d[:-2]).ravel()])
    twice, square = np.linalg.lstsq(before, (weights * d[2:]).ravel(), rcond=None)[0]
    return complex(0.5 * twice, np.sqrt(max(square - 0.25 * twice**2, 0.0)))


def sides(branch: Branch, first: int = 0, every: int = 1) -> list[FoldSide]:
    """The points of the delay branch before and beyond its special points, from the `first` special point on with stride
    `every`."""
    number = {id(point): n for n, point in enumerate(branch.points)}
    return [
        _side(branch.points[number[id(special.point)] + beside], special.kind)
        for special in branch.special[first::every]
        for beside in (-1, 1)
    ]


def _side(point: OrbitPoint, kind: str) -> FoldSide:
    closed = point.closed
    passing, direction = _passing(closed, kind)
    apart = _cycles(closed, _OFF * direction) - _cycles(closed, -_OFF * direction)
    return FoldSide(point.parameter, passing, multiplier_seen(apart, abs(passing.imag) > _REAL))


def _passing(closed: Closed, kind: str) -> tuple[complex, Array]:
    """The critical multiplier at a point of `kind`, and the real part of its eigenvector, with 1 as the largest component."""
    values, vectors = np.linalg.eig(closed.monodromy)
    others = np.delete(values, np.abs(values - 1.0).argmin())
    passing = critical(kind, others.astype(complex))
    vector = vectors[:, np.abs(values - passing).argmin()].real
    return passing, vector / np.abs(vector).max()


def _cycles(closed: Closed, change: Array) -> Array:
    """z and psi (cycles, 2 samples) in the cycles of a run that begins on the orbit displaced by a `change` of its state."""
    cycle, period = closed.flow.march(closed.cycle.start + change, closed.cycle.period), closed.cycle.period
    solver = build("delay", closed.flow.scene, tolerance=1e-11)
    solver.restore(state_on(solver, replace(closed, cycle=cycle)))
    history = HistoryObserver(solver.scene.law, solver.nodes)
    times = BEGIN + 1.0 + np.linspace(0.0, period, _SAMPLES, endpoint=False)
    follow(solver, float(times[-1]) + _CYCLES * period, [history])
    return np.array([history.at(times + n * period)[1:3].ravel() for n in range(_CYCLES + 1)])


def fold_pairs(branch: Branch) -> list[tuple[Special, Special]]:
    """Pairs of folds after the first: where the branch turns to smaller r, and where it turns back."""
    folds = branch.of_kind("LP")[1:]
    return list(zip(folds[::2], folds[1::2], strict=False))


def fold_claims(branch: Branch, finer: Branch) -> Iterator[Verdict]:
    """Verdicts: the special points agree with those on a finer mesh with shorter steps; the growth of T from pair to pair of
    folds."""
    title = "Special points depend neither on the mesh nor on the length of steps"
    both = list(zip(branch.special, finer.special, strict=False))
    off = max(abs(one.point.parameter - other.point.parameter) for one, other in both)
    sizes = " and ".join(str(one.point.closed.flow.size) for one in both[-1])
    mesh = f"mesh: largest change of log_{{10}} r of {len(both)} points, states of {sizes} values at the last one"
    yield claim(title, SELF, off, _MESHES, mesh)
    kinds, others = ([one.kind for one in some.special[: len(both)]] for some in (branch, finer))
    last = finer.points[-1].closed.cycle.period
    beyond, found = sum(one.point.closed.cycle.period < last for one in branch.special), len(finer.special)
    up_to = f"steps of half the length: special points up to T = {last:.1f} transits"
    verdict = holding(title, SELF, f"{beyond} points", f"{found} points", kinds == others and beyond == found, up_to)
    yield verdict.with_margin(abs(found - beyond), 1.0)
    growth = np.diff([turn.point.closed.cycle.period for turn, _ in fold_pairs(branch)]).tolist()
    yield claim(
        "Folds come in pairs, and T grows by one transit from pair to pair: each pair lets one more ripple into the cycle",
        ASYMPTOTIC,
        growth[-1],
        _ONE,
        f"T grows by {', '.join(f'{one:.3f}' for one in growth)}; the last is judged",
        near=1.0,
    )


def settles(run: PeriodsOfRun, orbit: Closed) -> Iterator[Verdict]:
    """A run before the torus point against the orbit of the branch, and its approach against the multipliers."""
    title = "Before the first torus point a direct run settles on the branch, as its multipliers say"
    period, at = orbit.cycle.period, minus(f"log_{{10}} r = {run.log10_r:g}")
    lead, seen = complex(floquet(orbit.monodromy)[0][0]), multiplier_of(run, period)
    lead = complex(lead.real, abs(lead.imag))
    ratio = float(run.last[-1]) / period if run.settled else float("nan")
    yield claim(title, WITNESS, ratio, _SAME, f"T of the run over that of the branch, {at}", near=1.0)
    words = [minus(f"{one.real:.5f} ± {one.imag:.5f} i") for one in (seen, lead)]
    remark = f"leading multipliers, {at}: {words[0]} from the periods of a run, {words[1]} from the linearised motion"
    yield claim(title, WITNESS, abs(seen - lead), _PAIR, remark)


def wanders(run: PeriodsOfRun, orbit: Closed) -> Verdict:
    """A run beyond the torus point."""
    low, high = float(run.last.min()), float(run.last.max())
    apart = min(orbit.cycle.period - low, high - orbit.cycle.period)
    return holding(
        "Beyond the first torus point a direct run does not settle, and its periods lie on both sides of the unstable orbit’s",
        WITNESS,
        f"around {orbit.cycle.period:.4f}",
        f"{low:.3f} to {high:.3f}",
        not run.settled and apart > _WANDERS,
        minus(f"log_{{10}} r = {run.log10_r:g}, T in transits; at least {_WANDERS:g} apart"),
    ).with_margin(_WANDERS / apart if apart > 0.0 else math.inf, 1.0)


def grows(beside: Sequence[FoldSide]) -> Verdict:
    """Direct runs on both sides of special points."""
    apart = max(side.apart for side in beside)
    title = "On both sides of special points, direct runs depart or come back by the multiplier that passes there"
    return claim(title, WITNESS, apart, _PASSES, f"largest relative difference, {len(beside)} sides")


def coexisting(attractors: Sequence[Attractor]) -> Iterator[Verdict]:
    """Runs from different nudges at one r."""
    title = "Two stable orbits coexist at one r: the size of the nudge decides on which a run settles"
    for log10_r in dict.fromkeys(one.run.log10_r for one in attractors):
        here = [one for one in attractors if one.run.log10_r == log10_r]
        periods, apart = {round(one.orbit, 6) for one in here}, float(np.max([one.apart for one in here]))
        where = minus(f"log_{{10}} r = {log10_r:g}: nudges of {' and '.join(f'{one.size:g}' for one in here)}")
        yield every(title, WITNESS, len(periods), 2, where, "orbits")
        yield claim(title, WITNESS, apart, _ATTRACTED, f"{where}: relative difference of T from the branch’s")


def on_torus(found: Torus) -> Iterator[Verdict]:
    """A long run beyond the first torus point, against the independent program's."""
    title = "A run on the torus has the rotation number and the periods that another program finds"
    known = reference()["torus"]
    mean, (low, high), number = known["mean_period"], known["period_range"], known["rotation_number"]
    where = minus(f"log_{{10}} r = {known['log10_r']:g}")
    yield claim(title, WITNESS, found.rotation, _ROTATION, f"rotation number, {where}", near=number)
    ends = max(abs(found.shortest - low), abs(found.longest - high)) / _RANGE
    off = max(abs(found.mean.value - mean) / (3.0 * found.mean.error), ends)
    yield holding(
        title,
        WITNESS,
        f"{mean}, {low} to {high}",
        f"{found.mean.value:.4f} ± {found.mean.error:.4f}, {found.shortest:.3f} to {found.longest:.3f}",
        off < 1.0,
        f"mean and range of T: three standard errors are allowed, and {_RANGE:g} transits at the ends",
    ).with_margin(off, 1.0)
