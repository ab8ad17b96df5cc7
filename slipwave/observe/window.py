"""Selects the falls of the elastic stress that are the slip events of a window."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.observe.pieces import Array
from slipwave.observe.swings import BEGIN, DATE, DIRECTION, END, SHARE, largest_fall, simplify


class Judged(NamedTuple):
    """The `swings` of a run without those too small for the window, the rows of the window's `events` in them, and the
    `prominence` of each event (normal stress). `over` is true if a rise that counts has ended the last event's fall."""

    swings: Array
    events: NDArray[np.intp]
    prominence: Array
    over: bool

    @property
    def complete(self) -> Array:
        """The prominence of the events whose falls are over."""
        return self.prominence if self.over else self.prominence[:-1]


def judge(swings: Array, floor: float, after: float) -> Judged:
    """The events from `after` (transits) on among the `swings` of a run: falls of at least SHARE of the largest one, and `floor`.

    The size of a fall depends on how large a rise it may continue through. The largest fall is the largest of all falls that
    continue only through rises below SHARE of their own size.
    """
    threshold = _threshold(swings, floor, after)
    swings = swings.copy()
    swings = swings[: simplify(swings, 0, len(swings), threshold)]
    sizes = swings[:, DIRECTION] * (swings[:, END] - swings[:, BEGIN])
    events = np.flatnonzero((swings[:, DIRECTION] < 0.0) & (swings[:, DATE] >= after) & (sizes >= threshold))
    over = bool(events.size) and bool((sizes[events[-1] + 1 :] >= threshold).any())
    return Judged(swings, events, sizes[events], over)


def _threshold(swings: Array, floor: float, after: float) -> float:
    """The prominence that an event needs."""
    falls = np.flatnonzero((swings[:, DIRECTION] < 0.0) & (swings[:, DATE] >= after))
    first = int(falls[0]) if falls.size else len(swings)
    threshold = float(np.inf)
    while True:
        lower = max(floor, SHARE * largest_fall(swings, first, threshold))
        if lower >= threshold:
            return threshold
        threshold = lower
