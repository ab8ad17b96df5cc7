"""The compiled loop over the pieces: swings of the elastic stress, each with its extrema and its date.

Turning points are roots of y' within the polynomial of a piece. Between two pieces the slope may also change sign without a root.
"""

import math
from typing import NamedTuple

import numpy as np

from slipwave.compiled import inlined, njit
from slipwave.friction.law import Law
from slipwave.observe.extrema import bounds, differentiate, evaluate, find_root, overshoot, raise_record, raise_record_within
from slipwave.observe.pieces import Array, Basis, Pieces
from slipwave.observe.rise import RISING, SLOTS, begin_rise, date_rise, follow_rise, room_for_rise
from slipwave.observe.swings import BEGIN, COLUMNS, DATE, DIRECTION, END, RECORDS, thin

_FLAT = 1e-14  # relative; a smaller change of y within a piece is rounding


class DetectorMemory(NamedTuple):
    """The running swing; the memory of `rise` and the pieces that it keeps; y at the end of the latest piece (shape (1,), NaN
    before the first piece); `scratch` (2, nodes)."""

    running: Array
    rise: Array
    kept: Array
    last: Array
    scratch: Array


def empty_memory(nodes: int) -> DetectorMemory:
    """Memory before the first piece, for pieces with `nodes` nodes each."""
    return DetectorMemory(np.zeros(COLUMNS), np.zeros(SLOTS), room_for_rise(nodes), np.full(1, np.nan), np.empty((2, nodes)))


@njit
def scan(
    law: Law, pieces: Pieces, first: int, basis: Basis, floor: float, memory: DetectorMemory, swings: Array, count: int
) -> tuple[int, int]:
    """Read the pieces from number `first` on and append completed swings; returns (next piece, number of swings). It stops early
    if `swings` has no room for all swings that one more piece may complete."""
    n, scratch = basis.nodes.size, memory.scratch
    y, z, mu, running, last = pieces.y, pieces.z, pieces.mu, memory.running, memory.last
    for k in range(first, pieces.time.size):
        if count + n + 1 > swings.shape[0]:
            return k, count
        if math.isnan(last[0]):
            last[0] = evaluate(basis, y[k], 0.0)
            _begin(pieces, k, basis, 0.0, 1.0 if y[k, n - 1] >= last[0] else -1.0, memory)
        begin, turns = 0.0, _turns(basis.derivative, y, k, running[DIRECTION], last[0])
        if turns or running[DIRECTION] < 0.0 or _near(z, k, running, RECORDS) or _near(mu, k, running, RECORDS + 2):
            if turns:
                begin, count = _split(law, pieces, k, basis, scratch, floor, memory, swings, count)
            _take(law, pieces, k, basis, scratch[1], begin, basis.nodes[n - 1], memory)
        last[0] = running[END] = y[k, n - 1]
    _date(basis, memory)
    return pieces.time.size, count


@inlined
def _turns(derivative: Array, y: Array, k: int, direction: float, left: float) -> bool:
    """Whether the elastic stress, going in `direction` with the value `left` so far, turns in piece k or at its beginning. The
    last row of `derivative` gives the slope at the end of the piece."""
    n = y.shape[1]
    slope, back = 0.0, False
    for j in range(n):
        back = back or direction * (y[k, j] - left) < 0.0
        left = y[k, j]
        slope += derivative[n - 1, j] * left
    return back or direction * slope < 0.0


@inlined
def _near(values: Array, k: int, running: Array, slot: int) -> bool:
    """Whether piece k may raise the record running[slot] of the maximum or running[slot + 1] of -minimum (see `raise_record`)."""
    bottom, top = bounds(values[k])
    reach = overshoot(top - bottom, values.shape[1])
    return not (top + reach <= running[slot] and reach - bottom <= running[slot + 1])


@inlined
def _split(
    law: Law,
    pieces: Pieces,
    k: int,
    basis: Basis,
    scratch: Array,
    floor: float,
    memory: DetectorMemory,
    swings: Array,
    count: int,
) -> tuple[float, int]:
    """Complete the swings that end in piece k; returns (point where the running one begins, number of swings)."""
    y, slopes = pieces.y[k], scratch[0]
    bottom, top = bounds(y)
    if top - bottom <= _FLAT * abs(y[0]):
        if memory.running[DIRECTION] * (y[y.size - 1] - memory.last[0]) < 0.0:
            count = _turn(pieces, k, basis, 0.0, floor, memory, swings, count)
        return 0.0, count
    differentiate(basis, y, slopes)
    begin, left, slope = 0.0, 0.0, evaluate(basis, slopes, 0.0)
    for j in range(y.size):
        direction = memory.running[DIRECTION]
        if direction * slopes[j] < 0.0:
            point = find_root(basis, slopes, 0.0, left, basis.nodes[j]) if direction * slope > 0.0 else left
            if point > begin:
                _take(law, pieces, k, basis, scratch[1], begin, point, memory)
            count = _turn(pieces, k, basis, point, floor, memory, swings, count)
            begin = point
        left, slope = basis.nodes[j], slopes[j]
    return begin, count


@njit
def _turn(
    pieces: Pieces, k: int, basis: Basis, point: float, floor: float, memory: DetectorMemory, swings: Array, count: int
) -> int:
    """End the running swing at `point` of piece k and begin the next one; returns how many completed swings are left."""
    running = memory.running
    running[END] = evaluate(basis, pieces.y[k], point)
    _date(basis, memory)
    for column in range(COLUMNS):
        swings[count, column] = running[column]
    count = thin(swings, count + 1, floor)
    _begin(pieces, k, basis, point, -running[DIRECTION], memory)
    return count


@njit
def _date(basis: Basis, memory: DetectorMemory) -> None:
    """Set the date of the running swing, if it is a fall and v has just risen to a new maximum."""
    if memory.running[DIRECTION] < 0.0 and memory.rise[RISING] > 0.0:
        memory.running[DATE] = date_rise(basis, memory.rise, memory.kept)


@njit
def _begin(pieces: Pieces, k: int, basis: Basis, point: float, direction: float, memory: DetectorMemory) -> None:
    """Begin a swing in `direction` (1 up, -1 down) at `point` of piece k."""
    running = memory.running
    running[DIRECTION] = direction
    running[BEGIN] = running[END] = evaluate(basis, pieces.y[k], point)
    running[DATE] = math.nan
    for slot in range(RECORDS, COLUMNS):
        running[slot] = -math.inf
    if direction < 0.0:
        begin_rise(memory.rise, pieces.time[k] + pieces.length[k] * point)


@njit
def _take(
    law: Law, pieces: Pieces, k: int, basis: Basis, scratch: Array, begin: float, end: float, memory: DetectorMemory
) -> None:
    """Update the running swing's records with the part [begin, end] of piece k and, in a fall, follow the rise of v."""
    running, z = memory.running, pieces.z[k]
    highest = running[RECORDS]
    if begin == 0.0 and end == basis.nodes[basis.nodes.size - 1] and highest > -math.inf:
        raise_record(basis, z, scratch, running, RECORDS)
        raise_record(basis, pieces.mu[k], scratch, running, RECORDS + 2)
    else:
        raise_record_within(basis, z, scratch, running, RECORDS, begin, end)
        raise_record_within(basis, pieces.mu[k], scratch, running, RECORDS + 2, begin, end)
    if running[DIRECTION] < 0.0:
        raised = running[RECORDS] > highest
        if not raised and memory.rise[RISING] > 0.0:
            running[DATE] = date_rise(basis, memory.rise, memory.kept)
        follow_rise(law, pieces.time[k], pieces.length[k], z, running[RECORDS], raised, memory.rise, memory.kept)
