"""The drive: the relative velocity of the two outer faces, V(t), split evenly (upper +V/2, lower -V/2)."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from slipwave.compiled.dispatch import by_class

Array = NDArray[np.float64]


class Constant(NamedTuple):
    """V (in V*) that never changes."""

    velocity: float


class Ramps(NamedTuple):
    """Piecewise linear V: `velocities` (V*) at `times` (transits, rising), constant outside."""

    times: Array
    velocities: Array


@by_class(inline=True)
def velocity_at(drive: Constant | Ramps, time: float) -> float:
    """V (in V*) at `time` (transits)."""
    raise NotImplementedError(type(drive))


@velocity_at.register(Constant)
def _constant(drive, time):  # type: ignore[no-untyped-def]
    return drive.velocity


@velocity_at.register(Ramps)
def _ramps(drive, time):  # type: ignore[no-untyped-def]
    return _interpolated(drive.times, drive.velocities, time)


@register_jitable
def _interpolated(times, velocities, time):  # type: ignore[no-untyped-def]
    if time >= times[-1]:
        return velocities[-1]
    low, count = 0, times.size - 1  # first and number of the stretches that may contain `time`
    while count > 1:
        half = count // 2
        low += half if times[low + half] <= time else 0
        count -= half
    share = max(0.0, (time - times[low]) / (times[low + 1] - times[low]))
    return velocities[low] + share * (velocities[low + 1] - velocities[low])


@dataclass(frozen=True)
class Drive:
    """Piecewise linear V(t): `velocities` (in V*) at `times` (transits), constant before the first and after the last."""

    times: tuple[float, ...]
    velocities: tuple[float, ...]

    @property
    def is_constant(self) -> bool:
        """True if V never changes, so that solvers may skip everything that depends on changes of V."""
        return len(set(self.velocities)) == 1

    @property
    def knots(self) -> tuple[float, ...]:
        """Times (transits) at which V may have a kink; none if V is constant."""
        return () if self.is_constant else self.times

    @cached_property
    def compiled(self) -> Constant | Ramps:
        """V in the form for compiled code, where a constant costs nothing."""
        if self.is_constant:
            return Constant(float(self.velocities[0]))
        return Ramps(np.array(self.times, dtype=float), np.array(self.velocities, dtype=float))

    def rests_from(self, time: float) -> bool:
        """Whether V is constant from `time` (transits) on, and not zero."""
        here = self.at(time)
        return here != 0.0 and all(v == here for t, v in zip(self.times, self.velocities, strict=True) if t > time)

    @property
    def initial(self) -> float:
        """V at and before t = 0: the rate of the steady sliding that every start builds on."""
        return self.at(0.0)

    def at(self, time: float) -> float:
        """V (in V*) at `time` (transits)."""
        return float(velocity_at(self.compiled, time))


def steady_drive(velocity: float) -> Drive:
    """Constant V."""
    return Drive((0.0,), (velocity,))
