"""Stored energy and fields on the grid of a method-of-lines march."""

from typing import Any

import numpy as np

from fullwave.lines.blocks import Block, BlockGrid, Chain
from fullwave.lines.system import GRIP, SCALARS, System, Viscous
from fullwave.slabs import both_slabs
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import SlabSnapshot, Snapshot


def stored_energy(grid: BlockGrid, system: System, state: Array) -> float:
    """Change since steady sliding of the energy of all slabs and of their terminations, in units of sigma L."""
    interface = system.interface
    total = sum(_block_energy(block, system, state) for block in grid.blocks)
    for side in range(interface.sides):
        spring = float(system.tops.spring[side])
        if spring > 0.0:
            load = float(state[interface.size + GRIP + side])
            impedance = float(system.traces.impedance[system.traces.lift.size - interface.sides + side])
            total += load * (impedance * load + 2.0 * system.forcing.steady_stress) / (2.0 * spring)
        if interface.heavy:
            velocity = float(state[interface.heavy + side])
            total += 0.5 * float(system.tops.mass[side]) * velocity * (velocity + system.forcing.velocity)
    return interface.copies * system.forcing.transit * total


def _block_energy(block: Block, system: System, state: Array) -> float:
    """Half of eps (w.H w + s.H s), without the steady part; in a Zener solid s is the sum of a relaxed and a memory spring."""
    steady = system.forcing.steady_stress / block.section.impedance
    velocity, stress = state[block.velocity], state[block.stress]
    parts = [(velocity, 0.5 * system.forcing.velocity, 1.0)]
    medium = system.medium
    if isinstance(medium, Viscous) and medium.rate[block.stress[0]] > 0.0:
        memory = state[system.interface.size + SCALARS + block.stress]
        fraction = float(medium.fraction[block.stress[0]])
        parts += [(stress - memory, steady, 1.0 - fraction), (memory, 0.0, fraction)]
    else:
        parts.append((stress, steady, 1.0))
    return block.section.impedance * sum(_excess(block.norm, values, mean) / share for values, mean, share in parts)


def _excess(norm: Any, change: Array, mean: float) -> float:
    """Integral of ((mean + change)^2 - mean^2)/2."""
    weighted = _weighted(norm, change)
    return float(0.5 * (change @ weighted) + mean * weighted.sum())


def _weighted(norm: Any, values: Array) -> Array:
    return np.asarray(norm * values if isinstance(norm, np.ndarray) else norm @ values)


def twice_energy(grid: BlockGrid, state: Array) -> float:
    """w.H w + s.H s of the deviations from steady sliding in the marched slabs (V*^2)."""
    fields = [(block.norm, state[slots]) for block in grid.blocks for slots in (block.velocity, block.stress)]
    return float(sum(values @ _weighted(norm, values) for norm, values in fields))


def snapshot_of(scene: Scene, grid: BlockGrid, system: System, time: float, state: Array) -> Snapshot:
    """Fields of both slabs at `time`; if one slab is marched, it gives both."""
    return both_slabs(scene, time, [_slab_fields(chain, system, state) for chain in grid.chains])


def _slab_fields(chain: Chain, system: System, state: Array) -> SlabSnapshot:
    """Fields of a marched slab. The two values at a joint are averaged."""
    velocity = np.concatenate([state[block.velocity] for block in chain.blocks]) + 0.5 * system.forcing.velocity
    stress = np.concatenate([block.section.impedance * _total_stress(block, system, state) for block in chain.blocks])
    means = [np.bincount(chain.node, field) / chain.values for field in (velocity, stress + system.forcing.steady_stress)]
    return SlabSnapshot(chain.depth, means[0], means[1])


def _total_stress(block: Block, system: System, state: Array) -> Array:
    """s plus, in a Kelvin-Voigt slab, tau times the strain rate (from second-order differences, accurate enough for pictures)."""
    medium = system.medium
    stress: Array = state[block.stress]
    if isinstance(medium, Viscous) and medium.retardation[block.stress[0]] > 0.0:
        rate = np.gradient(state[block.velocity], block.depth, edge_order=2 if block.depth.size > 2 else 1)
        stress = stress + medium.retardation[block.stress[0]] * rate
    return stress
