"""Staggered leapfrog finite differences: the simplest full wave.

Bulk: velocities at nodes and half times, stresses in cells and at whole times, central differences in both (`leapfrog.media`).
Interface: the half cell's momentum balance is Z v + F(v, psi) = R, the same scalar condition as every solver's
(`leapfrog.friction`).

order        2 in every output from a smooth start, 1 after a jump, at every cfl <= 1
cfl_max      1 (a slab, or a layer, whose cells do not divide it runs a little below the others)
exact_when   cfl = 1 in a uniform slab: waves then travel without error, and what remains is the delay system (35) discretised by
             the midpoint rule. Its agreement with that system is no independent evidence; below cfl = 1 it is.
conserves    the energy K(u at n + 1/2) + P(sigma at n, n + 1), to rounding; see `energy`
"""

import math

import numpy as np

from fullwave.leapfrog.drives import compiled_drive
from fullwave.leapfrog.faces import Rigid
from fullwave.leapfrog.kernel import (
    DRIVE,
    ELASTIC,
    MEMORY,
    PSI,
    STATE,
    STRESS,
    Clock,
    Mirror,
    Side,
    Z,
    march,
    take_step,
)
from fullwave.leapfrog.media import Uniform
from fullwave.sampling import STEPS_PER_PIECE, empty_pieces, pieces_until, sample_nodes
from scene.errors import NumericsError, SceneError
from scene.friction import unknown_of
from scene.observe import Energy, Pieces
from scene.scene import Scene

MOST_CELLS = 1_000_000


class Leapfrog:
    """Marches `scene` with `cells` per slab at Courant number `cfl` in (0, 1]; a `Solver` (scene.observe.follow).

    `cells` counts the slab with the shorter round trip; the other has as many as keep its Courant number at or just below `cfl`.
    Raises SceneError naming cells or cfl and the allowed range.
    """

    model = "fd"

    def __init__(self, scene: Scene, cells: int = 64, cfl: float = 1.0) -> None:
        _check(cells, cfl)
        if not (scene.alike and scene.upper.is_plain):
            raise SceneError("model fd: only alike, uniform, rigidly driven slabs so far")
        self.scene = scene
        self.nodes = sample_nodes()
        self.failures = 0
        self.cells, self.cfl = cells, cfl
        self.step = cfl * 0.5 / cells
        self._sample = -1
        self._clock = Clock(self.step, scene.transit, scene.stiffness, scene.steady_stress, scene.start.nudge_size)
        self._drive = compiled_drive(scene.drive)
        self._memory = _steady_memory(scene)
        impedance = scene.upper.epsilon / cfl
        medium = Uniform(
            np.full(cells + 1, 0.5 * scene.velocity), np.zeros(cells), 1.0 / impedance, cfl * scene.upper.epsilon, impedance
        )
        self._upper, self._lower = Side(medium, Rigid()), Mirror()
        self._take_first_sample()

    @property
    def time(self) -> float:
        """Time reached, in transits."""
        return self._sample * self.step

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits), at most one chunk."""
        pieces = empty_pieces(pieces_until(self._sample, self.step, until))
        self.failures += march(
            self.scene.law, self._clock, self._drive, self._upper, self._lower, self._memory, self._sample, pieces
        )
        self._sample += STEPS_PER_PIECE * pieces.time.size
        return pieces

    def energy(self) -> Energy | None:
        """Ledger since t = 0, in units of sigma L."""
        return None

    def _take_first_sample(self) -> None:
        converged = take_step(self.scene.law, self._clock, self._drive, self._upper, self._lower, self._memory, 0)
        self._sample = 0
        if not converged:
            self.failures += 1
        if not math.isfinite(float(self._memory.sum())):
            raise NumericsError(f"{self.model}: no finite slip rate at t = 0 (scene {self.scene.name!r})")


def _check(cells: int, cfl: float) -> None:
    if isinstance(cells, bool) or not isinstance(cells, int | np.integer) or not 2 <= cells <= MOST_CELLS:
        raise SceneError(f"cells = {cells!r}: must be a whole number from 2 to {MOST_CELLS}")
    if isinstance(cfl, bool) or not isinstance(cfl, int | float | np.floating) or not 0.0 < cfl <= 1.0:
        raise SceneError(f"cfl = {cfl!r}: must lie in (0, 1]")


def _steady_memory(scene: Scene) -> np.ndarray:
    """Interface memory of steady sliding, half a step before t = 0."""
    memory = np.zeros(MEMORY)
    psi = scene.steady_psi + scene.start.jump_size
    memory[STATE] = psi
    memory[PSI : PSI + 3] = psi
    memory[Z : Z + 3] = unknown_of(scene.law, scene.velocity)
    memory[[STRESS, ELASTIC]] = scene.steady_stress
    memory[DRIVE] = scene.velocity
    return memory
