"""A slab on its staggered grid: the functions that the kernel calls, for elastic layers. Homogeneous slabs, for speed, and
viscous ones register their own versions.

Depth is travel time (transits of the upper slab) from the interface, so that waves have speed 1, and `u` is the velocity in the
slab's own direction of drive (u = w_1 above, u = -w_2 below). Both slabs then obey

    eps u_t = sigma_s,   sigma_t = eps u_s,   u_1 + u_2 = v at the interface   (MODEL.md section 3),

with u at the n + 1 nodes at half times and sigma (deviation from steady sliding) in the n cells at whole times; the end nodes
carry half a cell. Virieux (1986) describes the scheme in two dimensions; it is of order 2 and stable for dt <= dx.

    load        Z and S of  Z u + mu = S  at the interface, from its half cell's momentum balance; u is the mean over the step
    accelerate  advance velocities to the next half step, once u is known; returns the power of the outer face
    strain      advance stresses to the next whole step

Viscous slabs, both of order 2:
standard linear  sigma = sigma_r + q; the Maxwell branch q' = eps_1 u_s - q/time, eps_1 = eps ratio/(1 + ratio), follows the
                 trapezoidal rule cell by cell: equations are not coupled, and the step limit stays dt <= dx.
Kelvin-Voigt     sigma = sigma_e + eps time u_s. The viscous part is the mean of two half steps (Crank and Nicolson), a
                 tridiagonal system. It is eliminated from the outer face to the interface, where it gives (Z, S) as for other
                 slabs. It has no step limit of its own (an explicit scheme would need dt < dx^2/(2 time)), and each step
                 dissipates exactly sum c (du)^2 dt.
Stresses are deviations from that of steady sliding, which the spring that never relaxes carries.

Outer faces (MODEL.md section 3) are one row of the grid's momentum balance. The half cell at the face has the grid impedance Z =
eps dx/dt; its velocity w at a whole time is the mean of the two half steps around it. With the traction T on the face from
outside, the stress `pull` in the last cell, and the viscous coupling c (damping) to the node below (velocity u; c = 0 in an
elastic slab),

    Z (w - w_old) = T - pull - c (w - u)        so     w = alpha u + beta.

rigid   w is the drive's velocity.
grip    T = load + Z_g (V - w), load' = K (V - w): the load is the mean of its two half steps. This adds K dt/2 to Z_g, conserves
        the spring's energy and needs no smaller step, however stiff the spring is. With K = 0 the load is always the stress of
        steady sliding.

A mass on the face belongs to the half cell: it is part of Z (`grid.LeapfrogGrid`). Velocities are in V*; `mean` is the drive at
the whole time, `following` the drive at the next half step.
"""

from typing import Any, NamedTuple, TypeAlias

import numpy as np

from fullwave.leapfrog.grid import LeapfrogGrid
from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.slab import Slab

CHANGED = ("velocity", "stress", "relaxing", "lost", "memory")
"""Fields of media and faces that a march changes, for checkpoints."""


class Rigid(NamedTuple):
    """The drive moves the face itself."""

    stored: float = 0.0


class _Grip(NamedTuple):
    """Dashpot `impedance` Z_g, `half_spring` K dt/2, the spring's load in steady sliding, and `memory` (2,): the load's deviation
    from that at the half step, and the sum of the powers absorbed."""

    impedance: float
    half_spring: float
    steady_load: float
    memory: Array


@by_class(inline=True)
def _settle_face(
    face: Any, inertia: float, old: float, pull: float, damping: float, mean: float, following: float
) -> tuple[float, float]:
    """(alpha, beta) of the face's row for the grid impedance `inertia` and the velocity `old` half a step before."""
    resistance = face.impedance + face.half_spring
    total = inertia + resistance + damping
    return damping / total, (inertia * old - pull + face.memory[0] + resistance * mean) / total


@by_class(inline=True)
def _push(face: Any, traction: float, velocity: float, mean: float) -> float:
    """Power of the drive from the deviation `traction`; also advances a grip's spring to the next half step."""
    slip = mean - velocity
    lost = face.impedance * slip * slip
    face.memory[0] += 2.0 * face.half_spring * slip
    face.memory[1] += lost
    if face.half_spring == 0.0:
        return float(traction * velocity + lost - face.steady_load * slip)  # the dead load acts on the face itself
    return traction * mean


@_settle_face.register(Rigid)
def _settle_rigid(face, inertia, old, pull, damping, mean, following):  # type: ignore[no-untyped-def]
    return 0.0, 0.5 * (old + following)


@_push.register(Rigid)
def _push_rigid(face, traction, velocity, mean):  # type: ignore[no-untyped-def]
    return traction * velocity


def face_energy(face: Rigid | _Grip, steady_stress: float, step: float) -> tuple[float, float]:
    """(change of the spring's energy, radiated energy) of a face since t = 0, in units of sigma L / transit."""
    if isinstance(face, Rigid):
        return 0.0, 0.0
    stiffness, load = 2.0 * face.half_spring / step, float(face.memory[0])
    spring = load * (load + 2.0 * steady_stress) / (2.0 * stiffness) if stiffness > 0.0 else 0.0
    return spring, float(face.memory[1]) * step


Medium: TypeAlias = Any
"""An instance of _Uniform, _Layered, StandardLinear or KelvinVoigt."""


class _Uniform(NamedTuple):
    """Homogeneous elastic slab: u (n + 1,), sigma (n,), dt/(eps dx), eps dt/dx, grid impedance eps dx/dt of an end node."""

    velocity: Array
    stress: Array
    mobility: float
    stiffness: float
    inertia: float


class _Layered(NamedTuple):
    """Elastic slab of any layers: u, sigma, dt/mass (n + 1,), eps dt/dx (n,), grid impedances of the first and the last node."""

    velocity: Array
    stress: Array
    mobility: Array
    stiffness: Array
    inertia: float
    outer_inertia: float


class MarchedSlab(NamedTuple):
    """A marched slab; of alike slabs, which move antisymmetrically, only the upper one is marched."""

    medium: Medium
    face: Rigid | _Grip


@by_class(inline=True)
def load(medium: Medium, face: Rigid | _Grip, mean: float, following: float) -> tuple[float, float]:
    """(Z, S) of the interface's half cell, here from its momentum alone."""
    return medium.inertia, medium.stress[0] + medium.inertia * medium.velocity[0]


@by_class()
def accelerate(medium: Medium, face: Rigid | _Grip, rate: float, mean: float, following: float) -> float:
    """Advance velocities by one step, with u = `rate` at the interface; returns the drive's power without the steady stress."""
    velocity, stress, mobility = medium.velocity, medium.stress, medium.mobility
    n = stress.size
    velocity[0] = 2.0 * rate - velocity[0]
    for j in range(1, n):
        velocity[j] += mobility[j] * (stress[j] - stress[j - 1])
    old = velocity[n]
    _, top = _settle_face(face, medium.outer_inertia, old, stress[n - 1], 0.0, mean, following)
    velocity[n] = 2.0 * top - old
    return _push(face, stress[n - 1] + medium.outer_inertia * (top - old), top, mean)


@by_class()
def strain(medium: Medium) -> None:
    """Advance stresses by one step."""
    velocity, stress, stiffness = medium.velocity, medium.stress, medium.stiffness
    for j in range(stress.size):
        stress[j] += stiffness[j] * (velocity[j + 1] - velocity[j])


@accelerate.register(_Uniform)
def _accelerate_uniform(medium, face, rate, mean, following):  # type: ignore[no-untyped-def]
    velocity, stress = medium.velocity, medium.stress
    n = stress.size
    velocity[0] = 2.0 * rate - velocity[0]
    for j in range(1, n):
        velocity[j] += medium.mobility * (stress[j] - stress[j - 1])
    old = velocity[n]
    _, top = _settle_face(face, medium.inertia, old, stress[n - 1], 0.0, mean, following)
    velocity[n] = 2.0 * top - old
    return _push(face, stress[n - 1] + medium.inertia * (top - old), top, mean)


@strain.register(_Uniform)
def _strain_uniform(medium):  # type: ignore[no-untyped-def]
    velocity, stress = medium.velocity, medium.stress
    for j in range(stress.size):
        stress[j] += medium.stiffness * (velocity[j + 1] - velocity[j])


class StandardLinear(NamedTuple):
    """The fields of _Layered; the branch's stress `relaxing` q (n,), its eps_1 dt/dx (n,), dt/(2 time), the weights
    dx/(eps_1 time) of its losses (n,), and `lost` (1,), the sum of the dissipated powers."""

    velocity: Array
    stress: Array
    mobility: Array
    stiffness: Array
    inertia: float
    outer_inertia: float
    relaxing: Array
    branch: Array
    half_decay: float
    weight: Array
    lost: Array


class KelvinVoigt(NamedTuple):
    """Velocity, stress and stiffness as in _Layered; grid impedances of all nodes (n + 1,), damping c = eps time/dx (n,), the
    elimination's alpha and 1/pivot (n + 1,), its `beta` (n + 1,), and `lost` (1,) as in StandardLinear."""

    velocity: Array
    stress: Array
    stiffness: Array
    node_inertia: Array
    damping: Array
    alpha: Array
    pivot: Array
    beta: Array
    lost: Array


def _kelvin_voigt(grid: LeapfrogGrid, velocity: float, time: float, face: Rigid | _Grip) -> KelvinVoigt:
    """A slab that moves steadily at `velocity`, with prepared elimination; viscous `time` in transits."""
    n, inertia = grid.width.size, grid.inertia
    damping = grid.impedance * time / grid.width
    alpha, pivot = np.zeros(n + 1), np.zeros(n + 1)
    if isinstance(face, _Grip):
        alpha[n] = damping[-1] / (inertia[-1] + face.impedance + face.half_spring + damping[-1])
    for j in range(n - 1, 0, -1):
        pivot[j] = 1.0 / (inertia[j] + damping[j] * (1.0 - alpha[j + 1]) + damping[j - 1])
        alpha[j] = damping[j - 1] * pivot[j]
    fields = np.full(n + 1, velocity), np.zeros(n), grid.stiffness
    return KelvinVoigt(*fields, inertia, damping, alpha, pivot, np.zeros(n + 1), np.zeros(1))


def steady_side(scene: Scene, slab: Slab, grid: LeapfrogGrid) -> MarchedSlab:
    """A slab in steady sliding at the scene's initial velocity."""
    held = slab.termination.in_transits(scene.transit)
    face: Rigid | _Grip = Rigid()
    if not held.is_rigid:
        face = _Grip(held.dashpot, 0.5 * held.spring * grid.step, scene.steady_stress, np.zeros(2))
    velocity, solid = 0.5 * scene.velocity, slab.rheology
    if solid.blocks_fast_waves:
        return MarchedSlab(_kelvin_voigt(grid, velocity, solid.retardation / scene.transit, face), face)
    n, inertia = grid.width.size, grid.inertia
    ends = float(inertia[0]), float(inertia[-1])
    elastic = _Layered(np.full(n + 1, velocity), np.zeros(n), 2.0 / inertia, grid.stiffness, *ends)
    if solid.ratio == 0.0 and not grid.is_uniform:
        return MarchedSlab(elastic, face)
    if solid.ratio == 0.0:
        uniform = _Uniform(*elastic[:2], 0.5 * float(elastic.mobility[0]), float(elastic.stiffness[0]), elastic.inertia)
        return MarchedSlab(uniform, face)
    time, share = solid.relaxation / scene.transit, solid.ratio / (1.0 + solid.ratio)
    branch, decay = share * grid.stiffness, 0.5 * grid.step / time
    weight = grid.width / (share * grid.impedance * time)
    return MarchedSlab(StandardLinear(*elastic, np.zeros(n), branch, decay, weight, np.zeros(1)), face)


@strain.register(StandardLinear)
def _strain_standard_linear(medium):  # type: ignore[no-untyped-def]
    velocity, stress, relaxing = medium.velocity, medium.stress, medium.relaxing
    h = medium.half_decay
    lost = 0.0
    for j in range(stress.size):
        stretch = velocity[j + 1] - velocity[j]
        mean = (relaxing[j] + 0.5 * medium.branch[j] * stretch) / (1.0 + h)
        relaxing[j] = 2.0 * mean - relaxing[j]
        stress[j] += medium.stiffness[j] * stretch - 2.0 * h * mean
        lost += medium.weight[j] * mean * mean
    medium.lost[0] += lost


@load.register(KelvinVoigt)
def _load_kelvin_voigt(medium, face, mean, following):  # type: ignore[no-untyped-def]
    velocity, stress, beta, inertia, damping = medium.velocity, medium.stress, medium.beta, medium.node_inertia, medium.damping
    n = stress.size
    _, beta[n] = _settle_face(face, inertia[n], velocity[n], stress[n - 1], damping[n - 1], mean, following)
    for j in range(n - 1, 0, -1):
        known = inertia[j] * velocity[j] + stress[j] - stress[j - 1]
        beta[j] = (known + damping[j] * beta[j + 1]) * medium.pivot[j]
    impedance = inertia[0] + damping[0] * (1.0 - medium.alpha[1])
    return impedance, inertia[0] * velocity[0] + stress[0] + damping[0] * beta[1]


@accelerate.register(KelvinVoigt)
def _accelerate_kelvin_voigt(medium, face, rate, mean, following):  # type: ignore[no-untyped-def]
    velocity = medium.velocity
    n = medium.stress.size
    velocity[0] = 2.0 * rate - velocity[0]
    below = rate
    lost = 0.0
    pull = 0.0
    old = velocity[n]
    for j in range(1, n + 1):
        above = medium.alpha[j] * below + medium.beta[j]
        pull = medium.damping[j - 1] * (above - below)
        lost += pull * (above - below)
        velocity[j] = 2.0 * above - velocity[j]
        below = above
    medium.lost[0] += lost
    return _push(face, medium.stress[n - 1] + pull + medium.node_inertia[n] * (below - old), below, mean)
