"""The march shared by all method-of-lines families: Runge-Kutta steps of fixed length, samples of the interface at their ends."""

from typing import Any

import numpy as np

from fullwave.limits import Builder, relaxation_limit, viscous_limit
from fullwave.line import Section, assemble
from fullwave.motion import rates_of
from fullwave.options import require_cfl
from fullwave.readout import Shape, impose_fields, snapshot_of, stored_energy
from fullwave.restoring import take_back, whole_numbers
from fullwave.runge_kutta import CLASSICAL, DORMAND_PRINCE_8, RungeKutta, combine
from fullwave.sampling import pieces_until, sample_nodes
from fullwave.snapshot import Snapshot
from fullwave.stability import longest_decay_step
from fullwave.system import ELASTIC, FRICTION, INPUT, PSI, RADIATED, SCALARS, VISCOUS, System, Viscous
from scene.compiled import njit
from scene.errors import NumericsError
from scene.friction import unknown_of
from scene.observe import Energy, Pieces
from scene.observe.pieces import Array
from scene.scene import Scene

STEPS_PER_PIECE = 8
"""Steps in one piece: its nine samples make a polynomial of degree 8, so observers never limit a scheme of order 8 or less."""

MOST_PIECES = 512
"""Pieces in one chunk: memory stays at some 200 kB and the cost of leaving compiled code is spread over 4096 steps."""


@njit
def _march(
    system: System,
    method: RungeKutta,
    step: float,
    first: int,
    state: Array,
    trial: Array,
    rates: Array,
    unknowns: Array,
    pieces: Pieces,
    frames: Array,
) -> tuple[int, float]:
    """Fill `pieces`, advancing `state` from step number `first`. `unknowns` (3, stages) holds z of the last three steps' stages,
    latest first: a parabola through them starts each friction solve, which saves two of four iterations. `frames`, if it has
    rows, takes the state at the beginning of every step. Returns (failed solves, fastest state relaxation per transit)."""
    operator, medium, interface, drive = system.operator, system.medium, system.interface, system.drive
    slots, facts, tops, arrivals = system.slots, system.facts, system.tops, system.arrivals
    weight, abscissae = step * method.weight, step * method.abscissae
    unknown, psis, stress, elastic = pieces.unknown, pieces.state, pieces.stress, pieces.elastic
    stages, size, count = method.stages, interface.size, pieces.time.size
    failures = 0
    fastest = 0.0
    for n in range(STEPS_PER_PIECE * count + 1):
        time = (first + n) * step
        if n < frames.shape[0]:
            for i in range(state.size):
                frames[n, i] = state[i]
        for stage in range(stages):
            combine(weight, stages, stage, state, rates, trial)
            guess = 3.0 * (unknowns[0, stage] - unknowns[1, stage]) + unknowns[2, stage]
            z, mu, relaxation, iterations = rates_of(
                operator, medium, interface, drive, slots, facts, tops, arrivals,
                time + abscissae[stage], trial, rates, stage * state.size, guess,
            )  # fmt: skip
            failures += iterations == 0
            fastest = max(fastest, relaxation)
            if stage == 0:
                sample = (z, state[size + PSI], mu, state[size + ELASTIC])
                for k in range(max(0, (n - 1) // STEPS_PER_PIECE), min(count, n // STEPS_PER_PIECE + 1)):
                    j = n - STEPS_PER_PIECE * k
                    unknown[k, j], psis[k, j], stress[k, j], elastic[k, j] = sample
                if n == STEPS_PER_PIECE * count:
                    return failures, fastest
            unknowns[2, stage] = unknowns[1, stage]
            unknowns[1, stage] = unknowns[0, stage]
            unknowns[0, stage] = z
        combine(weight, stages, stages, state, rates, state)
    return failures, fastest


def method_for(order: int) -> RungeKutta:
    """The Runge-Kutta method that does not cap a scheme of `order` in space (8 at most).

    Elements of order P + 1 give the interface's outputs at up to order 2 P + 1, and with order 4 in time the differences of order
    4 lose a factor of five: only schemes of order 2 are left to the classical method (half as dear again with the other)."""
    return CLASSICAL if order <= 2 else DORMAND_PRINCE_8


class March:
    """Marches `scene`, its `sections` gridded by `build`, with `method`; a `Solver` (scene.observe.follow).

    `limit` is the longest stable step (transits) of elastic waves; `step` is the share `cfl` of it, or of what grips, viscosity
    and friction's state allow if that is less. Raises SceneError naming cfl and its allowed range.
    """

    def __init__(
        self, scene: Scene, model: str, build: Builder, sections: list[Section], method: RungeKutta, limit: float, cfl: float
    ) -> None:
        require_cfl(cfl)
        self.scene, self.model, self.method, self.cfl = scene, model, method, float(cfl)
        self.sections = tuple(sections)
        self.nodes = sample_nodes(STEPS_PER_PIECE)
        self.failures = 0
        self.grid = build(sections)
        self.system = assemble(scene, self.grid)
        grid = self.grid
        self.step = self.cfl * min(limit, relaxation_limit(self.system, method))
        if isinstance(self.system.medium, Viscous):
            self.step = min(self.step, self.cfl * viscous_limit(scene, build, sections, method))
        self._taken = 0
        self._unknowns = np.full((3, method.stages), unknown_of(scene.law, scene.velocity))
        memory = grid.size if isinstance(self.system.medium, Viscous) else 0
        self._state = np.zeros(grid.size + SCALARS + memory)
        self._state[grid.size + PSI] = scene.steady_psi + scene.start.jump_size
        self._state[grid.size + ELASTIC] = scene.steady_stress
        self._frames, self._keeps_frames = np.empty((0, self._state.size)), False
        self._trial = np.zeros(self._state.size)
        self._rates = np.zeros(method.stages * self._state.size)

    @property
    def settings(self) -> dict[str, Any]:
        """All that shapes its numbers besides the scene and the model's name."""
        cells = [section.cells for section in self.sections]
        return {"cells": cells, "mass": getattr(self, "mass", None), "cfl": self.cfl, "step": self.step}

    @property
    def time(self) -> float:
        """Time reached, in transits."""
        return self._taken * self.step

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits), at most one chunk."""
        pieces = pieces_until(self._taken, self.step, until, STEPS_PER_PIECE, MOST_PIECES)
        self._frames = np.empty((self._keeps_frames * (STEPS_PER_PIECE * pieces.time.size + 1), self._state.size))
        failures, fastest = _march(
            self.system,
            self.method,
            self.step,
            self._taken,
            self._state,
            self._trial,
            self._rates,
            self._unknowns,
            pieces,
            self._frames,
        )
        self.failures += failures
        self._taken += STEPS_PER_PIECE * pieces.time.size
        if self.step > longest_decay_step(fastest, self.method):
            raise NumericsError(
                f"{self.model}: before t = {self.time:.6g} transits the frictional state relaxes at {fastest:.4g} per transit, "
                f"too fast for steps of {self.step:.4g}: more cells or a smaller cfl (scene {self.scene.name!r})"
            )
        return pieces

    def energy(self) -> Energy:
        """Ledger since t = 0, in units of sigma L; integrated with the motion, so it closes at the order of the scheme."""
        scalars = self._state[self.grid.size :]
        stored = stored_energy(self.grid, self.system, self._state)
        supplied, friction, radiated, viscous = (float(scalars[slot]) for slot in (INPUT, FRICTION, RADIATED, VISCOUS))
        return Energy(supplied, friction, radiated, viscous, stored)

    def snapshot(self) -> Snapshot:
        """Velocity and stress at the nodes at `time`."""
        return self._shown(self.time, self._state)

    def keep_frames(self) -> None:
        """As `FieldSolver`: steps of high order are long, pieces of eight of them too long for a picture of waves."""
        self._keeps_frames = True

    def frames(self) -> list[Snapshot]:
        """As `FieldSolver`."""
        begin = self._taken - self._frames.shape[0] + 1
        return [self._shown((begin + k) * self.step, state) for k, state in enumerate(self._frames) if k] or [self.snapshot()]

    def _shown(self, time: float, state: Array) -> Snapshot:
        return snapshot_of(self.grid, self.system, time, state)

    def impose(self, slab: int, velocity: Shape, stress: Shape) -> None:
        """Set the fields of slab 0 (upper) or 1 (lower): functions of depth (transits of the upper slab, array in, array out).
        `velocity` in V* in the slab's own direction of drive, `stress` in units of the normal stress, both in full."""
        impose_fields(self.grid, self.system, self._state, slab, velocity, stress)

    def state(self) -> dict[str, Array]:
        """Everything that changes during a run, as arrays; `restore` takes it back to the bit."""
        counts = np.array([self._taken, self.failures], dtype=float)
        return {"counts": counts, "state": self._state.copy(), "unknowns": self._unknowns.copy()}

    def restore(self, state: dict[str, Array]) -> None:
        """Go on from `state`, taken from a solver of the same scene and settings; SceneError if it does not fit."""
        taken, failures = whole_numbers(state, "counts", (0, 0))
        take_back({"state": self._state, "unknowns": self._unknowns}, state, self.model)
        self._taken, self.failures = taken, failures
