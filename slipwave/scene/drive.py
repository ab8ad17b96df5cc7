"""The drive, and the start of a run.

The drive is the relative velocity of the two outer faces, V(t), split evenly (upper +V/2, lower -V/2). Every start builds on
steady sliding at its initial velocity.

nudge  smooth: d psi/dt~ gains size * exp(-(t~ - 6)^2), t~ in transits of the upper slab. Every scheme keeps its full order.
jump   psi(0) = psi_ss + size with no wave in the slabs: breaks compatibility; the jump's echoes never end (MODEL.md section 7).
orbit  on the model's own periodic orbit, at the date of a slip event.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from slipwave.compiled import inlined
from slipwave.compiled.dispatch import by_class

Array = NDArray[np.float64]

NUDGE_CENTRE = 6.0
"""Transits at which the nudge peaks; at t~ = 0 it is size * e^-36."""

NUDGE_REACH = 7.0
"""Outside NUDGE_CENTRE +- this many transits the nudge is below size * 6e-22 and is set to 0."""


class Constant(NamedTuple):
    """Constant V (in V*)."""

    velocity: float


class Ramps(NamedTuple):
    """Piecewise linear V: `velocities` (V*) at `times` (transits, rising; twice the same time is a step), constant outside."""

    times: Array
    velocities: Array


@by_class(inline=True)
def velocity_at(drive: Any, time: float, within: float) -> float:
    """V (in V*) at `time` (transits), on the straight stretch of V that contains `within`.

    With the middle of a step as `within`, V at the step's end is that before a jump there, whatever the rounding of `time`. With
    `within` = `time`, V at a jump is that after it.
    """
    return float(_interpolated(drive.times, drive.velocities, time, within))


@velocity_at.register(Constant)
def _constant(drive, time, within):  # type: ignore[no-untyped-def]
    return drive.velocity


@register_jitable
def _interpolated(times, velocities, time, within):  # type: ignore[no-untyped-def]
    low = _stretch(times, within)
    if low < 0:
        return velocities[0]
    if low == times.size - 1:
        return velocities[-1]
    share = (time - times[low]) / (times[low + 1] - times[low])
    return velocities[low] + share * (velocities[low + 1] - velocities[low])


@register_jitable
def _stretch(times, within):  # type: ignore[no-untyped-def]
    """Number of the last knot at or before `within`; -1 before the first."""
    low, count = -1, times.size  # of the knots that may be it, that before the first among them, and number of the others
    while count > 0:
        half = (count + 1) // 2
        if times[low + half] <= within:
            low += half
            count -= half
        else:
            count = half - 1
    return low


@by_class(inline=True)
def side_of(drive: Any, time: float, middle: float) -> float:
    """`within` for `velocity_at` at a `time` of a step: its `middle` if V jumps between both, so that a whole step has V of one
    side of a jump."""
    first, last = _stretch(drive.times, min(time, middle)), _stretch(drive.times, max(time, middle))
    for knot in range(first + 1, last):
        if drive.times[knot] == drive.times[knot + 1]:
            return middle
    return time


@side_of.register(Constant)
def _of_constant(drive, time, middle):  # type: ignore[no-untyped-def]
    return time


@dataclass(frozen=True)
class Drive:
    """Piecewise linear V(t): `velocities` (in V*) at `times` (transits, from 0 on), constant before the first and after the last.

    A time that is given twice is a step: V jumps there from the first of its velocities to the second.
    """

    times: tuple[float, ...]
    velocities: tuple[float, ...]
    terms: ClassVar[int] = 2
    """Number of terms of V, a polynomial, between two knots."""

    @cached_property
    def is_constant(self) -> bool:
        """True if V never changes, so that solvers may skip everything that depends on changes of V."""
        return len(set(self.velocities)) == 1

    @cached_property
    def knots(self) -> tuple[float, ...]:
        """Times (transits) at which V may have a kink or a jump; none if V is constant."""
        return () if self.is_constant else tuple(dict.fromkeys(self.times))

    def knot_after(self, time: float) -> float:
        """The first knot after `time` (transits); infinite if there is none."""
        following = bisect_right(self.knots, time)
        return self.knots[following] if following < len(self.knots) else math.inf

    @cached_property
    def compiled(self) -> Constant | Ramps:
        """V as data for compiled code."""
        if self.is_constant:
            return Constant(float(self.velocities[0]))
        return Ramps(np.array(self.times, dtype=float), np.array(self.velocities, dtype=float))

    def rests_from(self, time: float) -> bool:
        """Whether V is constant from `time` (transits) on, and not zero."""
        here = self.at(time)
        return here != 0.0 and all(v == here for t, v in zip(self.times, self.velocities, strict=True) if t > time)

    @property
    def initial(self) -> float:
        """V before t = 0: the rate of the steady sliding that every start builds on."""
        return self.velocities[0]

    def at(self, time: float) -> float:
        """V (in V*) at `time` (transits); at a jump, V after it."""
        return float(velocity_at(self.compiled, time, time))

    def travel(self, times: Array) -> Array:
        """The integral of V (in V*) from its first knot to `times` (transits)."""
        if self.is_constant:
            return self.initial * (times - self.times[0])
        knots, paces, gains, passed = self.travelled
        here = np.maximum(np.searchsorted(knots, times, side="right") - 1, 0)
        since = times - knots[here]
        return np.asarray(passed[here] + since * (paces[here] + 0.5 * gains[here] * np.maximum(since, 0.0)))

    @cached_property
    def travelled(self) -> tuple[Array, Array, Array, Array]:
        """The integral of V: times of the knots (transits), V there (V*), its growth after each (V* per transit), and the
        integral before it."""
        knots, paces = np.array(self.times), np.array(self.velocities)
        lasts, rise = np.append(np.diff(knots), 1.0), np.append(np.diff(paces), 0.0)
        gains = np.divide(rise, lasts, out=np.zeros_like(rise), where=lasts > 0.0)
        return knots, paces, gains, np.concatenate(([0.0], np.cumsum(lasts * (paces + 0.5 * rise))))


def steady_drive(velocity: float) -> Drive:
    """Constant V."""
    return Drive((0.0,), (velocity,))


class StartKind(StrEnum):
    """The registered starts; values are the scene file's words."""

    NUDGE = "nudge"
    JUMP = "jump"
    ORBIT = "orbit"


@dataclass(frozen=True)
class Start:
    """Kind, and size of the disturbance of psi (with `orbit` only used to leave steady sliding while the orbit is computed)."""

    kind: StartKind = StartKind.NUDGE
    size: float = 0.5

    @property
    def nudge_size(self) -> float:
        """Amplitude of the nudge of psi (0 for a jump)."""
        return 0.0 if self.kind is StartKind.JUMP else self.size

    @property
    def jump_size(self) -> float:
        """psi(0) - psi_ss (0 unless the start is a jump)."""
        return self.size if self.kind is StartKind.JUMP else 0.0


@inlined
def nudge_rate(size: float, time: float) -> float:
    """The contribution of the nudge to d psi/dt~ at `time` (transits)."""
    late = time - NUDGE_CENTRE
    return size * math.exp(-late * late) if size != 0.0 and abs(late) < NUDGE_REACH else 0.0


class Forcing(NamedTuple):
    """Numbers of a scene for compiled marches: one `transit` on the friction clock L/V*, `stiffness` of both slabs per transit,
    stress and slip rate V_0 (in V*) of steady sliding, and the size of the `nudge`."""

    transit: float
    stiffness: float
    steady_stress: float
    velocity: float
    nudge: float
