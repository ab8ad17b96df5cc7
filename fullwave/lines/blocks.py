"""A scene divided into blocks: the data from which every method-of-lines family builds its `System`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fullwave.lines.panels import LANES
from fullwave.lines.system import SCALARS, Elastic, GridInterface, Operator, OuterFaces, System, Traces, Viscous
from fullwave.options import MOST_CELLS, require_whole
from fullwave.slabs import marched_slabs
from slipwave.observe.pieces import Array
from slipwave.scene import Scene


class Section(NamedTuple):
    """A layer of a slab: slab 0 (upper) or 1 (lower), depth of its near end and thickness (transits of the upper slab),
    impedance eps, cells, the fewest cells that the family allows in a section, and the requested cells per slab."""

    slab: int
    start: float
    length: float
    impedance: float
    cells: int
    fewest: int
    asked: int


class Block(NamedTuple):
    """A part of a section with its own operator: slots of w and s at its nodes (n,), their depths (n,), the norm (diagonal (n,)
    or scipy sparse (n, n), in transits), 1/h at the near and the far end."""

    section: Section
    velocity: NDArray[np.int64]
    stress: NDArray[np.int64]
    depth: Array
    norm: Any
    lift: tuple[float, float]


@dataclass(frozen=True)
class BlockGrid:
    """The grid that a family supplies: its compiled operator, the number of slots (a multiple of panels.LANES), and the blocks
    from the interface outwards, slab by slab."""

    operator: Operator
    size: int
    blocks: tuple[Block, ...]

    @cached_property
    def chains(self) -> tuple["Chain", ...]:
        """The marched slabs, the upper first. Values within 1e-12 of the thickness belong to one node."""
        chains = []
        for slab in sorted({block.section.slab for block in self.blocks}):
            blocks = tuple(block for block in self.blocks if block.section.slab == slab)
            depth = np.concatenate([block.depth for block in blocks])
            depths, node, values = np.unique(np.round(depth / depth[-1], 12), return_inverse=True, return_counts=True)
            chains.append(Chain(blocks, depths, node, values))
        return tuple(chains)


Builder: TypeAlias = Callable[[Sequence[Section]], BlockGrid]
"""A family's gridding of sections."""


class Chain(NamedTuple):
    """The blocks of one slab, from the interface outwards: its different nodes, as shares of the thickness (m,), the node of
    every value of the blocks (n,), n >= m, and the values of each node (m,): two where blocks or elements meet, else one."""

    blocks: tuple[Block, ...]
    depth: Array
    node: NDArray[np.int64]
    values: NDArray[np.int64]


def sections_of(scene: Scene, cells: int, fewest: int) -> list[Section]:
    """The layers of the slabs that are marched. `cells` is the number in the slab with the shorter round trip; the other slab has
    so many that its cells are not longer, and every layer has at least `fewest`. Raises SceneError naming cells and the allowed
    range."""
    require_whole("cells", cells, fewest, MOST_CELLS)
    slabs = marched_slabs(scene)
    shortest = min(slab.round_trip for slab in slabs)
    sections = []
    for index, slab in enumerate(slabs):
        depth = 0.0
        for layer in slab.layers:
            length = 0.5 * slab.round_trip / scene.transit * layer.fraction
            wanted = int(np.ceil(cells * slab.round_trip / shortest * layer.fraction - 1e-9))
            count = max(fewest, wanted)
            sections.append(Section(index, depth, length, slab.epsilon * layer.impedance, count, fewest, cells))
            depth += length
    return sections


def padded_half(nodes: int) -> int:
    """Number of slots of w, and also of s, for `nodes` nodes, such that both together fill whole panels."""
    return -(-2 * nodes // LANES) * LANES // 2


def assemble(scene: Scene, grid: BlockGrid) -> System:
    """Join the blocks of `grid` to each other, to the interface and to the outer faces of `scene`."""
    chains = [chain.blocks for chain in grid.chains]
    medium = _medium(scene, grid)
    traces = _traces(chains, medium)
    interface, tops = _interface(scene, traces, grid.size, isinstance(medium, Viscous)), _tops(scene, chains, traces)
    return System(grid.operator, medium, interface, scene.forcing, scene.drive.compiled, traces, tops)


def state_size(system: System) -> int:
    """Number of integrated values: grid, scalars, in viscous slabs a memory stress per slot, velocities of heavy faces."""
    size, heavy = system.interface.size, system.interface.heavy
    return heavy + LANES if heavy else size + SCALARS + size * isinstance(system.medium, Viscous)


def _traces(chains: Sequence[tuple[Block, ...]], medium: Elastic | Viscous) -> Traces:
    near, far = (0, -1.0), (-1, 1.0)
    ends: list[tuple[Block, int, float]] = []
    for chain in chains:
        for here, beyond in pairwise(chain):
            ends += [(here, *far), (beyond, *near)]
    ends += [(chain[0], *near) for chain in chains]
    ends += [(chain[-1], *far) for chain in chains]
    velocity, stress = np.array([[block.velocity[end], block.stress[end]] for block, end, _ in ends]).T.copy()
    facts = [[block.lift[end], sign, 1.0, block.section.impedance, 0.0, 0.0] for block, end, sign in ends]
    traces = Traces(velocity, stress, *np.array(facts).T.copy())
    if isinstance(medium, Viscous):
        traces.stiffened[:] += medium.retardation[stress] * traces.lift
    return traces


def _tops(scene: Scene, chains: Sequence[tuple[Block, ...]], traces: Traces) -> OuterFaces:
    columns = []
    for index, (slab, chain) in enumerate(zip(marched_slabs(scene), chains, strict=True)):
        held, impedance = slab.termination.in_transits(scene.transit), chain[-1].section.impedance
        if held.is_rigid:
            columns.append((1.0, 0.0, 0.0, 0.0, 0.0, 0.0))
            continue
        dashpot = held.dashpot / impedance
        resistance = dashpot + float(traces.stiffened[index - len(chains)])
        yielding = 1.0 / resistance
        columns.append((dashpot / resistance, yielding, held.spring / impedance, held.dashpot, held.has_dead_load, held.mass))
    return OuterFaces(*np.array(columns, dtype=float).T.copy())


def _medium(scene: Scene, grid: BlockGrid) -> Elastic | Viscous:
    """What viscosity adds. The weight eps h per slot times half of w^2 or s^2, summed, is energy over one transit. A norm that is
    not diagonal is replaced by its row sums: these integrate to the order of the scheme but may be negative, which is sufficient
    for the balance of heat; stored energy is summed with the norm itself (`readout`)."""
    slabs = marched_slabs(scene)
    if all(slab.viscosity is None for slab in slabs):
        return Elastic()
    weight, rate, fraction, delay, total, spare = (np.zeros(grid.size) for _ in range(6))
    is_velocity = np.zeros(grid.size, dtype=np.bool_)
    for block in grid.blocks:
        norm = block.norm if isinstance(block.norm, np.ndarray) else np.asarray(block.norm.sum(axis=1)).ravel()
        weight[block.velocity] = weight[block.stress] = block.section.impedance * norm
        is_velocity[block.velocity] = True
        solid = slabs[block.section.slab].rheology
        if solid.blocks_fast_waves:
            delay[block.stress] = solid.retardation / scene.transit
        elif solid.relaxation > 0.0:
            rate[block.stress] = scene.transit / solid.relaxation
            fraction[block.stress] = solid.ratio / (1.0 + solid.ratio)
    return Viscous(weight, rate, fraction, delay, is_velocity, total, spare)


def _interface(scene: Scene, traces: Traces, size: int, viscous: bool) -> GridInterface:
    sides = len(marched_slabs(scene))
    has_mass = any(slab.termination.mass > 0.0 for slab in marched_slabs(scene))
    joints = traces.lift.size // 2 - sides
    copies = 2.0 if sides == 1 else 1.0
    ends = slice(2 * joints, 2 * joints + sides)
    return GridInterface(
        law=scene.law,
        impedance=1.0 / float((copies / (traces.impedance * traces.stiffened))[ends].sum()),
        copies=copies,
        joints=joints,
        sides=sides,
        size=size,
        heavy=has_mass * (size + SCALARS + viscous * size),
    )
