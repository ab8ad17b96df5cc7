"""The elastic stress as a sequence of swings (alternating rises and falls), and the removal of swings too small to count.

A swing whose two neighbours are at least as large is removed by joining the three into one. This is the pairing of turning points
by persistence, known from the counting of load cycles as rainflow. The result for a threshold does not depend on the order of the
removals, nor on whether smaller thresholds came first. Therefore swings can be removed during a run.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import njit
from slipwave.observe.pieces import Array

# columns of a swing: y and the time (transits) at its begin and its end; from RECORDS on: max and -min of the rate unknown, max
# and -min of the friction stress
DIRECTION, BEGIN, END, BEGAN, ENDED, DATE, RECORDS = 0, 1, 2, 3, 4, 5, 6
COLUMNS = RECORDS + 4

SHARE = 0.1
"""Smallest fall that counts, as a share of the largest fall in the judged window."""
_SEARCHED = 0.5  # `thin` goes back to the last fall that is at least this share of the new one; it might go back further


@njit
def size_of(swing: Array) -> float:
    """Height of a swing, in units of the normal stress."""
    return float(swing[DIRECTION] * (swing[END] - swing[BEGIN]))


@njit
def _join_last(swings: Array, first: int, count: int, threshold: float) -> int:
    """Join the last three of swings[first:count] while the middle one is below `threshold` and no larger than the others;
    returns how many swings are left."""
    while count - first >= 3:
        middle = size_of(swings[count - 2])
        if not (middle < threshold and middle <= size_of(swings[count - 3]) and middle <= size_of(swings[count - 1])):
            break
        left, right = swings[count - 3], swings[count - 1]
        if right[RECORDS] > left[RECORDS]:  # the date of the fall that reaches the higher rate
            left[DATE] = right[DATE]
        left[END], left[ENDED] = right[END], right[ENDED]
        for column in range(RECORDS, COLUMNS):
            left[column] = max(left[column], swings[count - 2, column], right[column])
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
def thin(swings: Array, count: int, floor: float) -> int:
    """After a swing is complete, remove swings that cannot count in any window that ends later; returns how many are left.

    Every window that contains a swing also contains the falls after it, so a swing below SHARE of a later fall never counts. A
    swing without such a later fall may still count in a window that begins late, and is kept.
    """
    count = _join_last(swings, 0, count, floor)
    last = swings[count - 1]
    if last[DIRECTION] > 0.0:
        return count
    fall = size_of(last)
    first = count - 3
    while first > 0 and not (swings[first, DIRECTION] < 0.0 and size_of(swings[first]) >= _SEARCHED * fall):
        first -= 1
    return _simplify(swings, max(first, 0), count, max(floor, SHARE * fall))


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
    `floor` (normal stress) in which the stiffness times the slip is at least `least`: the fall, and what the drive adds at the
    rate `loading` (normal stress per transit) while it lasts.

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
