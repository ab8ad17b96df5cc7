"""DOC"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from reduced.continuation.point import Point
from reduced.continuation.special import Special, critical
from reduced.flows.delay import DelayFlow
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable, floquet
from reduced.parameters import with_parameter
from slipwave.friction import rates, unknown_of
from slipwave.observe import HistoryObserver
from slipwave.observe.pieces import Array, lagrange_basis, values_at
from slipwave.observe.statistics import Estimate
from slipwave.observe.torus import rotation
from slipwave.solve import follow
from validation.measure.correlated import mean_of
from validation.measure.settle import settle
from validation.references.published import reference
from validation.registry.build import build
from validation.registry.orbit_start import BEGIN, state_on
from validation.study import Evidence, Verdict, judge
from validation.study.bounds import bounded
from validation.study.over_r import Branch, scene_at

_MOST = 9000.0
_LAST = 0.7  # share of a run after which its cycles are judged
_TRANSIENT, _TORUS = 6000.0, 16000.0
_APART = 40.0  # transits between two slip events, at least
_LINEAR = (1e-5, 1e-3)  # deviations of T (transits) between which a multiplier is fitted


class Run(NamedTuple):
    """A run from the scene's own start: the periods of all its cycles, and of those of its last part (transits); whether they
    settled."""

    log10_r: float
    periods: Array
    last: Array
    settled: bool


def run_at(log10_r: float, size: float | None = None) -> Run:
    """A run of the delay system until its cycles stop changing, or over 9000 transits; from a nudge of this `size`, if given."""
    scene = scene_at(log10_r)
    if size is not None:
        scene = replace(scene, start=replace(scene.start, size=size))
    found = settle(build("delay", scene, tolerance=1e-10), tolerance=1e-8, most=_MOST)
    periods, last = (found.observer.events(share * found.transits).period for share in (0.0, _LAST))
    return Run(log10_r, periods, last, found.settled)


def multiplier_of(run: Run, period: float) -> complex:
    """The leading pair of multipliers (its member above the real axis) from a run that settles on the orbit of this `period`:
    deviations d_n of its cycles obey d_(n+1) = 2 Re(m) d_n - |m|^2 d_(n-1), which is fitted where they are small."""
    deviations = run.periods - period
    size = np.maximum(np.abs(deviations[:-1]), np.abs(deviations[1:]))
    far, near = (int(np.nonzero(size > bound)[0][-1]) for bound in reversed(_LINEAR))
    window = deviations[far : near + 1]
    weights = 1.0 / np.hypot(window[1:-1], window[:-2])
    before = np.column_stack([window[1:-1], -window[:-2]])
    twice, square = np.linalg.lstsq(weights[:, None] * before, weights * window[2:], rcond=None)[0]
    return complex(0.5 * twice, np.sqrt(square - 0.25 * twice**2))


class Attractor(NamedTuple):
    """A `run` from a nudge of this `size`, and the period of the branch's stable orbit that is nearest to its last cycle."""

    size: float
    run: Run
    orbit: float

    @property
    def apart(self) -> float:
        """Relative difference of both; NaN if the run has not settled."""
        return abs(float(self.run.last[-1]) / self.orbit - 1.0) if self.run.settled else float("nan")


def attractor(log10_r: float, size: float, orbits: list[Closed]) -> Attractor:
    """Where the run ends; `orbits` are those of the branch at this r."""
    run = run_at(log10_r, size)
    stable = [one.cycle.period for one in orbits if count_unstable(one) == 0]
    return Attractor(size, run, min(stable, key=lambda period: abs(period - run.last[-1])))


class Torus(NamedTuple):
    """A long run that does not settle, its cycles counted from where v passes V upwards: the mean of their periods, the shortest
    and the longest (transits), and the rotation number."""

    mean: Estimate
    shortest: float
    longest: float
    rotation: float


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
    """When `values` pass the `level` upwards, the first passage of each cycle; by straight lines."""
    above = values - level
    k = np.flatnonzero((above[:-1] < 0.0) & (above[1:] >= 0.0))
    dates = time[k] - above[k] * (time[k + 1] - time[k]) / (above[k + 1] - above[k])
    return np.asarray(dates[np.diff(dates, prepend=-np.inf) > _APART])


_CYCLES = 4
_OFF = 1e-6  # largest component of the state by which a run is off its orbit
_SAMPLES = 300  # of a cycle
_REAL = 1e-9  # imaginary part below which a multiplier is real


class Side(NamedTuple):
    """An orbit beside a special point, at `log10_r`: the multiplier that passes there, of the `orbit` and as `seen` in runs."""

    log10_r: float
    orbit: complex
    seen: complex

    @property
    def apart(self) -> float:
        """Relative difference of both multipliers."""
        return abs(self.seen / self.orbit - 1.0)


def sides(branch: Branch, first: int = 0, every: int = 1) -> list[tuple[Special, Side, Side]]:
    """Special points of the delay branch, every so many from the `first` on, each with its two sides: the next points."""
    places = {id(point): n for n, point in enumerate(branch.points)}
    found = []
    for special in branch.special[first::every]:
        place = places[id(special.point)]
        before, beyond = (_side(branch.points[n], special.kind) for n in (place - 1, place + 1))
        found.append((special, before, beyond))
    return found


def _side(point: Point, kind: str) -> Side:
    closed = point.closed
    passing, direction = _passing(closed, kind)
    apart = _cycles(closed, _OFF * direction) - _cycles(closed, -_OFF * direction)
    return Side(point.parameter, passing, multiplier_seen(apart, abs(passing.imag) > _REAL))


def _passing(closed: Closed, kind: str) -> tuple[complex, Array]:
    """The multiplier that passes at a point of `kind`, and the real part of its eigenvector, with 1 as the largest component."""
    values, vectors = np.linalg.eig(closed.monodromy)
    others = np.delete(values, np.abs(values - 1.0).argmin())
    passing = critical(kind, others.astype(complex))
    vector = vectors[:, np.abs(values - passing).argmin()].real
    return passing, vector / np.abs(vector).max()


def _cycles(closed: Closed, change: Array) -> Array:
    """z and psi (cycles, 2 samples) in the cycles of a run that begins on the orbit, but for a `change` of its state."""
    cycle, period = closed.flow.march(closed.cycle.start + change, closed.cycle.period), closed.cycle.period
    solver = build("delay", closed.flow.scene, tolerance=1e-11)
    solver.restore(state_on(solver, replace(closed, cycle=cycle)))
    history = HistoryObserver(solver.scene.law, solver.nodes)
    times = BEGIN + 1.0 + np.linspace(0.0, period, _SAMPLES, endpoint=False)
    follow(solver, float(times[-1]) + _CYCLES * period, [history])
    return np.array([history.at(times + n * period)[1:3].ravel() for n in range(_CYCLES + 1)])


def multiplier_seen(apart: Array, turns: bool) -> complex:
    """The multiplier m with which the distance `apart` (cycles, values) of two runs changes from cycle to cycle: d_(n+1) = m d_n,
    or for a pair, if it `turns`, d_(n+2) = 2 Re(m) d_(n+1) - |m|^2 d_n."""
    first, second = apart[:-1].ravel(), apart[1:].ravel()
    if not turns:
        return complex(second @ first / (first @ first))
    before = np.column_stack([apart[1:-1].ravel(), -apart[:-2].ravel()])
    twice, square = np.linalg.lstsq(before, apart[2:].ravel(), rcond=None)[0]
    return complex(0.5 * twice, np.sqrt(max(square - 0.25 * twice**2, 0.0)))


def in_thicker_slabs(closed: Closed, turns: int, period: float) -> float:
    """Largest difference of psi from that of the delay system's orbit `closed`, after its motion was put into alike slabs
    1 + `turns` * `period` times as thick and marched over a period there."""
    flow, ratio = closed.flow, 1.0 + turns * period
    assert isinstance(flow, DelayFlow)
    other = DelayFlow(with_parameter(flow.scene, "r", flow.scene.transit * ratio), ratio / flow.length)
    ages = ((np.arange(other.kept)[:, None] - other.kept + other.nodes) * other.length).ravel()
    outward, inward = (_left(closed, (ages - earlier) * ratio) for earlier in (0.0, 0.5))  # half a transit ago it went outwards
    start = np.r_[outward, inward, closed.cycle.start[-1]]
    pieces = other.march(start, period / ratio).pieces
    times = (pieces.time[:-1, None] + pieces.length[:-1, None] * other.nodes) * ratio
    return float(np.abs(pieces.psi[:-1] - _motion(closed, times.ravel())[1].reshape(times.shape)).max())


def _left(closed: Closed, times: Array) -> Array:
    """The wave that leaves the interface, mu - S - eps/2 (v - V), at any times (transits of the orbit)."""
    scene = closed.flow.scene
    z, _, mu, _ = _motion(closed, times)
    return np.asarray(mu - scene.steady_stress - 0.5 * scene.upper.epsilon * (rates(scene.law, z) - scene.velocity))


def _motion(closed: Closed, times: Array) -> list[Array]:
    return values_at(closed.cycle.pieces, lagrange_basis(closed.flow.nodes), np.mod(times, closed.cycle.period))


_MESHES = 1e-8  # 5e-10 was measured
_ONE = 0.2  # distance from 1 of the last growth of T: 0.03 was measured on the quick branch, 0.008 on the full one
_SAME = 4e-9  # 1.5e-10 was measured, the rest of the run
_PAIR = 1e-3  # 1e-4 was measured
_ATTRACTED = 2e-9  # 9e-11 was measured
_REAPPEARS = 1e-10  # 6e-12 was measured
_ROTATION = 5e-4  # 6e-5 was measured
_PASSES = 1e-4  # 7e-6 was measured
_RANGE = 5e-3  # transits; 9e-4 was measured


def meshes(branch: Branch, finer: Branch) -> tuple[Verdict, Verdict]:
    """The special points of the branch that a finer mesh and shorter steps find."""
    both = list(zip(branch.special, finer.special, strict=False))
    off = max(abs(one.point.parameter - other.point.parameter) for one, other in both)
    sizes = " and ".join(str(one.point.closed.flow.size) for one in both[-1])
    kinds = [[one.kind for one in some.special[: len(both)]] for some in (branch, finer)]
    beyond = sum(one.point.closed.cycle.period < finer.points[-1].closed.cycle.period for one in branch.special)
    return (
        bounded(
            "Special points do not depend on the mesh",
            Evidence.SELF,
            off,
            _MESHES,
            f"largest change of log_{{10}} r of {len(both)} points, states of {sizes} values at the last one",
        ),
        Verdict(
            "Steps of half the length find no other special points",
            Evidence.SELF,
            f"{beyond} points",
            f"{len(finer.special)} points",
            judge(kinds[0] == kinds[1] and beyond == len(finer.special)),
            f"up to T = {finer.points[-1].closed.cycle.period:.1f} transits",
        ),
    )


def fold_pairs(branch: Branch) -> list[tuple[Special, Special]]:
    """Folds after the first, two by two: where the branch turns to smaller r, and where it turns back."""
    folds = branch.of_kind("LP")[1:]
    return list(zip(folds[::2], folds[1::2], strict=False))


def once_per_transit(branch: Branch) -> Verdict:
    """The growth of T from one pair of folds to the next."""
    periods = np.array([turn.point.closed.cycle.period for turn, _ in fold_pairs(branch)])
    growth = np.diff(periods)
    return bounded(
        "Folds come in pairs, and T grows by one transit from pair to pair: each pair lets one more ripple into the cycle",
        Evidence.ASYMPTOTIC,
        abs(float(growth[-1]) - 1.0),
        _ONE,
        "distance of the last growth of T from 1",
        f"T grows by {', '.join(f'{one:.3f}' for one in growth)}",
    )


def settles(run: Run, orbit: Closed) -> tuple[Verdict, Verdict]:
    """A run before the torus point against the orbit of the branch, and its approach against the multipliers."""
    period = orbit.cycle.period
    lead, seen = complex(floquet(orbit.monodromy)[0][0]), multiplier_of(run, period)
    lead = complex(lead.real, abs(lead.imag))
    at = f"log_{{10}} r = {run.log10_r:g}".replace("-", "−")
    return (
        bounded(
            "Before the first torus point a direct run settles on the branch",
            Evidence.WITNESS,
            abs(float(run.last[-1]) / period - 1.0) if run.settled else float("nan"),
            _SAME,
            f"relative difference of T, {at}",
        ),
        bounded(
            "A run settles as fast, and with the rotation, that the multipliers say",
            Evidence.WITNESS,
            abs(seen - lead),
            _PAIR,
            f"{at}: {_told(seen)} from the periods of a run, {_told(lead)} from the orbit’s linearised motion",
        ),
    )


def wanders(run: Run, orbit: Closed) -> Verdict:
    """A run beyond the torus point."""
    low, high = float(run.last.min()), float(run.last.max())
    return Verdict(
        "Beyond the first torus point a direct run does not settle, and its periods lie on both sides of the unstable orbit’s",
        Evidence.WITNESS,
        f"around {orbit.cycle.period:.4f}",
        f"{low:.3f} to {high:.3f}",
        judge(not run.settled and low < orbit.cycle.period < high and high - low > 1e-3),
        f"log_{{10}} r = {run.log10_r:g}, T in transits".replace("-", "−"),
    )


def grows(both: Iterable[tuple[Special, Side, Side]]) -> tuple[Verdict, Verdict]:
    """Direct runs on both sides of special points."""
    listed = list(both)
    apart = max(side.apart for _, *sides in listed for side in sides)
    counted = sum(
        (abs(beyond.seen) > 1.0 > abs(before.seen))
        if one.unstable_after > one.unstable_before
        else abs(beyond.seen) < 1.0 < abs(before.seen)
        for one, before, beyond in listed
    )
    return (
        bounded(
            "On both sides of special points, direct runs depart or come back by the multiplier that passes there",
            Evidence.WITNESS,
            apart,
            _PASSES,
            f"largest relative difference, {2 * len(listed)} sides",
        ),
        Verdict(
            "Runs begin to depart where the count of unstable multipliers grows, and to come back where it falls",
            Evidence.WITNESS,
            f"{len(listed)} points",
            f"{counted} points",
            judge(counted == len(listed)),
            "signs of ln |m| before and beyond, as runs show it",
        ),
    )


def coexisting(attractors: Iterable[Attractor]) -> tuple[Verdict, Verdict]:
    """Runs from different nudges at one r."""
    listed = list(attractors)
    ends = {log10_r: {round(one.orbit, 6) for one in listed if one.run.log10_r == log10_r} for log10_r in _places(listed)}
    return (
        bounded(
            "Runs from a small and from a large nudge settle on orbits of the branch",
            Evidence.WITNESS,
            float(np.max([one.apart for one in listed])),
            _ATTRACTED,
            f"relative difference of T, {len(listed)} runs at {len(ends)} r",
        ),
        Verdict(
            "Two stable orbits coexist at one r, and each attracts runs",
            Evidence.WITNESS,
            "two at each r",
            ", ".join(f"{len(found)} at {log10_r:g}".replace("-", "−") for log10_r, found in ends.items()),
            judge(all(len(found) == 2 for found in ends.values())),
            "the size of the nudge decides which",
        ),
    )


def _places(attractors: list[Attractor]) -> list[float]:
    return list(dict.fromkeys(one.run.log10_r for one in attractors))


def reappears(residuals: Mapping[int, float]) -> Verdict:
    """An orbit put into thicker slabs."""
    return bounded(
        "An orbit of T transits at r is an orbit at r (1 + k T) too",
        Evidence.EXACT,
        max(residuals.values()),
        _REAPPEARS,
        f"largest difference of ψ over a period, k = {', '.join(map(str, residuals))}, the orbit at log_{{10}} r = −2.68",
    )


def on_torus(found: Torus) -> tuple[Verdict, Verdict]:
    """A long run beyond the first torus point, against the independent program's."""
    known = reference()["torus"]
    ends = max(abs(found.shortest - known["period_range"][0]), abs(found.longest - known["period_range"][1]))
    off = abs(found.mean.value - known["mean_period"])
    where = f"log_{{10}} r = {known['log10_r']:g}".replace("-", "−")
    return (
        bounded(
            "A run on the torus has the rotation number that another program finds",
            Evidence.WITNESS,
            abs(found.rotation - known["rotation_number"]),
            _ROTATION,
            where,
            f"{found.rotation:.5f}, known {known['rotation_number']}",
        ),
        Verdict(
            "Its periods have the mean and the range that another program finds",
            Evidence.WITNESS,
            f"{known['mean_period']}, {known['period_range'][0]} to {known['period_range'][1]}",
            f"{found.mean.value:.4f} ± {found.mean.error:.4f}, {found.shortest:.3f} to {found.longest:.3f}",
            judge(off < 3.0 * found.mean.error and ends < _RANGE),
            f"transits, {where}; three standard errors are allowed, and {_RANGE:g} at the ends",
        ),
    )


def _told(value: complex) -> str:
    return f"{value.real:.5f} ± {value.imag:.5f} i".replace("-", "−")
