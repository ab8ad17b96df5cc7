"""The compiled loop over the pieces: swings of the elastic stress, each with its extrema and its date.

Turning points are roots of y' within the polynomial of a piece. Between two pieces the slope may also change sign without a root.
"""

import math
from typing import NamedTuple

import numpy as np

from slipwave.compiled import inlined, njit
from slipwave.friction.law import Law
from slipwave.observe.extrema import bounds, differentiate, evaluate, find_root, near, raise_record
from slipwave.observe.pieces import Array, Basis, Pieces
from slipwave.observe.rise import RISING, SLOTS, begin_rise, date_rise, follow_rise, room_for_rise
from slipwave.observe.swings import BEGIN, COLUMNS, DATE, DIRECTION, END, RECORDS, thin

_FLAT = 1e-14  # relative; a smaller change of y within a piece is rounding


class Detector(NamedTuple):
    """The `law`, the `basis` of the pieces and the `floor` below which a fall is none; the `running` swing; the memory of `rise`
    and the pieces that are `kept` for it; y at the end of the `last` piece (shape (1,), NaN before the first piece); `scratch`
    (2, nodes); the complete `swings`, of which the first `filled` (shape (1,)) are there."""

    law: Law
    basis: Basis
    floor: float
    running: Array
    rise: Array
    kept: Array
    last: Array
    scratch: Array
    swings: Array
    filled: Array


def new_detector(law: Law, basis: Basis, floor: float, swings: int) -> Detector:
    """A detector before the first piece, with room for so many `swings`."""
    n = basis.nodes.size
    memory = np.zeros(COLUMNS), np.zeros(SLOTS), room_for_rise(n), np.full(1, np.nan), np.empty((2, n))
    return Detector(law, basis, floor, *memory, np.empty((swings, COLUMNS)), np.zeros(1))


@njit
def scan(pieces: Pieces, first: int, found: Detector) -> int:
    """Read the pieces from number `first` on and append completed swings; returns the next piece. It stops early if there is no
    room for all swings that one more piece may complete."""
    y, z, mu, running, last = pieces.y, pieces.z, pieces.mu, found.running, found.last
    nodes = found.basis.nodes
    n = nodes.size
    for k in range(first, pieces.time.size):
        if found.filled[0] + n + 1 > found.swings.shape[0]:
            return k
        if math.isnan(last[0]):
            last[0] = evaluate(found.basis, y[k], 0.0)
            _begin(pieces, k, 0.0, 1.0 if y[k, n - 1] >= last[0] else -1.0, found)
        turns = _turns(found.basis.derivative, y, k, running[DIRECTION], last[0])
        if turns or running[DIRECTION] < 0.0 or near(z[k], running, RECORDS) or near(mu[k], running, RECORDS + 2):
            begin = _split(pieces, k, found) if turns else 0.0
            _take(pieces, k, begin, nodes[n - 1], found)
        last[0] = running[END] = y[k, n - 1]
    _date(found)
    return pieces.time.size


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
def _split(pieces: Pieces, k: int, found: Detector) -> float:
    """Complete the swings that end in piece k; returns the point where the running one begins."""
    y, slopes, basis, running = pieces.y[k], found.scratch[0], found.basis, found.running
    bottom, top = bounds(y)
    if top - bottom <= _FLAT * abs(y[0]):
        if running[DIRECTION] * (y[y.size - 1] - found.last[0]) < 0.0:
            _turn(pieces, k, 0.0, found)
        return 0.0
    differentiate(basis, y, slopes)
    begin, left, slope = 0.0, 0.0, evaluate(basis, slopes, 0.0)
    for j in range(y.size):
        direction = running[DIRECTION]
        if direction * slopes[j] < 0.0:
            point = find_root(basis, slopes, 0.0, left, basis.nodes[j]) if direction * slope > 0.0 else left
            if point > begin:
                _take(pieces, k, begin, point, found)
            _turn(pieces, k, point, found)
            begin = point
        left, slope = basis.nodes[j], slopes[j]
    return begin


@njit
def _turn(pieces: Pieces, k: int, point: float, found: Detector) -> None:
    """End the running swing at `point` of piece k and begin the next one."""
    running, count = found.running, int(found.filled[0])
    running[END] = evaluate(found.basis, pieces.y[k], point)
    _date(found)
    for column in range(COLUMNS):
        found.swings[count, column] = running[column]
    found.filled[0] = thin(found.swings, count + 1, found.floor)
    _begin(pieces, k, point, -running[DIRECTION], found)


@njit
def _date(found: Detector) -> None:
    """Set the date of the running swing, if it is a fall and v has just risen to a new maximum."""
    if found.running[DIRECTION] < 0.0 and found.rise[RISING] > 0.0:
        found.running[DATE] = date_rise(found.basis, found.rise, found.kept)


@njit
def _begin(pieces: Pieces, k: int, point: float, direction: float, found: Detector) -> None:
    """Begin a swing in `direction` (1 up, -1 down) at `point` of piece k."""
    running = found.running
    running[DIRECTION] = direction
    running[BEGIN] = running[END] = evaluate(found.basis, pieces.y[k], point)
    running[DATE] = math.nan
    for slot in range(RECORDS, COLUMNS):
        running[slot] = -math.inf
    if direction < 0.0:
        begin_rise(found.rise, pieces.time[k] + pieces.length[k] * point)


@njit
def _take(pieces: Pieces, k: int, begin: float, end: float, found: Detector) -> None:
    """Update the running swing's records with the part [begin, end] of piece k and, in a fall, follow the rise of v."""
    basis, running, z, slopes = found.basis, found.running, pieces.z[k], found.scratch[1]
    highest = running[RECORDS]
    raise_record(basis, z, slopes, running, RECORDS, begin, end)
    raise_record(basis, pieces.mu[k], slopes, running, RECORDS + 2, begin, end)
    if running[DIRECTION] < 0.0:
        raised = running[RECORDS] > highest
        if not raised:
            _date(found)
        follow_rise(found.law, pieces.time[k], pieces.length[k], z, running[RECORDS], raised, found.rise, found.kept)
