"""Fields of the leapfrog at one time and place: velocities are held half a step late and stresses half a cell off the nodes."""

import numpy as np

from fullwave.leapfrog.grid import Grid
from fullwave.leapfrog.kernel import STRESS, Clock, Side
from fullwave.snapshot import SlabSnapshot, Snapshot
from scene.observe.pieces import Array
from scene.scene import Scene


def snapshot_of(scene: Scene, time: float, clock: Clock, memory: Array, sides: list[Side], grids: list[Grid]) -> Snapshot:
    """Velocity and stress at the nodes at the whole time `time`, second order in the cell."""
    upper = _slab(sides[0], grids[0], clock, float(memory[STRESS]))
    other = upper if scene.alike else _slab(sides[1], grids[1], clock, float(memory[STRESS]))
    return Snapshot(time, upper, SlabSnapshot(other.depth, -other.velocity, other.stress))


def _slab(side: Side, grid: Grid, clock: Clock, interface_stress: float) -> SlabSnapshot:
    velocity, stress = side.medium.velocity, side.medium.stress
    force = np.diff(stress, prepend=interface_stress - clock.steady_stress)
    now = velocity.copy()
    now[:-1] -= force / grid.inertia[:-1]
    mass = grid.impedance * grid.width
    between = (mass[1:] * stress[:-1] + mass[:-1] * stress[1:]) / (mass[1:] + mass[:-1])
    outermost = stress[-1] + 0.5 * (stress[-1] - between[-1]) if between.size else stress[-1]
    at_nodes = np.concatenate(([interface_stress - clock.steady_stress], between, [outermost]))
    return SlabSnapshot(grid.depth / grid.depth[-1], now, clock.steady_stress + at_nodes)
