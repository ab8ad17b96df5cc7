"""The exact delay system of any pair of lossless slabs: unlike, layered, gripped, reflecting, round trips commensurate or not."""

import math

import numpy as np

from reduced.delay.alike import collocation_matrices, dense_resolution
from reduced.delay.alike_kernel import ELASTIC, PSI, TIME
from reduced.delay.march import DelayMarch
from reduced.delay.network_kernel import Integers, Network, NetworkMemory, march_network
from reduced.delay.transmission_lines import common_step, lines_of
from reduced.step.collocation import growth_limit, radau
from reduced.step.guess import DONE, first_guess
from slipwave.friction import unknown_of
from slipwave.observe.pieces import Array, Pieces, empty_pieces, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene

NODES = 8
MAX_STEPS = 4096
_FEWEST = 3.0
_CHUNK = 2048


class DelayNetwork(DelayMarch):
    """Marches the exact system to `tolerance`, the requested relative error of the cycle's figures.

    The step divides every travel time where these have a common divisor: break points then lie on steps, and a jump start keeps
    its accuracy. Otherwise delayed waves are interpolated within their step to the same tolerance (and a jump start takes
    `DelayBreaks`). A step that is too coarse is halved for good, the stored waves resampled. `failures` counts unconverged
    solves: a step that cannot be solved with MAX_STEPS a transit raises NumericsError.
    """

    _memory: NetworkMemory

    def __init__(self, scene: Scene, tolerance: float = 1e-9, nodes: int = NODES) -> None:
        super().__init__(scene)
        self._stages = nodes
        self.nodes, self._matrices = collocation_matrices(nodes)
        self._steepest = growth_limit(nodes, tolerance)
        self._tolerances = (max(1e-3 * tolerance, 1e-14), dense_resolution(tolerance, nodes), self._steepest)
        self._lines = lines_of(scene)
        divisor = common_step(self._lines)
        self._commensurate = divisor is not None
        longest = min(1.0 / _FEWEST, float(self._lines.travel.min()))
        self._length = divisor / max(1, math.ceil(divisor / longest)) if divisor else longest
        self._network = self._compile()
        self._memory = self._begin()
        self._origin, self._done = 0.0, 0

    @property
    def steps(self) -> float:
        """Steps a transit in use now."""
        return 1.0 / self._length

    def advance(self, until: float) -> Pieces:
        """March to the first step end at or beyond `until`, at most one chunk; see `Solver`."""
        while True:
            count = min(_CHUNK, max(1, math.ceil((until - self.time) / self._length - 1e-6)))
            pieces = empty_pieces(count, self._stages)
            steps, verdict = self._march(count, pieces)
            self._done += steps
            self._memory.now[TIME] = self._origin + self._done * self._length  # a sum of steps would drift
            if verdict != DONE:
                self._refine(verdict)
            if steps:
                return Pieces(*(array[:steps] for array in pieces))

    def _march(self, count: int, pieces: Pieces) -> tuple[int, int]:
        """(steps kept, verdict) of `count` steps."""
        rule = (self._matrices.integral, self._matrices.predict, self._matrices.predict_state, self._matrices.tail)
        systems = (
            tuple(self.nodes),
            self.scene.law,
            self._network,
            self.scene.forcing,
            self.scene.drive.compiled,
            *rule,
            self._memory,
        )
        steps, iterations, verdict = march_network(*systems, self._length, count, *self._tolerances, pieces)
        self.iterations += iterations
        return steps, verdict

    def _compile(self) -> Network:
        """The lines with the delays of the present step length."""
        lines, scene = self._lines, self.scene
        back, weights = delay_rows(lines.travel / self._length, self.nodes)
        return Network(
            lines.impedance,
            back,
            weights,
            self._commensurate,
            np.array(lines.first),
            np.array(lines.last),
            lines.follow,
            lines.yield_,
            lines.spring,
            self._grip_response(self._length),
            scene.impedance,
            scene.steady_stress + scene.impedance * scene.velocity,
            lines.weight,
        )

    def _grip_response(self, length: float) -> Array:
        """(1 + h K yield A)^-1 of every slab for a step of `length`."""
        h_spring = length * self._lines.spring * self._lines.yield_
        inverse = np.linalg.inv(np.eye(self._stages) + h_spring[:, None, None] * radau(self._stages).integral)
        return np.asarray(inverse, dtype=float)

    def _begin(self) -> NetworkMemory:
        """Steady sliding, no wave, psi displaced if the start is a jump."""
        scene = self.scene
        now = np.zeros(3)
        now[PSI], now[ELASTIC] = scene.steady_psi + scene.start.jump_size, scene.steady_stress
        waves = np.zeros((self._lines.travel.size, 2, int(self._network.back.max()) + 1, self._stages))
        guess = np.full((2, self._stages), now[PSI])
        steady = np.full(self._stages, self._network.base)
        start = unknown_of(scene.law, scene.velocity)
        self.failures += first_guess(scene.law, scene.impedance, steady, now[PSI], start, guess[1])
        return NetworkMemory(waves, np.zeros(self._lines.spring.size), guess, now, np.zeros(1, dtype=np.int64))

    def _refine(self, verdict: int) -> None:
        """Half the step: the stored waves are evaluated at the nodes of the two halves of each step."""
        self._require_room(verdict)
        old = self._memory
        self._origin, self._done = self.time, 0
        self._length *= 0.5
        self._network = self._compile()
        halves = interpolation_matrix(lagrange_basis(self.nodes), np.r_[0.5 * self.nodes, 0.5 + 0.5 * self.nodes])
        ordered = np.roll(old.waves, -int(old.cursor[0]), axis=2)
        layers, _, ring, stages = ordered.shape
        finer = (ordered @ halves.T).reshape(layers, 2, 2 * ring, stages)
        wanted = int(self._network.back.max()) + 1
        waves = np.ascontiguousarray(
            finer[:, :, -wanted:] if wanted <= 2 * ring else np.pad(finer, ((0, 0), (0, 0), (wanted - 2 * ring, 0), (0, 0)))
        )
        guess = np.repeat([[old.now[PSI]], [float(old.guess[1, 0])]], stages, axis=1)
        self._memory = NetworkMemory(waves, old.grip, guess, old.now, np.zeros(1, dtype=np.int64))

    def _require_room(self, verdict: int) -> None:
        """NumericsError unless the step may still be halved."""
        if 2.0 / self._length > MAX_STEPS / min(1.0, 2.0 * float(self._lines.travel.min())):
            raise self._unresolved(self.steps, verdict)


def delay_rows(steps_back: Array, nodes: Array) -> tuple[Integers, Array]:
    """How many steps each node looks back for a delay of `steps_back` (L,) steps, (L, s), and the weights there, (L, s, s)."""
    place = nodes - steps_back[:, None]
    back = -np.floor(place - 1e-9).astype(np.int64)
    local = np.clip(place + back, 0.0, 1.0)
    basis = lagrange_basis(nodes)
    snapped = np.array([[_snap(x, nodes) for x in row] for row in local])
    weights = interpolation_matrix(basis, snapped.ravel()).reshape(*local.shape, nodes.size)
    return back, weights


def _snap(point: float, nodes: Array) -> float:
    nearest = float(nodes[np.abs(nodes - point).argmin()])
    return nearest if abs(nearest - point) < 1e-9 else point
