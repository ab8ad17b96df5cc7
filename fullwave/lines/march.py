"""What all method-of-lines families share: grid, ledger, fields, and the march in time, exact or explicit."""

from collections.abc import Callable
from typing import Any, TypedDict

import numpy as np

from fullwave.families import FullWave
from fullwave.lines.blocks import Section, assemble, sections_of, state_size
from fullwave.lines.budget import enough_memory, march_work, require_few_unknowns, require_memory
from fullwave.lines.exact import EXACT_TOLERANCE, ExactMarch
from fullwave.lines.explicit import ExplicitMarch
from fullwave.lines.readout import Shape, impose_fields, snapshot_of, stored_energy, twice_energy
from fullwave.lines.runge_kutta import RungeKutta, method_of
from fullwave.lines.scene_limits import Builder, relaxation_limit, spectral_limit
from fullwave.lines.system import ELASTIC, PSI, System
from fullwave.lines.time_march import TimeMarch, cheaper_march
from fullwave.options import require_cfl
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.solve import Energy, Snapshot, State
from slipwave.step.flow import Cycle, Place
from slipwave.step.port_flow import PortFlow


class Marching(TypedDict, total=False):
    """Options of `MethodOfLines` that are the same for every family."""

    time: TimeMarch | None
    resolution: float


def method_for(family: FullWave, number: int) -> RungeKutta:
    """The Runge-Kutta method of a member of `family`."""
    return method_of(family.order_in_time(number))


class MethodOfLines:
    """Marches `scene` as the member of `family` with `number`; `build` makes the grid of its `sections`. A `FieldSolver`
    (slipwave.solve).

    `time` "exact" propagates the slabs without error in time, in steps that resolve friction to `resolution`, the relative error
    of the figures of a cycle. "explicit" takes Runge-Kutta steps: `limit()` is the longest stable one (transits) of elastic
    waves, and the step is the share `cfl` of the smallest limit, this one or that of outer faces, viscosity or friction's state.
    With None it is "explicit" if `cfl` is given, else the cheaper one (`cheaper_march`). Raises SceneError naming time or cfl and
    its allowed range, or cells if the memory is too small (`budget`).
    """

    mass: str | None = None

    def __init__(
        self,
        scene: Scene,
        family: FullWave,
        number: int,
        build: Builder,
        sections: list[Section],
        limit: Callable[[], float],
        cfl: float | None,
        time: TimeMarch | None = None,
        resolution: float = EXACT_TOLERANCE,
    ) -> None:
        if time not in (None, "exact", "explicit"):
            raise SceneError(f"time = {time!r}: must be exact or explicit")
        if cfl is not None:
            require_cfl(cfl)
            time = time or "explicit"
        self.scene, self.model, self.cfl = scene, family.called(number), float(family.cfl if cfl is None else cfl)
        self.method, self._order = method_for(family, number), family.order_bulk(number)
        self.sections, self._build = tuple(sections), build
        with enough_memory(sections[0].asked):
            self._set_up(build, sections, limit, time, resolution)
        self.nodes, self.bookkeeping = self._march.nodes, self._march.bookkeeping

    def _set_up(
        self, build: Builder, sections: list[Section], limit: Callable[[], float], time: TimeMarch | None, resolution: float
    ) -> None:
        scene, method = self.scene, self.method
        viscous = any(slab.viscosity is not None for slab in scene.slabs)
        require_memory(sections, build, method.stages, viscous)
        self.grid = build(sections)
        self.system = assemble(scene, self.grid)
        values = np.zeros(state_size(self.system))
        if (time or cheaper_march(scene, values.size)) == "exact":
            require_few_unknowns(self.cells, values.size)
            self._march: ExactMarch | ExplicitMarch = ExactMarch(scene, self.system_of, values, self.model, resolution)
            return
        step = self.cfl * min(limit(), relaxation_limit(self.system, method))
        if viscous or self.system.interface.heavy:
            step = min(step, self.cfl * spectral_limit(scene, build, sections, method))
        values[self.grid.size + PSI] = scene.steady_psi + scene.start.jump_size
        values[self.grid.size + ELASTIC] = scene.steady_stress
        work = march_work(values.size, self._order, method, viscous)
        self._march = ExplicitMarch(scene, self.system, method, step, values, work, self.cells, self.model)

    def system_of(self, scene: Scene) -> System:
        """The equations of motion of another scene on a grid of the same kind with as many cells."""
        if scene is self.scene:
            return self.system
        first = self.sections[0]
        return assemble(scene, self._build(sections_of(scene, first.asked, first.fewest)))

    @property
    def settings(self) -> dict[str, Any]:
        """Everything besides the scene and the model's name that affects its numbers."""
        cells = [section.cells for section in self.sections]
        return {"cells": cells, "mass": self.mass, "time": self._march.name, **self._march.settings, "cfl": self.cfl}

    @property
    def cells(self) -> int:
        """The requested cells per slab."""
        return self.sections[0].asked

    @property
    def step(self) -> float:
        """Length of a step (transits); the longest one, if lengths adapt."""
        return self._march.step

    @property
    def transits_per_piece(self) -> float:
        """Length of the pieces that `advance` returns; NaN if it adapts."""
        return self._march.transits_per_piece

    @property
    def seconds_per_piece(self) -> float:
        """Approximate cost of a piece."""
        return self._march.seconds_per_piece

    @property
    def time(self) -> float:
        """Time reached, in transits."""
        return self._march.time

    @property
    def failures(self) -> int:
        """Solves of the interface so far that did not converge."""
        return self._march.failures

    @property
    def failed_at(self) -> float:
        """Time of the first of them (transits); NaN if there is none."""
        return self._march.failed_at

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits), at most one chunk."""
        return self._march.advance(until)

    def keep_ledger(self) -> None:
        """As `FieldSolver`."""
        self._march.keep_ledger()

    def energy(self) -> Energy | None:
        """Ledger since t = 0, in units of sigma L; None unless it is kept. Work and heat are integrated with the motion, never
        taken from a difference, so that it closes at the order of the scheme."""
        work = self._march.work_done()
        if work is None:
            return None
        supplied, friction, radiated, viscous = work
        stored = stored_energy(self.grid, self.system, self._march.layout)
        return Energy(supplied, friction, radiated, viscous, stored)

    def snapshot(self) -> Snapshot:
        """Velocity and stress at the nodes at `time`."""
        return snapshot_of(self.grid, self.system, self.time, self._march.layout)

    def keep_frames(self, interval: float) -> None:
        """As `FieldSolver`."""
        self._march.keep_frames(interval)

    def frames(self) -> list[Snapshot]:
        """As `FieldSolver`."""
        shown = [snapshot_of(self.grid, self.system, time, values) for time, values in self._march.frames()]
        return shown or [self.snapshot()]

    def impose(self, slab: int, velocity: Shape, stress: Shape) -> None:
        """Set the fields of slab 0 (upper) or 1 (lower): functions of depth (transits of the upper slab, array in, array out).
        `velocity` in V* in the slab's own direction of drive, `stress` in units of the normal stress; both are total values."""
        values = self._march.layout
        impose_fields(self.grid, self.system, values, slab, velocity, stress)
        self._march.begin_from(values)

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
        """As `FieldSolver`; that of the marched slabs."""
        return twice_energy(self.grid, self._march.layout)

    def flow(self, period: float, tolerance: float) -> tuple[PortFlow, Array]:
        """As `PortMarch`. Raises SceneError if it marches explicitly."""
        if not isinstance(self._march, ExactMarch):
            raise SceneError(f"{self.model}: time = {self._march.name!r}: a flow over a period needs time = exact")
        return self._march.flow(period, tolerance)

    def placed(self, cycle: Cycle, place: Place) -> State:
        """As `PortMarch`; `cycle` is a motion of the exact march."""
        if isinstance(self._march, ExactMarch):
            return self._march.placed(cycle, place)
        return self._march.placed(cycle.start[:-1] / self.scene.upper.epsilon, place)

    def state(self) -> State:
        """As `Solver`."""
        return self._march.state()

    def restore(self, state: State) -> None:
        """As `Solver`."""
        self._march.restore(state)
