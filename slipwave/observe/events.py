"""Slip events and cycles of a run, found during the run from the polynomials of the pieces.

A slip event is a fall of the elastic stress y whose prominence is at least 10 % of that of the largest fall in the judged window.
Prominence is defined by persistence (`detector`): a fall continues through rises smaller than those 10 % and ends at the first
larger one. Its date is when v, rising to its maximum in the fall, passes half of that.

In a slip event the interface slips as far as friction needs to weaken. Friction feeds no oscillation of passive slabs above
omega_c (`FrictionSlopes.growing`). A fall at omega_c lasts half a period, in which the interface slips by pi V/omega_c. A fall in
which it slips by less than a quarter of this is a wave, which friction only damps, and no event, even if the window has no larger
fall.

Falls below a floor are no events, because rounding and the tolerance of a solver are not motion. The floor is the friction stress
that changes the rate by 1e-9 of itself (at the steady sliding of the start), plus 1e-13 of the steady stress, some 500 roundings.

The observer keeps every swing that may still count in some window that lasts to the end of the run, with the extrema of the rate
and of the friction stress in it: memory O(events).
"""

import math
from typing import NamedTuple

import numpy as np

from slipwave.friction import rate_of, rates
from slipwave.friction.law import friction_slopes
from slipwave.observe.detector import (
    BEGIN,
    COLUMNS,
    COUNT,
    DATE,
    END,
    ENDED,
    KEPT,
    LAST,
    MOST_KEPT,
    RECORDS,
    RISING,
    JudgedSwings,
    judge_swings,
    new_detector,
    rise_buffer,
    scan,
)
from slipwave.observe.pieces import Array, Pieces, empty_pieces, lagrange_basis
from slipwave.scene import Scene

_QUIET_RATE, _QUIET_STRESS = 1e-9, 1e-13  # relative; what the floor is made of
_SLIPS = 0.25  # of the slip in half a period at the onset: of 120 random scenes events have 0.6 to 10, waves 0.001 to 0.05
_RING = 8  # waves
_FIRST_SIZE = 256


class Events(NamedTuple):
    """Complete cycles, each from one slip event to the next; arrays of shape (cycles,): the event's date and the time to the next
    one (transits); stress drops in units of the normal stress; v_max, v_min in V*.

    Extrema are those between the maximum of the elastic stress before the event and the one before the next event. A cycle is
    complete if the run includes the beginning of its first fall and the end of the fall of the next event."""

    time: Array
    period: Array
    stress_drop: Array
    elastic_stress_drop: Array
    v_max: Array
    v_min: Array


NO_EVENTS = Events(*np.empty((6, 0)))
"""None at all."""


class EventObserver:
    """Observer that finds the events of any window that lasts to the latest piece."""

    whole_from = math.inf

    def __init__(self, scene: Scene, nodes: Array) -> None:
        by_rate = abs(scene.steady_response[3])
        floor = _QUIET_RATE * by_rate + _QUIET_STRESS * abs(scene.steady_stress)
        self._detector = new_detector(scene.law, lagrange_basis(nodes), floor, _FIRST_SIZE + nodes.size)
        slopes = friction_slopes(scene.law, scene.velocity)
        slip = (
            _SLIPS * math.pi * scene.velocity / slopes.omega_c / scene.transit if slopes.weakening else 0.0
        )  # V* times transits
        self._loading, self._least = scene.stiffness * max(scene.drive.velocities), scene.stiffness * slip
        self._drifts = any(slab.termination.has_dead_load for slab in scene.slabs)
        self._judged: dict[float, JudgedSwings] = {}
        self.scan(empty_pieces(0, nodes.size))  # loads the detector outside timed runs

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order."""
        used, kept, more = int(self._detector.memory[KEPT]), self._detector.kept, pieces.time.size
        if used + more > len(kept) and len(kept) < MOST_KEPT:  # a rise may last through all of the pieces
            self._detector = self._detector._replace(kept=rise_buffer(self._detector.basis.nodes.size, kept[:used], more))
        self._judged.clear()
        done = scan(pieces, 0, self._detector)
        while done < pieces.time.size:
            swings = self._detector.swings
            self._detector = self._detector._replace(swings=np.concatenate((swings, np.empty_like(swings))))
            done = scan(pieces, done, self._detector)

    def dates(self, after: float = -np.inf) -> Array:
        """Dates (transits) of the slip events from `after` on, in the window from there to now; shape (events,)."""
        judged = self.judge(after)
        return np.asarray(judged.swings[judged.events, DATE])

    @property
    def count(self) -> int:
        """Number of slip events of the run so far."""
        return self.dates().size

    def judge(self, after: float = -np.inf) -> JudgedSwings:
        """The falls that are slip events of the window from `after` (transits) to now, with their prominence; computed once until
        the next pieces."""
        if after not in self._judged:
            detector = self._detector
            if detector.memory[RISING] > 0.0:
                scan(empty_pieces(0, detector.basis.nodes.size), 0, detector)
            running = np.empty((0, COLUMNS)) if math.isnan(detector.memory[LAST]) else detector.memory[None, :COLUMNS]
            swings = np.concatenate((detector.swings[: int(detector.memory[COUNT])], running))
            self._judged[after] = judge_swings(swings, detector.floor, after, self._loading, self._least, self._drifts)
        return self._judged[after]

    def ringing(self, velocity: float, after: float) -> float:
        """The largest |v/V - 1|, V = `velocity`, in the window from `after` (transits) to now, if waves ring there without an
        event; else infinite."""
        judged = self.judge(after)
        late = judged.swings[judged.swings[:, ENDED] > after]
        if judged.events.size or judged.waves < _RING:
            return math.inf
        ends = float(late[:, RECORDS].max()), -float(late[:, RECORDS + 1].max())
        return max(abs(rate_of(self._detector.law, z) / velocity - 1.0) for z in ends)

    def events(self, after: float = -np.inf) -> Events:
        """Complete cycles that begin at or after `after` (transits), in the window from there to now."""
        judged = self.judge(after)
        events = judged.events[1:] if judged.events.size and judged.events[0] == 0 else judged.events
        events = events if judged.over else events[:-1]
        if events.size < 2:
            return NO_EVENTS
        dates, begins = judged.swings[events, DATE], events[:-1]
        inner = judged.swings[: events[-1]]
        highest = np.maximum.reduceat(inner[:, [BEGIN, END]].max(axis=1), begins)
        lowest = np.minimum.reduceat(inner[:, [BEGIN, END]].min(axis=1), begins)
        records = np.maximum.reduceat(inner[:, RECORDS:], begins, axis=0)
        v_max, v_min = (rates(self._detector.law, column) for column in (records[:, 0], -records[:, 1]))
        return Events(dates[:-1], np.diff(dates), records[:, 2] + records[:, 3], highest - lowest, v_max, v_min)

    def state(self) -> dict[str, Array]:
        """All that is remembered, as arrays, for a checkpoint."""
        detector, memory = self._detector, self._detector.memory
        kept, swings = detector.kept[: int(memory[KEPT])].copy(), detector.swings[: int(memory[COUNT])].copy()
        return {"memory": memory[:COUNT].copy(), "rise": kept, "swings": swings}

    def restore(self, state: dict[str, Array]) -> None:
        """Continue from what `state` returned."""
        detector, swings = self._detector, state["swings"]
        self._judged.clear()
        n = detector.basis.nodes.size
        detector.memory[:] = *state["memory"], len(swings)
        swings = np.concatenate((swings, np.empty((_FIRST_SIZE + n, COLUMNS))))
        self._detector = detector._replace(kept=rise_buffer(n, state["rise"]), swings=swings)
