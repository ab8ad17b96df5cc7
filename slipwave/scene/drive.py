"""The drive: the relative velocity of the two outer faces, V(t), split evenly (upper +V/2, lower -V/2)."""

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import njit

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drive:
    """Piecewise linear V(t): `velocities` (in V*) at `times` (transits), constant before the first and after the last."""

    times: tuple[float, ...]
    velocities: tuple[float, ...]

    @property
    def is_constant(self) -> bool:
        """True when V never changes, so that solvers may skip everything that depends on it."""
        return len(set(self.velocities)) == 1

    def rests_from(self, time: float) -> bool:
        """Whether V is constant from `time` (transits) on, and not zero."""
        here = self.at(time)
        return here != 0.0 and all(v == here for t, v in zip(self.times, self.velocities, strict=True) if t > time)

    def knots(self) -> tuple[Array, Array]:
        """(times, velocities) as arrays for compiled solvers; one knot if V never changes."""
        kept = 1 if self.is_constant else len(self.times)
        return np.array(self.times[:kept], dtype=float), np.array(self.velocities[:kept], dtype=float)

    @property
    def initial(self) -> float:
        """V at and before t = 0: the rate of the steady sliding that every start builds on."""
        return self.at(0.0)

    def at(self, time: float) -> float:
        """V (in V*) at `time` (transits)."""
        if time <= self.times[0]:
            return self.velocities[0]
        if time >= self.times[-1]:
            return self.velocities[-1]
        k = bisect_right(self.times, time)
        share = (time - self.times[k - 1]) / (self.times[k] - self.times[k - 1])
        return self.velocities[k - 1] + share * (self.velocities[k] - self.velocities[k - 1])


def steady_drive(velocity: float) -> Drive:
    """Constant V."""
    return Drive((0.0,), (velocity,))


@njit
def interpolate_drive(times: Array, velocities: Array, time: float) -> float:
    """V (in V*) at `time` (transits) for compiled solvers, from the arrays of a `Drive` with at least two knots."""
    k = 1
    while k < times.size - 1 and times[k] < time:
        k += 1
    share = (time - times[k - 1]) / (times[k] - times[k - 1])
    return float(velocities[k - 1] + min(1.0, max(0.0, share)) * (velocities[k] - velocities[k - 1]))
