"""Staggered leapfrog finite differences: the simplest full wave.

Bulk: velocities at nodes and half times, stresses in cells and at whole times, central differences in space and time
(`leapfrog.media`). Interface: the half cell's momentum balance is Z v + F(v, psi) = R, the scalar condition of every solver
(`leapfrog.kernel`).

At cfl = 1 waves travel through a uniform slab without error, so the scheme is the delay system (35) discretised by the midpoint
rule. Agreement with that system is therefore independent evidence only below cfl = 1. A slab or layer that is not a multiple of
the common cell has a slightly smaller Courant number. The scheme conserves the energy K(u at n + 1/2) + P(sigma at n, n + 1)
exactly, with K + P = sum m u^2/2 + sum dx sigma^n sigma^(n+1)/(2 eps), so that the energy balance (per unit area, in units of
sigma L, since t = 0) closes to rounding. The kernel only sums the powers of drive, friction, dashpots and viscosity; the stored
energy is computed here. Stresses are stored as deviations from steady sliding, whose stress enters separately, without
cancellation.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from fullwave.families import LEAPFROG
from fullwave.leapfrog.grid import LeapfrogGrid
from fullwave.leapfrog.kernel import FRICTION, INPUT, MOST_PIECES, RATE, STEPS_PER_PIECE, STRESS, Z, march_leapfrog, steady_memory
from fullwave.leapfrog.media import CHANGED, KelvinVoigt, MarchedSlab, Rigid, StandardLinear, face_energy, steady_side
from fullwave.lines.budget import enough_memory, require_bytes, steps_at_once
from fullwave.options import MOST_CELLS, require_cfl, require_whole
from fullwave.sampling import pieces_until
from fullwave.slabs import both_slabs, marched_slabs
from slipwave.friction import rate_of
from slipwave.observe.pieces import Array, Pieces, empty_pieces
from slipwave.scene import Scene
from slipwave.solve import Energy, SlabSnapshot, Snapshot, State, take_back, whole_numbers

_CELL_BYTES = 150.0  # measured, including the building of the grid: 50 in an elastic slab, 130 in a Kelvin-Voigt one
_CELL_WORK = 20.0  # products in the time of one step of a cell: 1 ns in an elastic slab, 10 in a Kelvin-Voigt one
_STEP_SECONDS, _CELL_SECONDS = 1e-7, 2e-9  # of the interface, and of a cell: 0.6 ns in an elastic slab, 10 in a Kelvin-Voigt one


def _side_energy(side: MarchedSlab, grid: LeapfrogGrid, steady_stress: float, velocity: float) -> tuple[float, float, float]:
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


def _slab(side: MarchedSlab, grid: LeapfrogGrid, interface_stress: float, rate: float, drive: float) -> SlabSnapshot:
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


def _at_whole_time(side: MarchedSlab, grid: LeapfrogGrid, interface_stress: float, rate: float) -> tuple[Array, Array]:
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
        self.nodes = np.linspace(0.0, 1.0, STEPS_PER_PIECE + 1)
        self.failures, self.failed_at = 0, math.nan
        with enough_memory(self.cells):
            self._set_up()

    def _set_up(self) -> None:
        scene, cells, cfl = self.scene, self.cells, self.cfl
        travels = [slab.round_trip / scene.transit for slab in marched_slabs(scene)]
        self.step = cfl * 0.5 * (min(scene.upper.round_trip, scene.lower.round_trip) / scene.transit) / cells
        require_bytes(cells, _CELL_BYTES * cfl * 0.5 * sum(travels) / self.step)
        self._grids = [LeapfrogGrid.of(slab, scene.transit, self.step, cfl, cells) for slab in marched_slabs(scene)]
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
        scene, unit = self.scene, self.scene.transit
        sides = zip(self._sides, self._grids, strict=True)
        sums = [_side_energy(side, grid, scene.steady_stress, 0.5 * scene.velocity) for side, grid in sides]
        copies = 3 - len(sums)  # an only slab, which stands for both, counts twice
        stored, radiated, viscous = (copies * sum(column) for column in zip(*sums, strict=True))
        spent = unit * self.step
        return Energy(
            input=float(spent * self._memory[INPUT]),
            friction=float(spent * self._memory[FRICTION]),
            radiated=unit * radiated,
            viscous=unit * viscous,
            stored=unit * stored,
        )

    def snapshot(self) -> Snapshot:
        """Velocity and stress at the nodes at `time`, of second order."""
        if self._sample < 0:  # the interface's velocity at t = 0 is only known once the sample there is taken
            self._fill(empty_pieces(0, self.nodes.size))
        scene, memory = self.scene, self._memory
        stress, rate = float(memory[STRESS]) - scene.steady_stress, float(memory[RATE])
        drive = 0.5 * scene.drive.at(self.time)
        rates = rate, rate_of(scene.law, float(memory[Z])) - rate
        marched = zip(self._sides, self._grids, rates, strict=False)
        shots = [_slab(side, grid, stress, own, drive) for side, grid, own in marched]
        shown = [SlabSnapshot(shot.depth, shot.velocity, shot.stress + scene.steady_stress) for shot in shots]
        return both_slabs(scene, self.time, shown)

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
