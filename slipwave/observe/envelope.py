"""Ranges of slip rate and friction stress over up to 4096 equal intervals of a run, for figures; memory of fixed size."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from slipwave.compiled import njit
from slipwave.friction import rates
from slipwave.observe.pieces import SAME, Array, Pieces
from slipwave.scene import Scene

COUNT = 4096
"""Intervals, at most; a figure is a thousand pixels wide."""

_UNREAD = 1 << 19  # samples, 24 MB
_FIRST = 2.0**-10  # length of an interval at first, in transits or in L of slip
_ROWS = _TIME, _SLIP, _Z, _MU = range(4)
_EMPTY = np.stack([np.full((len(_ROWS), COUNT), np.inf), np.full((len(_ROWS), COUNT), -np.inf)])

Ranges: TypeAlias = tuple[Array, Array]
"""The least and the greatest values in each interval."""


class Shown(NamedTuple):
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
        self._bins = _Bins(), _Bins()
        self._reached, self._origin = 0.0, math.nan
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
        for reached, pieces in self._unread:
            self._take(reached, pieces)
        self._unread.clear()

    def _take(self, reached: float, pieces: Pieces) -> None:
        """Add pieces after the time `reached`. After a gap, and in intervals longer than a transit, all samples of a transit go
        to one interval, even if the next ones stay empty: a part of a transit has another range."""
        time = pieces.time[:, None] + pieces.length[:, None] * self._nodes
        inside = (time >= self._begin) & (time <= self._end)
        if not inside.any():
            return
        pick = np.ravel if inside.all() else lambda values: values[inside]
        transit = pick(np.broadcast_to(np.floor(pieces.time + SAME)[:, None], time.shape))
        time, z, mu, y = (pick(values) for values in (time, pieces.z, pieces.mu, pieces.y))
        slip = self._scene.transit * (self._scene.drive.travel(time) - y / self._scene.stiffness)
        self._origin = float(slip[0]) if math.isnan(self._origin) else self._origin
        samples = time, slip - self._origin, z, mu
        by_time, by_slip = self._bins
        by_time.add(np.maximum(transit - self._begin, 0.0) if by_time.width >= 1.0 else time - self._begin, samples)
        gaps = (pieces.time > np.append(reached, pieces.time[:-1] + pieces.length[:-1]) + 0.5).any()
        by_slip.add(samples[_SLIP][np.searchsorted(transit, transit)] if gaps else samples[_SLIP], samples)

    def by_time(self) -> Shown:
        """The motion so far over equal intervals of time."""
        self._read()
        return self._shown(self._bins[0])

    def by_slip(self) -> Shown:
        """The motion so far over equal intervals of slip."""
        self._read()
        return self._shown(self._bins[1])

    def _shown(self, bins: "_Bins") -> Shown:
        low, high = bins.ranges[:, :, np.isfinite(bins.ranges[0, 0])]
        rate = rates(self._scene.law, low[_Z]), rates(self._scene.law, high[_Z])
        return Shown(high[_TIME], high[_SLIP], rate, (low[_MU], high[_MU]))

    def state(self) -> dict[str, Array]:
        """The ranges so far, for a checkpoint."""
        self._read()
        tables = {f"ranges{n}": np.concatenate([*bins.ranges]) for n, bins in enumerate(self._bins)}
        widths = [bins.width for bins in self._bins]
        return {"numbers": np.array([self._begin, self._end, self._reached, self._origin, *widths]), **tables}

    def restore(self, state: dict[str, Array]) -> None:
        """Continue from what `state` returned. Raises ValueError if it is of another window."""
        self._unread.clear()
        begin, end, self._reached, self._origin, *widths = state["numbers"].tolist()
        if (begin, end) != (self._begin, self._end):
            raise ValueError(f"the window is {begin:g}:{end:g}; this run asks for {self._begin:g}:{self._end:g}")
        by_time, by_slip = (_Bins(width, np.array(np.split(state[f"ranges{n}"], 2))) for n, width in enumerate(widths))
        self._bins = by_time, by_slip


class _Bins:
    """`ranges` (low and high, rows, intervals) of samples over intervals `width` long."""

    def __init__(self, width: float = _FIRST, ranges: Array = _EMPTY) -> None:
        self.width, self.ranges = width, ranges.copy()

    def add(self, positions: Array, samples: tuple[Array, ...]) -> None:
        """Add the samples of all rows, (n,) each, at `positions` (n,) >= 0, which usually rise."""
        while positions.max() >= COUNT * self.width:
            left, right = self.ranges[:, :, ::2], self.ranges[:, :, 1::2]
            halves = np.stack([np.minimum(left[0], right[0]), np.maximum(left[1], right[1])])
            self.ranges, self.width = np.concatenate([halves, _EMPTY[:, :, COUNT // 2 :]], axis=2), 2.0 * self.width
        for lowest, highest, values in zip(*self.ranges, samples, strict=True):
            _widen(lowest, highest, positions, self.width, values)


@njit
def _widen(lowest: Array, highest: Array, positions: Array, width: float, values: Array) -> None:
    """Widen the ranges of the intervals of length `width` by `values` (n,) at `positions`."""
    for i in range(positions.size):
        k = int(max(positions[i] / width, 0.0))
        lowest[k] = min(lowest[k], values[i])
        highest[k] = max(highest[k], values[i])
