"""The elastic stress as a sequence of swings (alternating rises and falls): the compiled loop over the pieces that finds them,
each with its extrema and its date, the removal of swings too small to count, and the choice of those that are slip events.

Turning points are roots of y' within the polynomial of a piece. Between two pieces the slope may also change sign without a root.

For laws that allow v <= 0 the rate unknown of a piece is replaced, where v changes its sign, by one that is as smooth as the
stress (`OfStep`).

The date of a slip event is the time at which v, rising to its maximum in the fall of the elastic stress, passes half of that
maximum. If v is above this level in the whole rise, the date is the beginning of the fall. This time is close to that of the
steepest rise of v, where dv/dt is largest. That is a root of a second derivative: a polynomial that gives v to 1e-9 gives it to
1e-6 at best. The passage of a level is as accurate as v, and so are periods. The level grows with the largest rate so far; the
pieces from its latest passage on are kept until the maximum is known.

A swing whose two neighbours are at least as large is removed by joining the three into one. This is the pairing of turning points
by persistence, known from the counting of load cycles as rainflow. The result for a threshold does not depend on the order of the
removals, nor on whether smaller thresholds came first. Therefore swings can be removed during a run.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import inlined, njit
from slipwave.compiled.dispatch import by_class
from slipwave.friction import Law, OfStep, law_of_step, rate_of, to_own, to_step, unknown_of
from slipwave.observe.extrema import bounds, differentiate, evaluate, find_root, overshoot, raise_record
from slipwave.observe.pieces import Array, Basis, Pieces

# columns of a swing: y and the time (transits) at its begin and its end; from RECORDS on: max and -min of the rate unknown, max
# and -min of the friction stress
DIRECTION, BEGIN, END, BEGAN, ENDED, DATE, RECORDS = 0, 1, 2, 3, 4, 5, 6
COLUMNS = RECORDS + 4
# the detector's memory: the running swing; of the rise of v in it, the level of z, row after that of the piece in which v reached
# its maximum (0: the date is known), first and last (exclusive) of the pieces that are kept; y at the end of the last piece, NaN
# before the first; number of complete swings
LEVEL, RISING, FRONT, KEPT, LAST, COUNT = COLUMNS, COLUMNS + 1, COLUMNS + 2, COLUMNS + 3, COLUMNS + 4, COLUMNS + 5
_SLOTS = COLUMNS + 6

SHARE = 0.1
"""Smallest fall that counts, as a share of the largest fall in the judged window."""
_SEARCHED = 0.5  # `_thin` goes back to the last fall that is at least this share of the new one; it might go back further


@njit
def _size_of(swing: Array) -> float:
    """Height of a swing, in units of the normal stress."""
    return float(swing[DIRECTION] * (swing[END] - swing[BEGIN]))


@njit
def _join_last(swings: Array, first: int, count: int, threshold: float) -> int:
    """Join the last three of swings[first:count] while the middle one is below `threshold` and no larger than the others;
    returns how many swings are left."""
    while count - first >= 3:
        middle = _size_of(swings[count - 2])
        if not (middle < threshold and middle <= _size_of(swings[count - 3]) and middle <= _size_of(swings[count - 1])):
            break
        left, right = swings[count - 3], swings[count - 1]
        if right[RECORDS] > left[RECORDS]:  # the date of the fall that reaches the higher rate
            left[DATE] = right[DATE]
        left[END], left[ENDED] = right[END], right[ENDED]
        for column in range(RECORDS, COLUMNS):
            left[column] = max(max(left[column], swings[count - 2, column]), right[column])
        count -= 2
    return count


@njit
def _simplify(swings: Array, first: int, count: int, threshold: float) -> int:
    """Remove swings below `threshold` from swings[first:count], in place; returns how many swings are left in all."""
    kept = first
    for i in range(first, count):
        if kept < i:
            for column in range(COLUMNS):
                swings[kept, column] = swings[i, column]
        kept = _join_last(swings, first, kept + 1, threshold)
    return kept


@njit
def _largest_fall(swings: Array, first: int, threshold: float) -> float:
    """Height of the largest fall from swings[first] on that continues only through rises below `threshold` (normal stress)."""
    best, top, bottom = 0.0, -math.inf, -math.inf
    for i in range(first, swings.shape[0]):
        for y in (swings[i, BEGIN], swings[i, END]):
            if y > top or y - bottom >= threshold:
                top, bottom = y, y
            bottom = min(bottom, y)
            best = max(best, top - bottom)
    return float(best)


@njit
def _thin(swings: Array, count: int, floor: float) -> int:
    """After a swing is complete, remove swings that cannot count in any window that ends later; returns how many are left.

    Every window that contains a swing also contains the falls after it, so a swing below SHARE of a later fall never counts. A
    swing without such a later fall may still count in a window that begins late, and is kept.
    """
    count = _join_last(swings, 0, count, floor)
    last = swings[count - 1]
    if last[DIRECTION] > 0.0:
        return count
    fall = _size_of(last)
    first = count - 3
    while first > 0 and not (swings[first, DIRECTION] < 0.0 and _size_of(swings[first]) >= _SEARCHED * fall):
        first -= 1
    return _simplify(swings, first if first > 0 else 0, count, max(floor, SHARE * fall))


_SLOPES, _VALUES, _EXTREMES = 1, 2, 3  # rows of the detector's scratch
_SCRATCH = 4
"""Rows of scratch; the first is not used here."""

_FLAT = 1e-14  # relative; a smaller change of y within a piece is rounding
_TIME, _LENGTH, _LOWEST = 0, 1, 2  # columns of a piece that is kept, before its values of z
FIRST_NODE = 3
_FIRST_SIZE, MOST_KEPT = 256, 1 << 17  # pieces; of a rise over half as many from half to full height every other one is kept


@by_class()
def _raise_rate(
    law: Law, own: Law, basis: Basis, z: Array, scratch: Array, memory: Array, slot: int, begin: float, end: float
) -> None:
    """`raise_record` of the unknown `z` of the law `own` in a piece; `law`: its `law_of_step` there."""
    raise_record(basis, z, scratch[_SLOPES], memory, slot, begin, end)


@_raise_rate.register(OfStep)
def _raise_smoothly(law, own, basis, z, scratch, memory, slot, begin, end):  # type: ignore[no-untyped-def]
    values, extremes = scratch[_VALUES], scratch[_EXTREMES]
    for j in range(z.size):
        values[j] = z[j]
    to_step(law, own, values)
    extremes[0], extremes[1] = memory[slot], -memory[slot + 1]
    to_step(law, own, extremes[:2])
    extremes[1] = -extremes[1]
    high, low = extremes[0], extremes[1]
    raise_record(basis, values, scratch[_SLOPES], extremes, 0, begin, end)
    raised, lowered = extremes[0] > high, extremes[1] > low
    extremes[1] = -extremes[1]
    to_own(law, extremes[:2])
    if raised:
        memory[slot] = extremes[0]
    if lowered:
        memory[slot + 1] = -extremes[1]


@by_class()
def _last_passage(law: Law, basis: Basis, z: Array, lowest: float, level: float, node: int, scratch: Array) -> float:
    """Point of a piece with unknowns `z`, of which `lowest` is the least, at which z last passed `level` upwards before `node`; 1
    if it did in a jump at the end of the piece, -1 if z was above `level` all the time."""
    return _passage(basis, z, lowest, level, node)


@_last_passage.register(OfStep)
def _pass_smoothly(law, basis, z, lowest, level, node, scratch):  # type: ignore[no-untyped-def]
    values, own, rate = scratch[_VALUES], law.law, rate_of(law.law, level)
    if rate <= 0.0 or lowest > unknown_of(own, 0.0):
        return _passage(basis, z, lowest, level, node)
    for j in range(z.size):
        values[j] = z[j]
    here, extremes = OfStep(own, 0.5 * rate), scratch[_EXTREMES]  # as smooth as v below the level
    extremes[0], extremes[1] = lowest, level
    to_step(here, own, values)
    to_step(here, own, extremes[:2])
    return _passage(basis, values, extremes[0], extremes[1], node)


@njit
def _passage(basis: Basis, z: Array, lowest: float, level: float, node: int) -> float:
    if node == z.size and z[node - 1] < level:
        return 1.0
    if lowest < level:
        for j in range(z.size - 2, -1, -1):
            if j < node and z[j] < level:
                return find_root(basis, z, level, basis.nodes[j], basis.nodes[j + 1])
    return find_root(basis, z, level, 0.0, basis.nodes[0]) if evaluate(basis, z, 0.0) < level <= z[0] else -1.0


def rise_buffer(nodes: int, kept: Array | None = None, more: int = _FIRST_SIZE) -> Array:
    """Buffer for the pieces `kept` so far and `more` of them, of `nodes` nodes each; at most MOST_KEPT rows."""
    kept = np.empty((0, FIRST_NODE + nodes)) if kept is None else kept
    buffer = np.zeros((min(2 * (len(kept) + more), MOST_KEPT), FIRST_NODE + nodes))
    buffer[: len(kept)] = kept
    return buffer


class _Piece(NamedTuple):
    """One of `Pieces`, with psi at its first node: few values, because the time to compile a call grows with their number."""

    time: float
    length: float
    z: Array
    psi: float
    mu: Array
    y: Array


class _Detector(NamedTuple):
    """State of the detector: `law`, `basis` of the pieces, `floor` of a fall (normal stress); its `memory` (see the slots above);
    the pieces `kept` of a rise; `scratch` (4, nodes); rows for complete `swings`."""

    law: Law
    basis: Basis
    floor: float
    memory: Array
    kept: Array
    scratch: Array
    swings: Array


def new_detector(law: Law, basis: Basis, floor: float, swings: int) -> _Detector:
    """A detector before the first piece, with rows for `swings` swings."""
    n = basis.nodes.size
    memory = np.zeros(_SLOTS)
    memory[LAST] = math.nan
    return _Detector(law, basis, floor, memory, rise_buffer(n), np.empty((_SCRATCH, max(n, 2))), np.empty((swings, COLUMNS)))


@njit
def scan(pieces: Pieces, first: int, detector: _Detector) -> int:
    """Read the pieces from number `first` on and append completed swings; returns the next piece. It stops early if the free rows
    may not hold all swings that the next piece completes. If there are no pieces, the running swing is dated."""
    memory, nodes = detector.memory, detector.basis.nodes
    n = nodes.size
    for k in range(first, pieces.time.size):
        if memory[COUNT] + n + 1 > detector.swings.shape[0]:
            return k
        piece = _Piece(pieces.time[k], pieces.length[k], pieces.z[k], pieces.psi[k, 0], pieces.mu[k], pieces.y[k])
        if math.isnan(memory[LAST]):
            memory[LAST] = evaluate(detector.basis, piece.y, 0.0)
            _begin(piece, 0.0, 1.0 if piece.y[n - 1] >= memory[LAST] else -1.0, detector)
        turns, stirs = _look(detector.basis.derivative, piece, memory, memory[LAST])
        if turns or stirs or memory[DIRECTION] < 0.0:
            begin = _split(piece, detector) if turns else 0.0
            _take(piece, begin, nodes[n - 1], detector)
        memory[LAST] = memory[END] = piece.y[n - 1]
        memory[ENDED] = piece.time + piece.length * nodes[n - 1]
    if not pieces.time.size:
        _date(detector)
    return pieces.time.size


@inlined
def _look(derivative: Array, piece: _Piece, memory: Array, left: float) -> tuple[bool, bool]:
    """Whether the elastic stress, `left` at the end of the piece before, turns in the piece or at its beginning, and whether the
    rate or the friction stress may exceed a record of the running swing. Most pieces need only this loop. The last row
    of `derivative` gives the slope at the end of the piece."""
    y, z, mu, direction = piece.y, piece.z, piece.mu, memory[DIRECTION]
    n = y.size
    slope, back = 0.0, False
    low_z, top_z, low_mu, top_mu = z[0], z[0], mu[0], mu[0]
    for j in range(n):
        back |= direction * (y[j] - left) < 0.0
        left = y[j]
        slope += derivative[n - 1, j] * left
        low_z, top_z = min(low_z, z[j]), max(top_z, z[j])
        low_mu, top_mu = min(low_mu, mu[j]), max(top_mu, mu[j])
    by_z, by_mu = overshoot(top_z - low_z, n), overshoot(top_mu - low_mu, n)
    quiet = top_z + by_z <= memory[RECORDS] and by_z - low_z <= memory[RECORDS + 1]
    quiet = quiet and top_mu + by_mu <= memory[RECORDS + 2] and by_mu - low_mu <= memory[RECORDS + 3]
    return back or direction * slope < 0.0, not quiet


@inlined
def _split(piece: _Piece, detector: _Detector) -> float:
    """Complete the swings that end in the piece; returns the point where the running one begins."""
    y, slopes, basis, memory = piece.y, detector.scratch[0], detector.basis, detector.memory
    bottom, top = bounds(y)
    if top - bottom <= _FLAT * abs(y[0]):
        if memory[DIRECTION] * (y[y.size - 1] - memory[LAST]) < 0.0:
            _turn(piece, 0.0, detector)
        return 0.0
    differentiate(basis, y, slopes)
    begin, left, slope = 0.0, 0.0, evaluate(basis, slopes, 0.0)
    for j in range(y.size):
        direction = memory[DIRECTION]
        if direction * slopes[j] < 0.0:
            point = find_root(basis, slopes, 0.0, left, basis.nodes[j]) if direction * slope > 0.0 else left
            if point > begin:
                _take(piece, begin, point, detector)
            _turn(piece, point, detector)
            begin = point
        left, slope = basis.nodes[j], slopes[j]
    return begin


@njit
def _turn(piece: _Piece, point: float, detector: _Detector) -> None:
    """End the running swing at `point` of the piece and begin the next one."""
    memory = detector.memory
    count = int(memory[COUNT])
    memory[END] = evaluate(detector.basis, piece.y, point)
    memory[ENDED] = piece.time + piece.length * point
    _date(detector)
    for column in range(COLUMNS):
        detector.swings[count, column] = memory[column]
    memory[COUNT] = _thin(detector.swings, count + 1, detector.floor)
    _begin(piece, point, -memory[DIRECTION], detector)


@njit
def _date(detector: _Detector) -> None:
    """Set the date of the running swing, if it is a fall and v has risen to a new maximum: the time (transits), within the fall,
    at which z last passed the level before the highest node of the piece of that maximum. The search may be long; therefore it
    waits until the date is asked for, or the pieces that it needs are dropped."""
    basis, memory, kept = detector.basis, detector.memory, detector.kept
    if not (memory[DIRECTION] < 0.0 and memory[RISING] > 0.0):
        return
    n, last, node, date = basis.nodes.size, int(memory[RISING]) - 1, 0, memory[BEGAN]
    memory[RISING] = 0.0
    for j in range(1, n):
        if kept[last, FIRST_NODE + j] > kept[last, FIRST_NODE + node]:
            node = j
    level = min(memory[LEVEL], kept[last, FIRST_NODE + node])
    for piece in range(last, int(memory[FRONT]) - 1, -1):
        z, before = kept[piece, FIRST_NODE:], node if piece == last else n
        point = _last_passage(law_of_step(detector.law, 0.0), basis, z, kept[piece, _LOWEST], level, before, detector.scratch)
        if point >= 0.0:
            date = max(memory[BEGAN], kept[piece, _TIME] + kept[piece, _LENGTH] * point)
            break
    memory[DATE] = date


@njit
def _begin(piece: _Piece, point: float, direction: float, detector: _Detector) -> None:
    """Begin a swing in `direction` (1 up, -1 down) at `point` of the piece."""
    memory = detector.memory
    memory[DIRECTION] = direction
    memory[BEGIN] = memory[END] = evaluate(detector.basis, piece.y, point)
    memory[BEGAN] = memory[ENDED] = piece.time + piece.length * point
    memory[DATE] = math.nan
    for slot in range(RECORDS, COLUMNS):
        memory[slot] = -math.inf
    if direction < 0.0:
        memory[LEVEL] = -math.inf
        memory[RISING] = memory[FRONT] = memory[KEPT] = 0.0


@njit
def _take(piece: _Piece, begin: float, end: float, detector: _Detector) -> None:
    """Update the running swing's records with the part [begin, end] of the piece and, in a fall, follow the rise of v."""
    basis, memory, slopes, law = detector.basis, detector.memory, detector.scratch[1], law_of_step(detector.law, piece.psi)
    highest = memory[RECORDS]
    _raise_rate(law, detector.law, basis, piece.z, detector.scratch, memory, RECORDS, begin, end)
    raise_record(basis, piece.mu, slopes, memory, RECORDS + 2, begin, end)
    if memory[DIRECTION] < 0.0:
        _follow_rise(piece, memory[RECORDS] > highest, detector)


@njit
def _follow_rise(piece: _Piece, raised: bool, detector: _Detector) -> None:
    """Add a piece of the running fall; `raised` is true if the largest z in the fall lies in it."""
    memory, kept = detector.memory, detector.kept
    if memory[KEPT] == kept.shape[0]:
        _date(detector)
    last = _keep(piece, memory, kept)
    if raised:
        memory[RISING] = last + 1.0
        memory[LEVEL] = unknown_of(detector.law, 0.5 * rate_of(detector.law, memory[RECORDS]))
        while memory[FRONT] + 1 < last and kept[int(memory[FRONT]) + 1, kept.shape[1] - 1] < memory[LEVEL]:
            memory[FRONT] += 1.0
    elif kept[last, _LOWEST] < memory[LEVEL]:
        _date(detector)
        memory[FRONT] = last


@inlined
def _keep(piece: _Piece, memory: Array, kept: Array) -> int:
    """Append a piece and return its row. If `kept` is full, drop the pieces before the front, or every other piece if those are
    few: to move many rows for each new one would take longer than all else."""
    front, end = int(memory[FRONT]), int(memory[KEPT])
    if end == kept.shape[0]:
        step = 1 if 2 * front >= end else 2
        for i in range((end - front) // step):
            for column in range(kept.shape[1]):
                kept[i, column] = kept[front + step * i, column]
        end = (end - front) // step
        memory[FRONT] = 0.0
    kept[end, _TIME] = piece.time
    kept[end, _LENGTH] = piece.length
    kept[end, _LOWEST] = bounds(piece.z)[0]
    for j in range(piece.z.size):
        kept[end, FIRST_NODE + j] = piece.z[j]
    memory[KEPT] = end + 1
    return end


class JudgedSwings(NamedTuple):
    """The `swings` of a run without those too small for the window, the rows of the window's `events` in them, and the
    `prominence` of each event (normal stress). `over` is true if a rise that counts has ended the last event's fall. `waves`:
    number of the window's falls that would be events if they slipped enough."""

    swings: Array
    events: NDArray[np.intp]
    prominence: Array
    over: bool
    waves: int

    @property
    def complete(self) -> Array:
        """The prominence of the events whose falls have ended."""
        return self.prominence if self.over else self.prominence[:-1]


def judge_swings(swings: Array, floor: float, after: float, loading: float, least: float, drifts: bool = False) -> JudgedSwings:
    """The events from `after` (transits) on among the `swings` of a run: falls of at least SHARE of the largest one and at least
    `floor` (normal stress) in which the stiffness times the slip is at least `least`. That product is the fall plus what the
    drive adds while it lasts, at the rate `loading` (normal stress per transit).

    The size of a fall depends on how large a rise it may continue through. The largest fall is the largest of all falls that
    continue only through rises below SHARE of their own size. Behind faces without a spring the elastic stress `drifts`: in the
    long run each cycle begins lower, and without the mean drift falls of many cycles would seem to be one.
    """
    swings = swings.copy()
    drift = _mean_drift(swings, after) if drifts else 0.0
    swings[:, BEGIN : END + 1] -= drift * swings[:, BEGAN : ENDED + 1]
    threshold = _threshold(swings, floor, after)
    swings = swings[: _simplify(swings, 0, len(swings), threshold)]
    sizes = swings[:, DIRECTION] * (swings[:, END] - swings[:, BEGIN])
    falls = np.flatnonzero((swings[:, DIRECTION] < 0.0) & (swings[:, DATE] >= after) & (sizes >= threshold))
    slips = (sizes + (loading - drift) * (swings[:, ENDED] - swings[:, BEGAN]))[falls] >= least
    events = falls[slips]
    over = bool(events.size) and bool((sizes[events[-1] + 1 :] >= threshold).any())
    swings[:, BEGIN : END + 1] += drift * swings[:, BEGAN : ENDED + 1]
    return JudgedSwings(swings, events, sizes[events], over, falls.size - events.size)


def _mean_drift(swings: Array, after: float) -> float:
    """The mean slope from the first maximum to the last one from `after` on, in normal stress per transit."""
    falls = swings[(swings[:, DIRECTION] < 0.0) & (swings[:, BEGAN] >= after)]
    if len(falls) < 2:
        return 0.0
    return float((falls[-1, BEGIN] - falls[0, BEGIN]) / (falls[-1, BEGAN] - falls[0, BEGAN]))


def _threshold(swings: Array, floor: float, after: float) -> float:
    """The least prominence of an event."""
    falls = np.flatnonzero((swings[:, DIRECTION] < 0.0) & (swings[:, DATE] >= after))
    first = int(falls[0]) if falls.size else len(swings)
    threshold, lower = math.inf, max(floor, SHARE * _largest_fall(swings, first, math.inf))
    while lower < threshold:
        threshold, lower = lower, max(floor, SHARE * _largest_fall(swings, first, lower))
    return threshold
