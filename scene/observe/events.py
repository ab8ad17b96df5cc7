"""Streaming detection of slip events and of each cycle's extrema, from the dense polynomials of the pieces.

A slip event starts where v crosses V upwards after a stick. A stick is told from the ripples and rebounds of an event by two
marks: v stayed below V for a whole reverberation (the longer round trip; a ripple has that period, so it cannot), and elastic
stress came back (a rebound regains almost none of what an event releases). Extrema are those of the polynomial, not of the nodes;
a piece is searched only if it might beat the cycle's record.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from scene.compiled import njit
from scene.friction import rate_of, unknown_of
from scene.observe.extrema import evaluate, find_root, raise_record, raise_record_within
from scene.observe.pieces import Array, Basis, Pieces, lagrange_basis
from scene.scene import Scene

_RELOADED = 0.1  # share of a cycle's elastic stress drop that has to come back before another event can start
_NOISE = 1e-9  # relative depth below V that counts as "below": steady sliding at V must not trigger by rounding
# slots of the detector's memory; from _EXTREMA on: max and -min of rate unknown, stress, elastic stress
_BELOW_SINCE, _STARTED, _EVENT_TIME, _LAST_VALUE, _LAST_DROP, _EXTREMA = 0, 1, 2, 3, 4, 5
_MEMORY = _EXTREMA + 6


class Events(NamedTuple):
    """One row per complete cycle (from one slip event to the next), arrays of shape (cycles,): event time and period in transits;
    stress drops in units of the normal stress; v_max, v_min in V*."""

    time: Array
    period: Array
    stress_drop: Array
    elastic_stress_drop: Array
    v_max: Array
    v_min: Array


class EventObserver:
    """Feeds on pieces, keeps one row per cycle and a handful of numbers. `count` is the number of event starts so far."""

    def __init__(self, scene: Scene, nodes: Array) -> None:
        self._law = scene.law
        self._basis = lagrange_basis(nodes)
        self._threshold = unknown_of(scene.law, scene.velocity)
        self._margin = _NOISE * (1.0 + abs(self._threshold))
        self._quiet = max(scene.upper.round_trip, scene.lower.round_trip) / scene.transit
        self._memory = np.zeros(_MEMORY)
        self._memory[_BELOW_SINCE] = np.nan
        self._memory[_LAST_VALUE] = np.nan
        self._rows: list[NDArray[np.float64]] = []
        self.count = 0
        none = np.empty((0, nodes.size))
        self.scan(Pieces(none[:, 0].copy(), none[:, 0].copy(), none, none, none, none))  # loads the detector outside timed runs

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order."""
        rows = np.empty((pieces.time.size + 1, 6))
        starts, cycles = _scan(pieces, self._basis, self._threshold, self._margin, self._quiet, self._memory, rows)
        self.count += starts
        if cycles:
            self._rows.append(rows[:cycles].copy())

    @property
    def events(self) -> Events:
        """All complete cycles so far."""
        table = np.concatenate(self._rows) if self._rows else np.empty((0, 6))
        rates = [np.array([rate_of(self._law, z) for z in table[:, column]], dtype=float) for column in (5, 4)]
        return Events(table[:, 0], table[:, 1], table[:, 2], table[:, 3], rates[0], rates[1])

    @property
    def last_start(self) -> float:
        """Time of the latest event start (transits); NaN before the first."""
        return float(self._memory[_EVENT_TIME]) if self._memory[_STARTED] else math.nan

    def state(self) -> dict[str, Array]:
        """Everything remembered, as arrays, for a checkpoint."""
        table = np.concatenate(self._rows) if self._rows else np.empty((0, 6))
        return {"memory": self._memory.copy(), "cycles": table, "count": np.array([self.count])}

    def restore(self, state: dict[str, Array]) -> None:
        """Go on from what `state` returned."""
        self._memory[:] = state["memory"]
        self._rows = [state["cycles"].copy()] if state["cycles"].size else []
        self.count = int(state["count"][0])


@njit
def _scan(
    pieces: Pieces, basis: Basis, threshold: float, margin: float, quiet: float, memory: Array, rows: Array
) -> tuple[int, int]:
    """Walk over the pieces; fill `rows` with completed cycles; return (event starts, completed cycles)."""
    starts = 0
    cycles = 0
    n = basis.nodes.size
    slopes = np.empty(n)
    for k in range(pieces.time.size):
        z = pieces.unknown[k]
        begin = 0.0  # where the running cycle begins within this piece
        left = 0.0
        left_value = evaluate(basis, z, 0.0) if math.isnan(memory[_LAST_VALUE]) else memory[_LAST_VALUE]
        for j in range(n):
            right = basis.nodes[j]
            right_value = z[j]
            if left_value < threshold <= right_value:
                point = _crossing(basis, z, threshold, left, right)
                at = pieces.time[k] + pieces.length[k] * point
                elastic = evaluate(basis, pieces.elastic[k], (at - pieces.time[k]) / pieces.length[k])
                if at - memory[_BELOW_SINCE] > quiet and _reloaded(memory, elastic):
                    if memory[_STARTED] > 0.0:
                        _raise_within(pieces, k, basis, slopes, memory, begin, point)
                        _close_cycle(memory, at, rows[cycles])
                        cycles += 1
                    memory[_STARTED] = 1.0
                    memory[_EVENT_TIME] = at
                    for slot in range(_EXTREMA, _MEMORY):
                        memory[slot] = -math.inf
                    begin = point
                    starts += 1
                memory[_BELOW_SINCE] = math.nan
            elif right_value < threshold - margin and math.isnan(memory[_BELOW_SINCE]):
                point = _crossing(basis, z, threshold - margin, left, right)
                memory[_BELOW_SINCE] = pieces.time[k] + pieces.length[k] * point
            left, left_value = right, right_value
        memory[_LAST_VALUE] = left_value
        if begin > 0.0:
            _raise_within(pieces, k, basis, slopes, memory, begin, basis.nodes[n - 1])
        elif memory[_STARTED] > 0.0:
            _raise_records(pieces, k, basis, slopes, memory)
    return starts, cycles


@njit
def _crossing(basis: Basis, z: Array, level: float, left: float, right: float) -> Any:
    """Point of [left, right] where the rate passes `level`, up or down; the piece's left end if it did so between two pieces.

    A root, not a node: a stick is measured against a round trip, and must not be shorter for longer pieces.
    """
    if left == 0.0 and (evaluate(basis, z, 0.0) >= level) == (evaluate(basis, z, right) >= level):
        return 0.0
    return find_root(basis, z, level, left, right)


@njit
def _reloaded(memory: Array, elastic: float) -> bool:
    """Whether the slabs have won back a share of the elastic stress drop of this cycle and of the one before.

    The cycle before counts because a precursor may end before this cycle's own event has released anything; its weight halves
    with every crossing refused, so that a motion that calms down for good is seen again. True before the first event.
    """
    if memory[_STARTED] == 0.0:
        return True
    highest, lowest = memory[_EXTREMA + 4], -memory[_EXTREMA + 5]
    if elastic - lowest > _RELOADED * max(highest - lowest, memory[_LAST_DROP]):
        return True
    memory[_LAST_DROP] *= 0.5
    return False


@njit
def _close_cycle(memory: Array, at: float, row: Array) -> None:
    """Row of the cycle that ends at `at`: start, period, drops, extreme rate unknowns (min, max)."""
    row[0] = memory[_EVENT_TIME]
    row[1] = at - memory[_EVENT_TIME]
    row[2] = memory[_EXTREMA + 2] + memory[_EXTREMA + 3]
    row[3] = memory[_EXTREMA + 4] + memory[_EXTREMA + 5]
    memory[_LAST_DROP] = row[3]
    row[4] = -memory[_EXTREMA + 1]
    row[5] = memory[_EXTREMA]


@njit
def _raise_records(pieces: Pieces, k: int, basis: Basis, slopes: Array, memory: Array) -> None:
    """Update the cycle's max and -min of rate unknown, stress and elastic stress by piece k."""
    raise_record(basis, pieces.unknown[k], slopes, memory, _EXTREMA)
    raise_record(basis, pieces.stress[k], slopes, memory, _EXTREMA + 2)
    raise_record(basis, pieces.elastic[k], slopes, memory, _EXTREMA + 4)


@njit
def _raise_within(pieces: Pieces, k: int, basis: Basis, slopes: Array, memory: Array, begin: float, end: float) -> None:
    """As `_raise_records`, by the part [begin, end] of piece k: an event's piece belongs to two cycles."""
    raise_record_within(basis, pieces.unknown[k], slopes, memory, _EXTREMA, begin, end)
    raise_record_within(basis, pieces.stress[k], slopes, memory, _EXTREMA + 2, begin, end)
    raise_record_within(basis, pieces.elastic[k], slopes, memory, _EXTREMA + 4, begin, end)
