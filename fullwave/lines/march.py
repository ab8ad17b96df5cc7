"""The march shared by all method-of-lines families: Runge-Kutta steps of fixed length, samples of the interface at their ends."""

import math
from typing import Any

import numpy as np

from fullwave.families import FullWave
from fullwave.lines.blocks import Section, assemble, marched_slabs, state_size
from fullwave.lines.budget import PRODUCTS_PER_SECOND, enough_memory, march_work, require_memory, steps_at_once
from fullwave.lines.kernel import MOST_PIECES, STEPS_PER_PIECE, march
from fullwave.lines.readout import Shape, impose_fields, snapshot_of, stored_energy
from fullwave.lines.runge_kutta import RungeKutta, method_of
from fullwave.lines.scene_limits import Builder, relaxation_limit, spectral_limit
from fullwave.lines.scheme_limit import longest_decay_step
from fullwave.lines.system import ELASTIC, FRICTION, INPUT, PSI, RADIATED, VISCOUS
from fullwave.options import require_cfl
from fullwave.sampling import pieces_until, sample_nodes
from slipwave.errors import NumericsError
from slipwave.friction import unknown_of
from slipwave.observe import Energy, Pieces
from slipwave.observe.pieces import Array
from slipwave.observe.restoring import take_back, whole_numbers
from slipwave.observe.snapshot import Snapshot
from slipwave.observe.solver import State
from slipwave.scene import Scene


def method_for(family: FullWave, number: int) -> RungeKutta:
    """The Runge-Kutta method of a member of `family`."""
    return method_of(family.order_in_time(number))


class MethodOfLines:
    """Marches `scene` as the member of `family` with `number`; `build` makes the grid of its `sections`. A `FieldSolver`
    (slipwave.observe.snapshot).

    `limit` is the longest stable step (transits) of elastic waves. `step` is the share `cfl` of the smallest limit: this one or
    that of outer faces, viscosity or friction's state. Raises SceneError naming cfl and its allowed range, or cells if the memory
    is too small (`budget`).
    """

    mass: str | None = None

    def __init__(
        self, scene: Scene, family: FullWave, number: int, build: Builder, sections: list[Section], limit: float, cfl: float
    ) -> None:
        require_cfl(cfl)
        self.scene, self.model, self.cfl = scene, family.called(number), float(cfl)
        self.method, self._order = method_for(family, number), family.order_bulk(number)
        self.sections = tuple(sections)
        self.nodes = sample_nodes(STEPS_PER_PIECE)
        self.failures, self.failed_at = 0, math.nan
        with enough_memory(sections[0].asked):
            self._set_up(build, sections, limit)

    def _set_up(self, build: Builder, sections: list[Section], limit: float) -> None:
        scene, method = self.scene, self.method
        viscous = any(slab.viscosity is not None for slab in marched_slabs(scene))
        require_memory(sections, build, method.stages, viscous)
        self.grid = build(sections)
        self.system = assemble(scene, self.grid)
        grid = self.grid
        self.step = self.cfl * min(limit, relaxation_limit(self.system, method))
        if viscous or self.system.interface.heavy:
            self.step = min(self.step, self.cfl * spectral_limit(scene, build, sections, method))
        self._taken = 0
        self._unknowns = np.full((3, method.stages), unknown_of(scene.law, scene.velocity))
        self._state = np.zeros(state_size(self.system))
        self._state[grid.size + PSI] = scene.steady_psi + scene.start.jump_size
        self._state[grid.size + ELASTIC] = scene.steady_stress
        self._frames, self._keeps_frames = np.empty((0, self._state.size)), False
        self._trial = np.zeros(self._state.size)
        self._rates = np.zeros(method.stages * self._state.size)
        self._work = march_work(self._state.size, self._order, method, viscous)
        self._stride = steps_at_once(self._work)

    @property
    def settings(self) -> dict[str, Any]:
        """Everything besides the scene and the model's name that affects its numbers."""
        cells = [section.cells for section in self.sections]
        return {"cells": cells, "mass": self.mass, "cfl": self.cfl, "step": self.step}

    @property
    def cells(self) -> int:
        """The requested cells per slab."""
        return self.sections[0].asked

    @property
    def transits_per_piece(self) -> float:
        """Length of the pieces that `advance` returns."""
        return STEPS_PER_PIECE * self.step

    @property
    def seconds_per_piece(self) -> float:
        """Approximate cost of a piece."""
        return STEPS_PER_PIECE * self._work / PRODUCTS_PER_SECOND

    @property
    def time(self) -> float:
        """Time reached, in transits."""
        return self._taken * self.step

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits), at most one chunk."""
        most = min(MOST_PIECES, max(1, self._stride // STEPS_PER_PIECE))
        pieces = pieces_until(self._taken, self.step, until, STEPS_PER_PIECE, most)
        steps = STEPS_PER_PIECE * pieces.time.size
        with enough_memory(self.sections[0].asked):
            self._frames = np.empty((self._keeps_frames * (steps + 1), self._state.size))
        fastest = self._fill(pieces, steps)
        self._taken += steps
        if self.step > longest_decay_step(fastest, self.method):
            raise NumericsError(
                f"{self.model}: before t = {self.time:.6g} transits the frictional state relaxes at {fastest:.4g} per transit, "
                f"too fast for steps of {self.step:.4g}: more cells or a smaller cfl (scene {self.scene.name!r})"
            )
        return pieces

    def _fill(self, pieces: Pieces, steps: int) -> float:
        """March the `steps` of `pieces`, in parts so that the run can be interrupted; returns the state's fastest relaxation."""
        fastest = 0.0
        for begin in range(0, steps + 1, self._stride):
            failures, failed, relaxation = march(
                self.system,
                self.method,
                self.step,
                self._taken,
                begin,
                min(begin + self._stride, steps + 1),
                self._state,
                self._trial,
                self._rates,
                self._unknowns,
                pieces,
                self._frames,
            )
            if failures and not self.failures:
                self.failed_at = (self._taken + failed) * self.step
            self.failures += failures
            fastest = max(fastest, relaxation)
        return fastest

    def energy(self) -> Energy:
        """Ledger since t = 0, in units of sigma L. It is integrated with the motion, so it closes at the order of the scheme."""
        scalars = self._state[self.grid.size :]
        stored = stored_energy(self.grid, self.system, self._state)
        supplied, friction, radiated, viscous = (float(scalars[slot]) for slot in (INPUT, FRICTION, RADIATED, VISCOUS))
        return Energy(supplied, friction, radiated, viscous, stored)

    def snapshot(self) -> Snapshot:
        """Velocity and stress at the nodes at `time`."""
        return self._shown(self.time, self._state)

    def keep_frames(self) -> None:
        """As `FieldSolver`: high-order steps are long, so pieces of eight steps are too long for a picture of waves."""
        self._keeps_frames = True

    def frames(self) -> list[Snapshot]:
        """As `FieldSolver`."""
        begin = self._taken - self._frames.shape[0] + 1
        return [self._shown((begin + k) * self.step, state) for k, state in enumerate(self._frames) if k] or [self.snapshot()]

    def _shown(self, time: float, state: Array) -> Snapshot:
        return snapshot_of(self.grid, self.system, time, state)

    def impose(self, slab: int, velocity: Shape, stress: Shape) -> None:
        """Set the fields of slab 0 (upper) or 1 (lower): functions of depth (transits of the upper slab, array in, array out).
        `velocity` in V* in the slab's own direction of drive, `stress` in units of the normal stress; both are total values."""
        impose_fields(self.grid, self.system, self._state, slab, velocity, stress)

    def state(self) -> State:
        """As `Solver`; `counts`: steps taken, failures."""
        counts = np.array([self._taken, self.failures], dtype=float)
        return {"counts": counts, "state": self._state.copy(), "unknowns": self._unknowns.copy()}

    def restore(self, state: State) -> None:
        """As `Solver`."""
        taken, failures = whole_numbers(state, "counts", (0, 0))
        take_back({"state": self._state, "unknowns": self._unknowns}, state, self.model)
        self._taken, self.failures = taken, failures
