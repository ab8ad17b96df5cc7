"""Energy balance and fields of the leapfrog's grid.

With u at n + 1/2 and sigma at n the scheme conserves sum m u^2/2 + sum dx sigma^n sigma^(n+1)/(2 eps) exactly, so the energy
balance (per unit area, in units of sigma L, since t = 0) closes to rounding. The kernel only sums the powers of drive, friction,
dashpots and viscosity; the stored energy is computed here. Stresses are stored as deviations from steady sliding, whose stress
enters separately, without cancellation. Fields are interpolated to common times and depths.
"""

import numpy as np

from fullwave.leapfrog.faces import Rigid, face_energy
from fullwave.leapfrog.grid import LeapfrogGrid
from fullwave.leapfrog.kernel import FRICTION, INPUT, RATE, STRESS, Z
from fullwave.leapfrog.media import Side
from fullwave.leapfrog.viscous import KelvinVoigt, StandardLinear
from fullwave.slabs import both_slabs
from slipwave.friction import rate_of
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import Energy, SlabSnapshot, Snapshot


def energy_of(scene: Scene, memory: Array, sides: list[tuple[Side, LeapfrogGrid]]) -> Energy:
    """Energy balance of `sides`; an only one, which stands for both, counts twice."""
    sums = [_side_energy(side, grid, scene.steady_stress, 0.5 * scene.velocity) for side, grid in sides]
    copies = 3 - len(sides)
    stored, radiated, viscous = (copies * sum(column) for column in zip(*sums, strict=True))
    unit = scene.transit
    spent = unit * sides[0][1].step
    return Energy(
        input=float(spent * memory[INPUT]),
        friction=float(spent * memory[FRICTION]),
        radiated=unit * radiated,
        viscous=unit * viscous,
        stored=unit * stored,
    )


def _side_energy(side: Side, grid: LeapfrogGrid, steady_stress: float, velocity: float) -> tuple[float, float, float]:
    """(change of stored energy, radiated energy, energy lost to viscosity) of a slab, in units of sigma L / transit."""
    medium, face = side
    stretch = np.diff(medium.velocity)
    kinetic = 0.5 * float(grid.mass @ ((medium.velocity - velocity) * (medium.velocity + velocity)))
    relaxed, ahead, compliance = medium.stress, medium.stress + grid.stiffness * stretch, grid.width / (2.0 * grid.impedance)
    branch, viscous = 0.0, float(medium.lost[0]) * grid.step if isinstance(medium, StandardLinear | KelvinVoigt) else 0.0
    if isinstance(medium, StandardLinear):
        q, unrelaxed = medium.relaxing, medium.branch / grid.stiffness
        mean = (q + 0.5 * medium.branch * stretch) / (1.0 + medium.half_decay)
        q_ahead = 2.0 * mean - q
        branch = float((compliance / unrelaxed) @ (q * q_ahead))
        viscous += 0.5 * grid.step * float(medium.weight @ (q * mean))
        relaxed = medium.stress - q
        ahead = ahead - 2.0 * medium.half_decay * mean - q_ahead
        compliance = compliance / (1.0 - unrelaxed)
    elastic = float(compliance @ (relaxed * ahead + steady_stress * (relaxed + ahead)))
    spring, radiated = face_energy(face, steady_stress, grid.step)
    return kinetic + elastic + branch + spring, radiated, viscous


def leapfrog_snapshot(scene: Scene, time: float, memory: Array, sides: list[Side], grids: list[LeapfrogGrid]) -> Snapshot:
    """Velocity and stress at the nodes at the whole time `time`, of second order in the cell."""
    stress, rate = float(memory[STRESS]) - scene.steady_stress, float(memory[RATE])
    drive = 0.5 * scene.drive.at(time)
    rates = rate, rate_of(scene.law, float(memory[Z])) - rate
    shots = [_slab(side, grid, stress, own, drive) for side, grid, own in zip(sides, grids, rates, strict=False)]
    return both_slabs(scene, time, [SlabSnapshot(shot.depth, shot.velocity, shot.stress + scene.steady_stress) for shot in shots])


def _slab(side: Side, grid: LeapfrogGrid, interface_stress: float, rate: float, drive: float) -> SlabSnapshot:
    """Fields of a slab: the deviation of the stress from steady sliding, and the velocity in the slab's own direction."""
    velocity, stress = _at_whole_time(side, grid, interface_stress, rate)
    if isinstance(side.face, Rigid):
        velocity[-1] = drive
    elif not isinstance(side.medium, KelvinVoigt):
        velocity[-1] = _beyond(velocity[:-1])
    weight = grid.impedance * grid.width
    between = (weight[1:] * stress[:-1] + weight[:-1] * stress[1:]) / (weight[1:] + weight[:-1])
    outermost = _beyond(np.array([between[-1], stress[-1]])) if between.size else stress[-1]
    at_nodes = np.concatenate(([interface_stress], between, [outermost]))
    return SlabSnapshot(grid.depth / grid.depth[-1], velocity, at_nodes)


def _at_whole_time(side: Side, grid: LeapfrogGrid, interface_stress: float, rate: float) -> tuple[Array, Array]:
    """Velocities at the nodes (except the outermost) and total stresses in the cells."""
    medium = side.medium
    velocity = medium.velocity.copy()
    velocity[0] = rate
    if isinstance(medium, KelvinVoigt):
        for j in range(1, velocity.size):
            velocity[j] = medium.alpha[j] * velocity[j - 1] + medium.beta[j]
        return velocity, medium.stress + medium.damping * np.diff(velocity)
    velocity[1:-1] -= np.diff(medium.stress) / grid.inertia[1:-1]
    return velocity, medium.stress


def _beyond(values: Array) -> float:
    """The next value of a smooth equidistant sequence, extrapolated from its last two or three."""
    if values.size < 3:
        return float(2.0 * values[-1] - values[-2]) if values.size > 1 else float(values[-1])
    return float(3.0 * (values[-1] - values[-2]) + values[-3])
