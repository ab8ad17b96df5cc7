"""Fields of the leapfrog at common times and places; it stores velocities half a step later and stresses half a cell away."""

import numpy as np

from fullwave.leapfrog.faces import Rigid
from fullwave.leapfrog.grid import LeapfrogGrid
from fullwave.leapfrog.kernel import RATE, STRESS, Z
from fullwave.leapfrog.sides import Side
from fullwave.leapfrog.viscous import KelvinVoigt
from slipwave.friction import rate_of
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import SlabSnapshot, Snapshot


def snapshot_of(scene: Scene, time: float, memory: Array, sides: list[Side], grids: list[LeapfrogGrid]) -> Snapshot:
    """Velocity and stress at the nodes at the whole time `time`, of second order in the cell."""
    stress, rate = float(memory[STRESS]) - scene.steady_stress, float(memory[RATE])
    drive = 0.5 * scene.drive.at(time)
    shots = [_slab(sides[0], grids[0], stress, rate, drive)]
    if not scene.alike:
        shots.append(_slab(sides[1], grids[1], stress, rate_of(scene.law, float(memory[Z])) - rate, drive))
    upper, lower = (SlabSnapshot(shot.depth, shot.velocity, shot.stress + scene.steady_stress) for shot in (shots[0], shots[-1]))
    return Snapshot(time, upper, SlabSnapshot(lower.depth, -lower.velocity, lower.stress))


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
    """The next value of a smooth equidistant sequence, from its last two or three."""
    if values.size < 3:
        return float(2.0 * values[-1] - values[-2]) if values.size > 1 else float(values[-1])
    return float(3.0 * (values[-1] - values[-2]) + values[-3])
