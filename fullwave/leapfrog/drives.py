"""The drive's total velocity V(t) as compiled code: a constant costs nothing, ramps are searched from their first
knot at every call."""

from typing import NamedTuple

import numpy as np

from slipwave.compiled.dispatch import dispatch
from slipwave.observe.pieces import Array
from slipwave.scene.drive import Drive


class Constant(NamedTuple):
    """V (in V*) that never changes."""

    velocity: float


class Ramps(NamedTuple):
    """Piecewise linear V: `velocities` (V*) at `times` (transits), constant outside."""

    times: Array
    velocities: Array


def velocity_at(drive: Constant | Ramps, time: float) -> float:
    """V (in V*) at `time` (transits)."""
    raise NotImplementedError(type(drive))


def _constant(drive, time):  # type: ignore[no-untyped-def]
    return drive.velocity


def _ramps(drive, time):  # type: ignore[no-untyped-def]
    last = drive.times.size - 1
    if time <= drive.times[0]:
        return drive.velocities[0]
    if time >= drive.times[last]:
        return drive.velocities[last]
    k = 1
    while drive.times[k] <= time:
        k += 1
    share = (time - drive.times[k - 1]) / (drive.times[k] - drive.times[k - 1])
    return drive.velocities[k - 1] + share * (drive.velocities[k] - drive.velocities[k - 1])


dispatch(velocity_at, {Constant: _constant, Ramps: _ramps}, inline=True)


def compiled_drive(drive: Drive) -> Constant | Ramps:
    """The kernel's form of a scene's drive."""
    if drive.is_constant:
        return Constant(float(drive.initial))
    return Ramps(np.array(drive.times, dtype=float), np.array(drive.velocities, dtype=float))
