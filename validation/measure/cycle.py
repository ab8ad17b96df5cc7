"""The interface's motion over the last complete cycle of a run, kept while the run streams by."""

from typing import NamedTuple

import numpy as np

from slipwave.friction import rate_of
from slipwave.observe import EventObserver, Pieces, Solver, follow
from slipwave.observe.pieces import Array

_FIRST_MOST = 16  # chunks of pieces that are kept without asking whether they are still needed


class Cycle(NamedTuple):
    """Time since the slip event's date (transits), slip rate (V*), stress mu, all of shape (samples,); and the period."""

    time: Array
    slip_rate: Array
    stress: Array
    period: float


def watch(solver: Solver, until: float) -> EventObserver:
    """March `solver` to `until` (transits); the observer holds the slip events on the way. Raises NumericsError as `follow`."""
    observer = EventObserver(solver.scene, solver.nodes)
    follow(solver, until, [observer])
    return observer


class CycleObserver:
    """Keeps the pieces of the cycle that was completed last and of the one now running: memory O(cycle).

    Hand it to `follow`; it detects events itself, with the detector that every run uses.
    """

    def __init__(self, solver: Solver) -> None:
        self._law = solver.scene.law
        self._nodes = np.asarray(solver.nodes)
        self._watch = EventObserver(solver.scene, solver.nodes)
        self._kept: list[Pieces] = []
        self._most = _FIRST_MOST

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order."""
        self._watch.scan(pieces)
        self._kept.append(pieces)
        if len(self._kept) > self._most:
            self._forget()

    def _forget(self) -> None:
        """Drop what lies before the last complete cycle; the latest event may not be over, so that is the third last date."""
        dates = self._watch.dates()
        if dates.size >= 3:
            self._kept = [part for part in self._kept if part.time[-1] + part.length[-1] >= dates[-3]]
        self._most = 2 * len(self._kept) + _FIRST_MOST

    def cycle(self, after: float) -> Cycle | None:
        """The last complete cycle of the window from `after` (transits) to now, or None if there was none."""
        events = self._watch.events(after)
        if not events.time.size:
            return None
        begin, period = float(events.time[-1]), float(events.period[-1])
        times = np.concatenate([part.time[:, None] + part.length[:, None] * self._nodes for part in self._kept]).ravel() - begin
        keep = (times >= 0.0) & (times <= period)
        unknown = np.concatenate([part.z for part in self._kept]).ravel()[keep]
        stress = np.concatenate([part.mu for part in self._kept]).ravel()[keep]
        rate = np.array([rate_of(self._law, z) for z in unknown], dtype=float)
        return Cycle(times[keep], rate, stress, period)
