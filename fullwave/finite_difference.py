"""Staggered leapfrog finite differences: the simplest full wave.

Bulk: velocities at nodes and half times, stresses in cells and at whole times, central differences in space and time
(`leapfrog.media`). Interface: the half cell's momentum balance is Z v + F(v, psi) = R, the scalar condition of every solver
(`leapfrog.friction`).

At cfl = 1 waves travel through a uniform slab without error, so the scheme is the delay system (35) discretised by the midpoint
rule. Agreement with that system is therefore independent evidence only below cfl = 1. A slab or layer that is not a multiple of
the common cell has a slightly smaller Courant number. The scheme conserves the energy K(u at n + 1/2) + P(sigma at n, n + 1)
(`leapfrog.readout`).
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from fullwave.families import LEAPFROG
from fullwave.leapfrog.grid import common_step, slab_grid
from fullwave.leapfrog.kernel import MOST_PIECES, STEPS_PER_PIECE, march_leapfrog, steady_memory
from fullwave.leapfrog.media import CHANGED
from fullwave.leapfrog.readout import energy_of, leapfrog_snapshot
from fullwave.leapfrog.viscous import steady_side
from fullwave.lines.budget import enough_memory, require_bytes, steps_at_once
from fullwave.options import MOST_CELLS, require_cfl, require_whole
from fullwave.sampling import pieces_until, sample_nodes
from fullwave.slabs import marched_slabs
from slipwave.observe.pieces import Array, Pieces, empty_pieces
from slipwave.scene import Scene
from slipwave.solve import Energy, Snapshot, State, take_back, whole_numbers

_CELL_BYTES = 150.0  # measured, including the building of the grid: 50 in an elastic slab, 130 in a Kelvin-Voigt one
_CELL_WORK = 20.0  # products in the time of one step of a cell: 1 ns in an elastic slab, 10 in a Kelvin-Voigt one
_STEP_SECONDS, _CELL_SECONDS = 1e-7, 2e-9  # of the interface, and of a cell: 0.6 ns in an elastic slab, 10 in a Kelvin-Voigt one


class Leapfrog:
    """Marches `scene` with `cells` per slab at Courant number `cfl` in (0, 1]; a `FieldSolver` (slipwave.solve).

    `cells` is the number in the slab with the shorter round trip; the other slab has as many as keep its Courant number at or
    just below `cfl`. Honours every scene. Raises SceneError naming cells or cfl and the allowed range.
    """

    model = LEAPFROG.name
    bookkeeping = frozenset({"counts"})

    def __init__(self, scene: Scene, cells: int = LEAPFROG.cells, cfl: float = LEAPFROG.cfl) -> None:
        require_whole("cells", cells, 2, MOST_CELLS)
        require_cfl(cfl)
        self.scene, self.cells, self.cfl = scene, int(cells), float(cfl)
        self.nodes = sample_nodes(STEPS_PER_PIECE)
        self.failures, self.failed_at = 0, math.nan
        with enough_memory(self.cells):
            self._set_up()

    def _set_up(self) -> None:
        scene, cells, cfl = self.scene, self.cells, self.cfl
        self.step = common_step(scene, cells, cfl)
        travels = [slab.round_trip / scene.transit for slab in marched_slabs(scene)]
        require_bytes(cells, _CELL_BYTES * cfl * 0.5 * sum(travels) / self.step)
        self._grids = [slab_grid(slab, scene.transit, self.step, cfl, cells) for slab in marched_slabs(scene)]
        self._sides = [steady_side(scene, slab, grid) for slab, grid in zip(marched_slabs(scene), self._grids, strict=True)]
        self._lower = self._sides[1] if len(self._sides) == 2 else None
        self._memory = steady_memory(scene)
        self._sample = -1
        self._stride = steps_at_once(_CELL_WORK * self.total_cells)

    @property
    def transits_per_piece(self) -> float:
        """Length of the pieces that `advance` returns."""
        return STEPS_PER_PIECE * self.step

    @property
    def seconds_per_piece(self) -> float:
        """Approximate cost of a piece."""
        return STEPS_PER_PIECE * (_STEP_SECONDS + _CELL_SECONDS * self.total_cells)

    @property
    def time(self) -> float:
        """Time reached, in transits."""
        return max(self._sample, 0) * self.step

    @property
    def settings(self) -> dict[str, Any]:
        """As `Solver`."""
        widths = [grid.width.size for grid in self._grids]
        return {"cells": self.cells, "slabs": widths, "cfl": self.cfl, "step": self.step}

    @property
    def total_cells(self) -> int:
        """Number of marched cells."""
        return sum(grid.width.size for grid in self._grids)

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits), at most one chunk."""
        most = min(MOST_PIECES, max(1, self._stride // STEPS_PER_PIECE))
        return self._fill(pieces_until(max(self._sample, 0), self.step, until, STEPS_PER_PIECE, most))

    def _fill(self, pieces: Pieces) -> Pieces:
        """March through `pieces` and fill them. If there are none, only record the sample at t = 0, unless it exists."""
        scene, upper = self.scene, self._sides[0]
        physics = (scene.law, self.step, scene.forcing, scene.drive.compiled)
        failures, failed = march_leapfrog(*physics, upper, self._lower, self._memory, self._sample, pieces)
        if failures and not self.failures:
            self.failed_at = failed * self.step
        self.failures += failures
        self._sample = max(self._sample, 0) + STEPS_PER_PIECE * pieces.time.size
        return pieces

    def keep_ledger(self) -> None:
        """As `FieldSolver`; it is always kept."""

    def energy(self) -> Energy:
        """As `Solver`."""
        return energy_of(self.scene, self._memory, list(zip(self._sides, self._grids, strict=True)))

    def snapshot(self) -> Snapshot:
        """Velocity and stress at the nodes at `time`, of second order."""
        if self._sample < 0:  # the interface's velocity at t = 0 is only known once the sample there is taken
            self._fill(empty_pieces(0, self.nodes.size))
        return leapfrog_snapshot(self.scene, self.time, self._memory, self._sides, self._grids)

    def disturb(self, noise: Callable[[int], Array], stressed: bool = True) -> None:
        """As `FieldSolver`; stresses, which are stored at other times, are unchanged."""
        for side in self._sides:
            side.medium.velocity[1:-1] += noise(side.medium.velocity.size - 2)

    def deviation(self) -> float:
        """As `FieldSolver`."""
        return max(float(np.abs(side.medium.velocity - 0.5 * self.scene.velocity).max()) for side in self._sides)

    def deviation_energy(self) -> float:
        """As `FieldSolver`; that of the upper slab."""
        shot = self.snapshot().upper
        moving, loaded = shot.velocity - 0.5 * self.scene.velocity, shot.stress - self.scene.steady_stress
        return float(np.mean(moving**2) + np.mean((loaded / self.scene.upper.epsilon) ** 2))

    def keep_frames(self, interval: float) -> None:
        """As `FieldSolver`; does nothing, because four steps of a leapfrog are short."""

    def frames(self) -> list[Snapshot]:
        """As `FieldSolver`: the fields at the present time."""
        return [self.snapshot()]

    def state(self) -> State:
        """As `Solver`; `counts`: sample, failures."""
        counts = np.array([self._sample, self.failures], dtype=float)
        return {"counts": counts, "memory": self._memory.copy()} | {name: array.copy() for name, array in self._arrays().items()}

    def restore(self, state: State) -> None:
        """As `Solver`."""
        sample, failures = whole_numbers(state, "counts", (-1, 0))
        take_back({"memory": self._memory} | self._arrays(), state, f"{self.model}, {self.cells} cells")
        self._sample, self.failures = sample, failures

    def _arrays(self) -> dict[str, Array]:
        sides = [(label, part) for label, side in zip(("upper", "lower"), self._sides, strict=False) for part in side]
        return {f"{label}.{name}": getattr(part, name) for label, part in sides for name in part._fields if name in CHANGED}
