"""Base class of all method-of-lines families: grid, energy balance, fields, and the march in time, exact or explicit."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from fullwave.families import FullWave
from fullwave.lines.blocks import Block, BlockGrid, Section, assemble, sections_of, state_size
from fullwave.lines.budget import enough_memory, require_few_unknowns, require_memory
from fullwave.lines.exact import EXACT_TOLERANCE, ExactMarch, TimeMarch, cheaper_march
from fullwave.lines.explicit import ExplicitMarch
from fullwave.lines.matrix import derivative_of
from fullwave.lines.runge_kutta import method_of
from fullwave.lines.scheme_limit import MARGIN, line_spectrum, longest_step, relaxation_limit, spectral_limit
from fullwave.lines.system import ELASTIC, GRIP, PSI, SCALARS, System, Viscous
from fullwave.options import require_cfl
from fullwave.slabs import both_slabs, marched_slabs
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.solve import Energy, SlabSnapshot, Snapshot, State
from slipwave.step.flow import Cycle, InterfaceState
from slipwave.step.port_flow import PortFlow


def _stored_energy(grid: BlockGrid, system: System, state: Array) -> float:
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
    energy = 0.0
    for change, mean, share in parts:  # the integral of ((mean + change)^2 - mean^2)/2
        weighted = _weighted(block.norm, change)
        energy += float(0.5 * (change @ weighted) + mean * weighted.sum()) / share
    return block.section.impedance * energy


def _weighted(norm: Any, values: Array) -> Array:
    return np.asarray(norm * values if isinstance(norm, np.ndarray) else norm @ values)


def _snapshot_of(scene: Scene, grid: BlockGrid, system: System, time: float, state: Array) -> Snapshot:
    """Fields of both slabs at `time`; if one slab is marched, it gives both. The two values at a joint are averaged."""
    marched = []
    for chain in grid.chains:
        velocity = np.concatenate([state[block.velocity] for block in chain.blocks]) + 0.5 * system.forcing.velocity
        stress = np.concatenate([block.section.impedance * _total_stress(block, system, state) for block in chain.blocks])
        means = [np.bincount(chain.node, field) / chain.values for field in (velocity, stress + system.forcing.steady_stress)]
        marched.append(SlabSnapshot(chain.depth, means[0], means[1]))
    return both_slabs(scene, time, marched)


def _total_stress(block: Block, system: System, state: Array) -> Array:
    """s plus, in a Kelvin-Voigt slab, tau times the strain rate (from second-order differences, accurate enough for pictures)."""
    medium = system.medium
    stress: Array = state[block.stress]
    if isinstance(medium, Viscous) and medium.retardation[block.stress[0]] > 0.0:
        rate = np.gradient(state[block.velocity], block.depth, edge_order=2 if block.depth.size > 2 else 1)
        stress = stress + medium.retardation[block.stress[0]] * rate
    return stress


_LIMITS: dict[tuple[type, int, int], float] = {}
"""Longest stable steps of elastic waves, over the length of a cell, by class, number and cells."""


class MethodOfLines(ABC):
    """Marches `scene` as the member of its `family` with `number` (by default the usual one), on `cells` in the slab with the
    shorter round trip. A `FieldSolver` (slipwave.solve).

    `time` "exact" propagates the slabs without error in time, in steps that resolve friction to `resolution`, the relative error
    of the figures of a cycle. "explicit" takes Runge-Kutta steps, the share `cfl` of the longest stable one: of elastic waves, or
    of outer faces, viscosity or friction's state. With None it is "explicit" if `cfl` is given, else the cheaper one
    (`cheaper_march`). Raises SceneError naming the option and its allowed range, or cells if the memory is too small (`budget`).
    """

    family: ClassVar[FullWave]

    def __init__(
        self,
        scene: Scene,
        number: int | None = None,
        cells: int | None = None,
        cfl: float | None = None,
        time: TimeMarch | None = None,
        resolution: float = EXACT_TOLERANCE,
    ) -> None:
        family = self.family
        self.number = family.usual if number is None else number
        family.require_number(self.number)
        self.sections = tuple(sections_of(scene, family.cells if cells is None else cells, self.fewest))
        if time not in (None, "exact", "explicit"):
            raise SceneError(f"time = {time!r}: must be exact or explicit")
        if cfl is not None:
            require_cfl(cfl)
            time = time or "explicit"
        self.scene, self.model, self.cfl = scene, family.called(self.number), float(family.cfl if cfl is None else cfl)
        self.method = method_of(family.order_in_time(self.number))
        with enough_memory(self.cells):
            self._march = self._set_up(time, resolution)
        self.nodes, self.bookkeeping = self._march.nodes, self._march.bookkeeping

    @property
    def fewest(self) -> int:
        """Fewest cells of a layer."""
        return 1

    @abstractmethod
    def grid_of(self, sections: Sequence[Section]) -> BlockGrid:
        """The family's grid of `sections`."""

    @property
    def most_sampled(self) -> int:
        """Most cells of a section in the line whose spectrum gives its step limit: more of them change the limit by less than
        `MARGIN`. 1: every cell is a block, so that no line is shortened."""
        return 1

    def elastic_limit(self) -> float:
        """Longest stable explicit step (transits) of elastic waves in the `sections`."""
        return min(self._limit_of(min(s.cells, self.most_sampled)) * s.length / s.cells for s in self.sections)

    def _limit_of(self, cells: int) -> float:
        key = type(self), self.number, cells
        if key not in _LIMITS:
            share = 1.0 if self.most_sampled == 1 else MARGIN
            _LIMITS[key] = share * longest_step(line_spectrum(*self.line_of(cells)), self.method) * cells
        return _LIMITS[key]

    def line_of(self, cells: int) -> tuple[Array, Array]:
        """D (n, n) and l of the near end (n,) of an only block of `cells` and length 1."""
        grid = self.grid_of([Section(0, 0.0, 1.0, 1.0, cells, self.fewest, cells)])
        (block,) = grid.blocks
        derivative = derivative_of(grid.operator, grid.size)[block.stress[:, None], block.velocity]
        return derivative, block.lift[0] * np.eye(block.depth.size)[0]

    def _set_up(self, time: TimeMarch | None, resolution: float) -> ExactMarch | ExplicitMarch:
        scene, method, viscous = self.scene, self.method, any(slab.viscosity is not None for slab in self.scene.slabs)
        require_memory(self.sections, self.grid_of, method.stages, viscous)
        self.grid = self.grid_of(self.sections)
        self.system = assemble(scene, self.grid)
        values = np.zeros(state_size(self.system))
        if (time or cheaper_march(scene, values.size)) == "exact":
            require_few_unknowns(self.cells, values.size)
            return ExactMarch(scene, self.system_of, values, self.model, resolution)
        step = self.cfl * min(self.elastic_limit(), relaxation_limit(self.system, method))
        if viscous or self.system.interface.heavy:
            step = min(step, self.cfl * spectral_limit(scene, self.grid_of, self.sections, method))
        values[self.grid.size + PSI] = scene.steady_psi + scene.start.jump_size
        values[self.grid.size + ELASTIC] = scene.steady_stress
        # products in a step: in each stage, order + 1 nodes per row of the operator, which viscosity applies twice, and on
        # average half of the earlier stages
        of_stage = (self.family.order_bulk(self.number) + 1.0) * (2.0 if viscous else 1.0) + 0.5 * method.stages
        work = method.stages * values.size * of_stage
        return ExplicitMarch(scene, self.system, method, step, values, work, self.cells, self.model)

    def system_of(self, scene: Scene) -> System:
        """The equations of motion of another scene on a grid of the same family and number of cells."""
        if scene is self.scene:
            return self.system
        first = self.sections[0]
        return assemble(scene, self.grid_of(sections_of(scene, first.asked, first.fewest)))

    @property
    def settings(self) -> dict[str, Any]:
        """As `Solver`."""
        cells = [section.cells for section in self.sections]
        return {"cells": cells, "time": self._march.name, **self._march.settings, "cfl": self.cfl}

    @property
    def cells(self) -> int:
        """The requested cells per slab."""
        return self.sections[0].asked

    step = property(attrgetter("_march.step"), doc="Length of a step (transits); the longest one, if lengths adapt.")
    transits_per_piece = property(attrgetter("_march.transits_per_piece"), doc="As `Solver`.")
    seconds_per_piece = property(attrgetter("_march.seconds_per_piece"), doc="As `Solver`.")
    time = property(attrgetter("_march.time"), doc="Time reached, in transits.")
    failures = property(attrgetter("_march.failures"), doc="Solves of the interface so far that did not converge.")
    failed_at = property(attrgetter("_march.failed_at"), doc="Time of the first of them (transits); NaN if there is none.")

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits), at most one chunk."""
        return self._march.advance(until)

    def keep_ledger(self) -> None:
        """As `FieldSolver`."""
        self._march.keep_ledger()

    def energy(self) -> Energy | None:
        """As `Solver`; None unless `keep_ledger` was called. Work and heat are integrated with the motion, independently of the
        stored energy, so that the balance closes at the order of the scheme."""
        work = self._march.work_done()
        stored = _stored_energy(self.grid, self.system, self._march.layout)
        if work is None:
            return None
        supplied, friction, radiated, viscous = work.tolist()
        return Energy(supplied, friction, radiated, viscous, stored)

    def snapshot(self) -> Snapshot:
        """Velocity and stress at the nodes at `time`."""
        return _snapshot_of(self.scene, self.grid, self.system, self.time, self._march.layout)

    def keep_frames(self, interval: float) -> None:
        """As `FieldSolver`."""
        self._march.keep_frames(interval)

    def frames(self) -> list[Snapshot]:
        """As `FieldSolver`."""
        shown = [_snapshot_of(self.scene, self.grid, self.system, time, values) for time, values in self._march.frames()]
        return shown or [self.snapshot()]

    def disturb(self, noise: Callable[[int], Array], stressed: bool = True) -> None:
        """As `FieldSolver`."""
        values = self._march.layout
        for block in self.grid.blocks:
            values[block.velocity] += noise(block.velocity.size)
            if stressed:
                values[block.stress] += noise(block.stress.size)
        self._march.begin_from(values)

    def deviation(self) -> float:
        """As `FieldSolver`."""
        return float(np.abs(self._march.layout[: self.grid.size]).max())

    def deviation_energy(self) -> float:
        """As `FieldSolver`; that of the marched slabs: w.H w + s.H s."""
        state = self._march.layout
        fields = [(block.norm, state[slots]) for block in self.grid.blocks for slots in (block.velocity, block.stress)]
        return float(sum(values @ _weighted(norm, values) for norm, values in fields))

    def flow(self, period: float, tolerance: float) -> tuple[PortFlow, Array]:
        """As `PortMarch`. Raises SceneError if it marches explicitly."""
        if not isinstance(self._march, ExactMarch):
            raise SceneError(f"{self.model}: time = {self._march.name!r}: a flow over a period needs time = exact")
        return self._march.flow(period, tolerance)

    def state_at_start(self, cycle: Cycle, interface: InterfaceState) -> State:
        """As `PortMarch`; `cycle` is a motion of the exact march."""
        if isinstance(self._march, ExactMarch):
            return self._march.state_at_start(cycle, interface)
        return self._march.state_at_start(cycle.start[:-1] / marched_slabs(self.scene)[0].epsilon, interface)

    def state(self) -> State:
        """As `Solver`."""
        return self._march.state()

    def restore(self, state: State) -> None:
        """As `Solver`."""
        self._march.restore(state)
