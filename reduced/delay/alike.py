"""The exact delay system (29, 35) for alike plain slabs, by Radau collocation whose steps divide the transit (`transit_mesh`)."""

import math
from functools import cache

import numpy as np

from reduced.delay.alike_kernel import PSI, TIME, AlikeMemory, Matrices, march_delay
from reduced.delay.march import DelayMarch
from reduced.delay.transit_mesh import TransitMesh, cuts_of, transit_mesh
from reduced.step.collocation import growth_limit, highest_coefficient, radau
from reduced.step.guess import DONE, first_guess
from reduced.step.newton import UNKNOWN
from slipwave.errors import SceneError
from slipwave.friction import respond, unknown_of
from slipwave.observe.pieces import Array, Pieces, empty_pieces
from slipwave.scene import Scene

MAX_STEPS = 4096
_CHUNK, _LONG_CHUNK = 4096, 1 << 16
_LOOSE_NODES, _TIGHT_NODES, _LOOSE = 6, 8, 3e-7
_FEWEST_STEPS, _MOST_FIRST_STEPS = 3, 24


class Delay(DelayMarch):
    """Marches the exact system to `tolerance`, the requested relative error of what is asked for.

    Asked for are the figures of the cycle, dense extrema included (`emit`, the default), or only the state at the end of the run
    (`emit=False`: fewer steps; `advance` returns the last piece of each chunk, without elastic stress). The number of steps a
    transit grows wherever a step's polynomial is not resolved or Newton fails, going back to the last whole transit. `nodes` and
    `steps` (a lower bound) may be given by hand. `failures` counts unconverged solves: a step that cannot be solved with
    MAX_STEPS a transit raises NumericsError instead.
    """

    _memory: AlikeMemory

    def __init__(
        self, scene: Scene, nodes: int | None = None, steps: int | None = None, tolerance: float = 1e-9, emit: bool = True
    ) -> None:
        refuse_unless_plain(scene)
        super().__init__(scene)
        self._stages = nodes or (_LOOSE_NODES if tolerance > _LOOSE else _TIGHT_NODES)
        self._newton_tolerance = max(1e-3 * tolerance, 1e-14)
        self._resolution = dense_resolution(tolerance, self._stages) if emit else end_resolution(tolerance)
        self._steepest = growth_limit(self._stages, tolerance)
        self._emit = emit
        self.nodes, self._matrices = collocation_matrices(self._stages)
        self._cuts = cuts_of(scene.drive)
        self._begin(transit_mesh(steps or _first_steps(scene, self._stages), self._cuts))
        self._march(0, empty_pieces(0, self._stages))  # loads or compiles the march, so that a run's wall time is the march's

    @property
    def steps(self) -> int:
        """Steps a transit in use now."""
        return self._mesh.steps

    def advance(self, until: float) -> Pieces:
        """March to the first step end at or beyond `until`, at most one chunk; see `Solver`."""
        while True:
            wanted = self._mesh.steps_until(until - self.time, int(self._memory.cursor[0]))
            count = min(_CHUNK if self._emit else _LONG_CHUNK, wanted)
            pieces = empty_pieces(count if self._emit else 1, self._stages)
            kept, verdict = self._march(count, pieces)
            self._memory.now[TIME] = self._on_mesh(self.time)
            if verdict != DONE:
                self._refine(verdict)
            if not self._emit and verdict == DONE:
                return pieces
            if self._emit and kept:
                return Pieces(*(array[:kept] for array in pieces))

    def _march(self, count: int, pieces: Pieces) -> tuple[int, int]:
        """(steps kept, verdict) of `count` steps."""
        tolerances = (self._newton_tolerance, self._resolution, self._steepest)
        scene, nodes = self.scene, tuple(self.nodes)
        physics = (scene.law, scene.upper.epsilon, scene.forcing, scene.drive.compiled)
        kept, iterations, verdict = march_delay(nodes, *physics, self._matrices, self._memory, count, *tolerances, pieces)
        self.iterations += iterations
        return kept, verdict

    def _on_mesh(self, time: float) -> float:
        """`time` without the rounding of many additions: the start of the step that comes next."""
        start = float(self._mesh.starts[int(self._memory.cursor[0])])
        return round(time - start) + start

    def _begin(self, mesh: TransitMesh) -> None:
        """Steady sliding at t = 0, psi displaced if the start is a jump."""
        scene = self.scene
        psi = scene.steady_psi + scene.start.jump_size
        incoming = np.full((mesh.steps, self._stages), scene.steady_stress + 0.5 * scene.upper.epsilon * scene.velocity)
        self._mesh = mesh
        self._memory = self._remember(incoming, np.array([0.0, psi, scene.steady_stress]), 0)

    def _refine(self, verdict: int) -> None:
        """More steps a transit: the stored polynomials are evaluated at the new nodes. Between nodes they are good to the dense
        tolerance only, so where just the end is wanted and resolved, the run begins again instead."""
        old, cursor = self._mesh, int(self._memory.cursor[0])
        new = old.halved() if cursor else transit_mesh(_next_count(old.count), self._cuts)
        if new.count > MAX_STEPS:
            raise self._unresolved(old.steps, verdict)
        if self._emit:
            self._mesh = new
            self._memory = self._remember(old.resample(self._memory.incoming, self.nodes, new), self._memory.now, 2 * cursor)
        else:
            self._begin(new)

    def _remember(self, incoming: Array, now: Array, cursor: int) -> AlikeMemory:
        """Memory at a step's start with guesses from frozen psi."""
        guess = np.full((2, self._stages), now[PSI])
        start = unknown_of(self.scene.law, self.scene.velocity)
        self.failures += first_guess(
            self.scene.law, 0.5 * self.scene.upper.epsilon, incoming[cursor], now[PSI], start, guess[UNKNOWN]
        )
        return AlikeMemory(incoming, self._mesh.lengths, guess, now.copy(), np.array([cursor]))


def refuse_unless_plain(scene: Scene) -> None:
    """SceneError unless both slabs are alike, homogeneous, elastic and driven through rigid faces."""
    if not (scene.alike and scene.upper.is_plain):
        raise SceneError(f"model = delay: scene {scene.name!r} is not a pair of alike plain slabs with rigid faces")


@cache
def collocation_matrices(stages: int) -> tuple[Array, Matrices]:
    """Nodes and transposed matrices; the tail row gives the highest Legendre coefficient from nodal values."""
    rule = radau(stages)
    matrices = (rule.integral.T.copy(), rule.predict.T.copy(), rule.predict_state.T.copy(), highest_coefficient(rule.nodes))
    return rule.nodes, Matrices(*matrices)


def dense_resolution(tolerance: float, stages: int) -> float:
    """Largest highest Legendre coefficient of z in a step for polynomials good to `tolerance` (the next one is smaller by the
    decay from coefficient to coefficient)."""
    return float(max(tolerance ** (stages / (stages + 2.0)), 1e-9))


def end_resolution(tolerance: float) -> float:
    """The same for the state at the steps' ends alone, which superconverges: measured on the yardstick scenes, 5 and 8 nodes, the
    error of psi is 0.02 coefficient^2 (from 2e-2 down to 1e-5)."""
    return float(min(0.02, max((30.0 * tolerance) ** 0.5, 1e-6)))


def _first_steps(scene: Scene, stages: int) -> int:
    """Steps a transit to begin with, from the fastest acceleration possible: (ln v)' <= r b / Z where radiation limits v
    (8 nodes: 3 at log10 r = -2.68 of the paper's scene, 14 at -2.3)."""
    z = unknown_of(scene.law, scene.velocity)
    _, v_z, _, _, friction_psi, _, g_z, _ = respond(scene.law, z, scene.steady_psi)
    fastest = scene.transit * abs(friction_psi * g_z) / (scene.impedance * v_z)
    guess = 3.0 * (fastest / 7.3) ** 1.7 * math.sqrt(_TIGHT_NODES / stages)
    steps = int(np.clip(guess, _FEWEST_STEPS, _MOST_FIRST_STEPS))
    return steps if steps < 5 else steps + steps % 2


def _next_count(steps: int) -> int:
    """The next of 3, 4, 6, 8, 12, 16, ... (grids of the transit that refine in factors 4/3 and 3/2)."""
    power = 1 << max(1, steps.bit_length() - 1)
    return next(n for n in (power, 3 * power // 2, 2 * power, 3 * power) if n > steps)
