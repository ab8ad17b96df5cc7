"""Direct runs of the delay system beside its branch: where they end, and the multiplier with which they settle."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable
from slipwave.friction import unknown_of
from slipwave.observe import HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate
from slipwave.observe.torus import rotation
from slipwave.solve import follow
from validation.measure.correlated import mean_of
from validation.measure.settle import settle
from validation.registry.build import build
from validation.study.over_r import scene_at

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
