"""A slab on its staggered grid: the functions that the kernel calls, for elastic layers. Other media register their own versions:
homogeneous slabs here, for speed, viscous ones in `viscous`.

Depth is travel time (transits of the upper slab) from the interface, so that waves have speed 1, and `u` is the velocity in the
slab's own direction of drive (u = w_1 above, u = -w_2 below). Both slabs then obey

    eps u_t = sigma_s,   sigma_t = eps u_s,   u_1 + u_2 = v at the interface   (MODEL.md section 3),

with u at the n + 1 nodes at half times and sigma (deviation from steady sliding) in the n cells at whole times; the end nodes
carry half a cell. Virieux (1986) describes the scheme in two dimensions; it is of order 2 and stable for dt <= dx.

    load        Z and S of  Z u + mu = S  at the interface, from its half cell's momentum balance; u is the mean over the step
    accelerate  advance velocities to the next half step, once u is known; returns the power of the outer face
    strain      advance stresses to the next whole step
"""

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from fullwave.leapfrog.faces import Grip, Rigid, push, settle_face
from fullwave.leapfrog.grid import LeapfrogGrid
from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array

CHANGED = ("velocity", "stress", "relaxing", "lost", "memory")
"""Fields of media and faces that a march changes, for checkpoints."""

Medium: TypeAlias = Any
"""An instance of Uniform, Layered, StandardLinear or KelvinVoigt."""


class Uniform(NamedTuple):
    """Homogeneous elastic slab: u (n + 1,), sigma (n,), dt/(eps dx), eps dt/dx, grid impedance eps dx/dt of an end node."""

    velocity: Array
    stress: Array
    mobility: float
    stiffness: float
    inertia: float


class Layered(NamedTuple):
    """Elastic slab of any layers: u, sigma, dt/mass (n + 1,), eps dt/dx (n,), grid impedances of the first and the last node."""

    velocity: Array
    stress: Array
    mobility: Array
    stiffness: Array
    inertia: float
    outer_inertia: float


class Side(NamedTuple):
    """A marched slab; of alike slabs, which move antisymmetrically, only the upper one is marched."""

    medium: Medium
    face: Rigid | Grip


def layered_medium(grid: LeapfrogGrid, velocity: float) -> Layered:
    """A slab of any layers that moves steadily at `velocity`."""
    n, inertia = grid.width.size, grid.inertia
    ends = float(inertia[0]), float(inertia[-1])
    return Layered(np.full(n + 1, velocity), np.zeros(n), 2.0 / inertia, grid.stiffness, *ends)


def elastic_medium(grid: LeapfrogGrid, velocity: float) -> Uniform | Layered:
    """A slab that moves steadily at `velocity`."""
    layered = layered_medium(grid, velocity)
    if not grid.is_uniform:
        return layered
    return Uniform(*layered[:2], 0.5 * float(layered.mobility[0]), float(layered.stiffness[0]), layered.inertia)


@by_class(inline=True)
def load(medium: Medium, face: Rigid | Grip, mean: float, following: float) -> tuple[float, float]:
    """(Z, S) of the interface's half cell, here from its momentum alone."""
    return medium.inertia, medium.stress[0] + medium.inertia * medium.velocity[0]


@by_class()
def accelerate(medium: Medium, face: Rigid | Grip, rate: float, mean: float, following: float) -> float:
    """Advance velocities by one step, with u = `rate` at the interface; returns the drive's power without the steady stress."""
    velocity, stress, mobility = medium.velocity, medium.stress, medium.mobility
    n = stress.size
    velocity[0] = 2.0 * rate - velocity[0]
    for j in range(1, n):
        velocity[j] += mobility[j] * (stress[j] - stress[j - 1])
    old = velocity[n]
    _, top = settle_face(face, medium.outer_inertia, old, stress[n - 1], 0.0, mean, following)
    velocity[n] = 2.0 * top - old
    return push(face, stress[n - 1] + medium.outer_inertia * (top - old), top, mean)


@by_class()
def strain(medium: Medium) -> None:
    """Advance stresses by one step."""
    velocity, stress, stiffness = medium.velocity, medium.stress, medium.stiffness
    for j in range(stress.size):
        stress[j] += stiffness[j] * (velocity[j + 1] - velocity[j])


@accelerate.register(Uniform)
def _accelerate_uniform(medium, face, rate, mean, following):  # type: ignore[no-untyped-def]
    velocity, stress = medium.velocity, medium.stress
    n = stress.size
    velocity[0] = 2.0 * rate - velocity[0]
    for j in range(1, n):
        velocity[j] += medium.mobility * (stress[j] - stress[j - 1])
    old = velocity[n]
    _, top = settle_face(face, medium.inertia, old, stress[n - 1], 0.0, mean, following)
    velocity[n] = 2.0 * top - old
    return push(face, stress[n - 1] + medium.inertia * (top - old), top, mean)


@strain.register(Uniform)
def _strain_uniform(medium):  # type: ignore[no-untyped-def]
    velocity, stress = medium.velocity, medium.stress
    for j in range(stress.size):
        stress[j] += medium.stiffness * (velocity[j + 1] - velocity[j])
