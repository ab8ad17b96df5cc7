"""Ranges of slip rate and friction stress over up to 4096 equal intervals of a run, for figures; memory of fixed size."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from slipwave.compiled import inlined, njit
from slipwave.friction import rates
from slipwave.observe.extrema import bounds
from slipwave.observe.pieces import SAME, Array, Pieces
from slipwave.scene import Scene

COUNT = 4096
"""Intervals, at most; a figure is a thousand pixels wide."""

_UNREAD = 1 << 19  # samples, 24 MB
_FIRST = 2.0**-10  # length of an interval at first, in transits or in L of slip
_ROWS = 4
_TIME, _SLIP, _Z, _MU = range(_ROWS)  # columns of the least values; those of the greatest follow

Ranges: TypeAlias = tuple[Array, Array]
"""The least and the greatest values in each interval."""

_Bins: TypeAlias = tuple[Array, Array]
"""The width (1,) of intervals, and the ranges (intervals, columns) of the samples in them; infinite where there are none."""


class EnvelopeIntervals(NamedTuple):
    """The intervals that hold samples, as arrays of equal length: `time` (transits) and `slip` (L, from the first sample on) of
    the latest sample, and the ranges of the slip rate (V*) and of the friction stress."""

    time: Array
    slip: Array
    rate: Ranges
    stress: Ranges


class Envelope:
    """Observer that computes ranges over equal intervals of time and of slip from `begin` to `end` (transits).

    The intervals become twice as long each time that the run leaves them. Slip follows from the stress that it releases, y' =
    stiffness (V - v), so that it is exact after gaps too. Gaps are refused only where the window is so short that its intervals
    may be shorter than two transits.
    """

    def __init__(self, scene: Scene, nodes: Array, begin: float = 0.0, end: float = math.inf) -> None:
        self._scene, self._nodes = scene, np.asarray(nodes)
        self._begin, self._end = begin, end
        self._bins = _empty_bins(), _empty_bins()
        self._reached, self._origin = 0.0, np.full(1, math.nan)
        self._unread: list[tuple[float, Pieces]] = []

    @property
    def whole_from(self) -> float:
        """As `slipwave.solve.Spanning`."""
        return self._begin if self._end - self._begin <= 2.0 * COUNT and self._reached <= self._end else math.inf

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run; they are evaluated in large batches, or when ranges are asked for."""
        self._unread.append((self._reached, pieces))
        self._reached = float(pieces.time[-1] + pieces.length[-1]) if pieces.time.size else self._reached
        if sum(part.z.size for _, part in self._unread) > _UNREAD:
            self._read()

    def _read(self) -> None:
        frame = self._begin, self._end, self._scene.transit, self._scene.stiffness
        scratch = np.empty((_ROWS + 2, self._nodes.size)), np.empty(2 * _ROWS)
        for reached, pieces in self._unread:
            _take(pieces, self._nodes, reached, frame, self._scene.drive.travelled, scratch, self._origin, *self._bins)
        self._unread.clear()

    def by_time(self) -> EnvelopeIntervals:
        """The motion so far over equal intervals of time."""
        return self._shown(0)

    def by_slip(self) -> EnvelopeIntervals:
        """The motion so far over equal intervals of slip."""
        return self._shown(1)

    def _shown(self, which: int) -> EnvelopeIntervals:
        self._read()
        _, ranges = self._bins[which]
        low, high = np.split(ranges[np.isfinite(ranges[:, 0])].T, 2)
        rate = rates(self._scene.law, low[_Z]), rates(self._scene.law, high[_Z])
        return EnvelopeIntervals(high[_TIME], high[_SLIP], rate, (low[_MU], high[_MU]))

    def state(self) -> dict[str, Array]:
        """The ranges so far, for a checkpoint."""
        self._read()
        tables = {f"ranges{n}": ranges.T.copy() for n, (_, ranges) in enumerate(self._bins)}
        widths = [float(width[0]) for width, _ in self._bins]
        return {"numbers": np.array([self._begin, self._end, self._reached, self._origin[0], *widths]), **tables}

    def restore(self, state: dict[str, Array]) -> None:
        """Continue from what `state` returned. Raises ValueError if it is of another window."""
        self._unread.clear()
        begin, end, self._reached, origin, *widths = state["numbers"].tolist()
        if (begin, end) != (self._begin, self._end):
            raise ValueError(f"the window is {begin:g}:{end:g}; this run asks for {self._begin:g}:{self._end:g}")
        self._origin = np.full(1, origin)
        by_time, by_slip = ((np.full(1, width), state[f"ranges{n}"].T.copy()) for n, width in enumerate(widths))
        self._bins = by_time, by_slip


def _empty_bins() -> _Bins:
    return np.full(1, _FIRST), np.repeat([[np.inf, -np.inf]], _ROWS, axis=1).repeat(COUNT, axis=0)


@njit
def _take(
    pieces: Pieces,
    nodes: Array,
    reached: float,
    frame: tuple[float, float, float, float],
    travelled: tuple[Array, Array, Array, Array],
    scratch: tuple[Array, Array],
    origin: Array,
    by_time: _Bins,
    by_slip: _Bins,
) -> None:
    """Add pieces with these `nodes`, after the time `reached`, as far as they are within the window; `frame`: its begin and
    end (transits), a transit in L/V*, and the stiffness of the slabs; `travelled`: as in `Drive`; `origin` (1,): the slip of the
    first sample, NaN before it. After a gap, and in intervals longer than a transit, all samples of a transit go to one interval,
    even if the next ones stay empty: a part of a transit has another range."""
    (begin, end, unit, stiffness), (knots, paces, gains, passed_by) = frame, travelled
    whole, gaps, here, transit, first = by_time[0][0] >= 1.0, False, 0, -math.inf, 0.0
    (samples, where), ends = (scratch[0][:_ROWS], scratch[0][_ROWS:]), scratch[1]
    for k in range(pieces.time.size):
        gaps |= pieces.time[k] > reached + 0.5
        reached = pieces.time[k] + pieces.length[k]
    for k in range(pieces.time.size):
        count, passed = 0, math.floor(pieces.time[k] + SAME)
        for j in range(nodes.size):
            time = pieces.time[k] + pieces.length[k] * nodes[j]
            if not begin <= time <= end:
                continue
            while here + 1 < knots.size and knots[here + 1] <= time:
                here += 1
            since = time - knots[here]
            pace = paces[here] + 0.5 * gains[here] * max(since, 0.0)
            slip = unit * (passed_by[here] + since * pace - pieces.y[k, j] / stiffness)
            if math.isnan(origin[0]):
                origin[0] = slip
            slip -= origin[0]
            if passed > transit:
                transit, first = passed, slip
            samples[_TIME, count], samples[_SLIP, count] = time, slip
            samples[_Z, count], samples[_MU, count] = pieces.z[k, j], pieces.mu[k, j]
            where[0, count] = max(transit - begin, 0.0) if whole else time - begin
            where[1, count] = first if gaps else slip
            count += 1
        if count:
            ends[_TIME], ends[_ROWS + _TIME] = samples[_TIME, 0], samples[_TIME, count - 1]
            for column in range(_SLIP, _ROWS):
                ends[column], ends[_ROWS + column] = bounds(samples[column, :count])
            _widen(by_time, where[0, :count], where[0, 0], where[0, count - 1], samples, ends)
            lowest, highest = (first, first) if gaps else (ends[_SLIP], ends[_ROWS + _SLIP])
            _widen(by_slip, where[1, :count], lowest, highest, samples, ends)


@inlined
def _widen(bins: _Bins, where: Array, lowest: float, highest: float, samples: Array, ends: Array) -> None:
    """Widen the ranges of the intervals at the positions `where` (n,), from `lowest` to `highest`, by the first n `samples`
    (rows, nodes), whose least and greatest are the `ends`."""
    width, ranges = bins
    while highest >= COUNT * width[0]:
        _double(width, ranges)
    unit = 1.0 / width[0]  # a power of two
    together = int(max(lowest * unit, 0.0)) == int(max(highest * unit, 0.0))
    for j in range(1 if together else where.size):
        row = ranges[int(max(where[j] * unit, 0.0))]
        for column in range(_ROWS):
            low, high = (ends[column], ends[_ROWS + column]) if together else (samples[column, j], samples[column, j])
            row[column], row[_ROWS + column] = min(row[column], low), max(row[_ROWS + column], high)


@njit
def _double(width: Array, ranges: Array) -> None:
    """Make the intervals twice as long."""
    width[0] *= 2.0
    for k in range(COUNT):
        for column in range(2 * _ROWS):
            sign = 1.0 if column < _ROWS else -1.0
            least = math.inf
            if 2 * k < COUNT:
                least = min(sign * ranges[2 * k, column], sign * ranges[2 * k + 1, column])
            ranges[k, column] = sign * least
