"""Outer faces of a slab on the leapfrog's grid (MODEL.md section 3), all as one row of the grid's momentum balance.

The half cell at the face has the grid impedance Z = eps dx/dt; its velocity w at a whole time is the mean of the two half steps
around it. With the traction T on the face from outside, the stress `pull` in the last cell, and the viscous coupling c (damping)
to the node below (velocity u; c = 0 in an elastic slab),

    Z (w - w_old) = T - pull - c (w - u)        so     w = alpha u + beta.

rigid   w is the drive's velocity.
grip    T = load + Z_g (V - w), load' = K (V - w): the load is the mean of its two half steps. This adds K dt/2 to Z_g, conserves
        the spring's energy and needs no smaller step, however stiff the spring is. With K = 0 the load is always the stress of
        steady sliding.

A mass on the face belongs to the half cell: it is part of Z (`grid.LeapfrogGrid`).
Stresses are deviations from the stress of steady sliding, in units of the normal stress; velocities are in V*; `mean` is the
drive at the whole time, `following` the drive at the next half step; time is in transits.
"""

from typing import Any, NamedTuple

import numpy as np

from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array
from slipwave.scene.slab import Termination


class Rigid(NamedTuple):
    """The drive moves the face itself."""

    stored: float = 0.0


class Grip(NamedTuple):
    """Dashpot `impedance` Z_g, `half_spring` K dt/2, the spring's load in steady sliding, and `memory` (2,): the load's deviation
    from that at the half step, and the sum of the powers absorbed."""

    impedance: float
    half_spring: float
    steady_load: float
    memory: Array


@by_class(inline=True)
def settle_face(
    face: Any, inertia: float, old: float, pull: float, damping: float, mean: float, following: float
) -> tuple[float, float]:
    """(alpha, beta) of the face's row for the grid impedance `inertia` and the velocity `old` half a step before."""
    resistance = face.impedance + face.half_spring
    total = inertia + resistance + damping
    return damping / total, (inertia * old - pull + face.memory[0] + resistance * mean) / total


@by_class(inline=True)
def push(face: Any, traction: float, velocity: float, mean: float) -> float:
    """Power of the drive from the deviation `traction`; also advances a grip's spring to the next half step."""
    slip = mean - velocity
    lost = face.impedance * slip * slip
    face.memory[0] += 2.0 * face.half_spring * slip
    face.memory[1] += lost
    if face.half_spring == 0.0:
        return float(traction * velocity + lost - face.steady_load * slip)  # the dead load acts on the face itself
    return traction * mean


@settle_face.register(Rigid)
def _settle_rigid(face, inertia, old, pull, damping, mean, following):  # type: ignore[no-untyped-def]
    return 0.0, 0.5 * (old + following)


@push.register(Rigid)
def _push_rigid(face, traction, velocity, mean):  # type: ignore[no-untyped-def]
    return traction * velocity


def coupling(face: Rigid | Grip, inertia: float, damping: float) -> float:
    """alpha of the face's row."""
    return 0.0 if isinstance(face, Rigid) else damping / (inertia + face.impedance + face.half_spring + damping)


def face_energy(face: Rigid | Grip, steady_stress: float, step: float) -> tuple[float, float]:
    """(change of the spring's energy, radiated energy) of a face since t = 0, in units of sigma L / transit."""
    if isinstance(face, Rigid):
        return 0.0, 0.0
    stiffness, load = 2.0 * face.half_spring / step, float(face.memory[0])
    spring = load * (load + 2.0 * steady_stress) / (2.0 * stiffness) if stiffness > 0.0 else 0.0
    return spring, float(face.memory[1]) * step


def compiled_face(held: Termination, step: float, steady_stress: float) -> Rigid | Grip:
    """The kernel's form of an outer face; `held` and the time step `step` in transits."""
    if held.is_rigid:
        return Rigid()
    return Grip(held.dashpot, 0.5 * held.spring * step, steady_stress, np.zeros(2))
