"""One cycle of the interface's motion: of a settled orbit, or the last complete one of a run."""

from copy import deepcopy
from typing import NamedTuple

import numpy as np

from slipwave.friction import Law
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.history import named_columns
from slipwave.observe.pieces import Array, Pieces
from slipwave.solve import Observer, Solver, follow
from validation.models.settle import Settled

SYMBOLS = {"period": "T", "stress_drop": "Δμ", "elastic_stress_drop": "Δy", "v_max": "v_{max}", "v_min": "v_{min}"}
"""The figures of an orbit, and their symbols."""

_RIPPLES = (25.0, 55.0)  # transits after the event's date in which the interface creeps and the stress ripples
_FIRST_MOST = 16  # chunks of pieces that are kept before the first check whether they are still needed


class OneCycle(NamedTuple):
    """A cycle's curves, arrays of equal length: time (transits) from the slip event's date, slip rate (V*), psi, mu, y; and its
    period."""

    time: Array
    slip_rate: Array
    psi: Array
    stress: Array
    elastic_stress: Array
    period: float


def cut(law: Law, samples: Array, date: float, period: float, before: float = 0.0, after: float = 0.0) -> OneCycle:
    """The part of `samples` (see `HistoryObserver`) that is the cycle of the event at `date`, with `before` transits ahead of it
    and `after` transits past its end."""
    inside = (samples[0] >= date - before) & (samples[0] <= date + period + after)
    columns = named_columns(law, samples[:, inside])
    return OneCycle(**columns | {"time": columns["time"] - date}, period=period)


def watch(solver: Solver, until: float, *others: Observer) -> EventObserver:
    """March `solver` to `until` (transits), observed by `others` too; returns the observer of the slip events. Raises
    NumericsError as `follow`."""
    observer = EventObserver(solver.scene, solver.nodes)
    follow(solver, until, [observer, *others])
    return observer


class CycleObserver:
    """Observer that keeps the last complete cycle and the present one: memory O(cycle). It detects events itself, by the detector
    of every run.
    """

    def __init__(self, solver: Solver) -> None:
        self._law = solver.scene.law
        self._watch = EventObserver(solver.scene, solver.nodes)
        self._history = HistoryObserver(solver.scene.law, solver.nodes)
        self._most = _FIRST_MOST

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order."""
        self._watch.scan(pieces)
        self._history.scan(pieces)
        if len(self._history) > self._most:
            dates = self._watch.dates()
            if dates.size >= 3:
                self._history.forget(float(dates[-3]))  # the latest event may not be over
            self._most = 2 * len(self._history) + _FIRST_MOST

    def cycle(self, after: float) -> OneCycle | None:
        """The last complete cycle of the window from `after` (transits) to now, or None if there was none."""
        events = self._watch.events(after)
        if not events.time.size:
            return None
        return cut(self._law, self._history.samples(), float(events.time[-1]), float(events.period[-1]))


def ripple_period(cycle: OneCycle) -> float:
    """Mean time (transits) between maxima of mu within _RIPPLES, located by parabolas through three samples.

    Raises ValueError if there are fewer than three maxima.
    """
    inside = (cycle.time >= _RIPPLES[0]) & (cycle.time <= _RIPPLES[1])
    time, stress = cycle.time[inside], cycle.stress[inside]
    ripple = stress - np.polynomial.Polynomial.fit(time, stress, 3)(time)
    peak = np.flatnonzero((ripple[1:-1] > ripple[:-2]) & (ripple[1:-1] >= ripple[2:]) & (ripple[1:-1] > 0.3 * ripple.max())) + 1
    if peak.size < 3:
        raise ValueError(f"{peak.size} ripples between {_RIPPLES[0]} and {_RIPPLES[1]} transits")
    maxima = np.array([_vertex(time[k - 1 : k + 2], ripple[k - 1 : k + 2]) for k in peak])
    return float((maxima[-1] - maxima[0]) / (maxima.size - 1))


def _vertex(x: np.ndarray, y: np.ndarray) -> float:
    """Abscissa of the vertex of the parabola through three points."""
    slope, bend = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    curvature = (bend - slope) / (x[2] - x[0])
    return float(0.5 * (x[0] + x[1]) - 0.5 * slope / curvature)


def one_cycle(settled: Settled, before: float = 0.0, after: float = 0.0, per_piece: int = 8) -> OneCycle:
    """A cycle of the next two periods, from `before` transits ahead of its event to `after` transits past its end. The solver's
    state is restored."""
    solver, observer, period = settled.solver, deepcopy(settled.observer), settled.orbit.period.value
    begin, here = solver.time, solver.state()
    history = HistoryObserver(solver.scene.law, solver.nodes)
    follow(solver, begin + 2.02 * period + before + after, [history, observer])
    solver.restore(here)
    dates = observer.dates()
    date = float(dates[dates >= begin + before][0])
    return cut(solver.scene.law, history.samples(per_piece), date, period, before, after)
