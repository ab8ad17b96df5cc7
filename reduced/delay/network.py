"""The exact delay system of any pair of lossless slabs: unlike, layered, any outer face, round trips commensurate or not."""

import math
from functools import cache

import numpy as np

from reduced.delay.alike import dense_resolution, next_count
from reduced.delay.alike_kernel import ELASTIC, PSI
from reduced.delay.march import DelayMarch
from reduced.delay.network_kernel import Integers, Network, NetworkMemory, march_network, passage_of
from reduced.delay.transit_mesh import TransitMesh
from reduced.delay.transmission_lines import Lines, lines_of
from slipwave.friction import unknown_of
from slipwave.observe.pieces import Array, Basis, Pieces, empty_pieces, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene
from slipwave.solve import State, tables, whole_numbers
from slipwave.step.collocation import from_moments, growth_limit, radau, rule_of
from slipwave.step.guess import first_guess
from slipwave.step.rows import scratch_of

NODES = 8
MAX_STEPS = 4096
MOST_STEPS = 1 << 20  # in the span that they divide; more than MAX_STEPS allows
SAME_PLACE = 1e-9  # of a step; two places that differ by less are one
_FEWEST = 3
_CHUNK = 2048


class DelayNetwork(DelayMarch):
    """Marches the exact system to `tolerance`, the requested relative error of the cycle's figures.

    If all travel times have a common divisor, the step divides it: break points then lie on the ends of steps, and a jump start
    keeps its accuracy. Otherwise delayed waves are projected onto the polynomials of a step (and a jump start needs
    `DelayBreaks`). Where a step is too long, all are shorter for the rest of the run, and the stored waves are resampled.
    `failures` counts unconverged solves; a step that cannot be solved with MAX_STEPS per transit raises NumericsError.
    """

    _memory: NetworkMemory

    def __init__(self, scene: Scene, tolerance: float = 1e-9, lines: Lines | None = None) -> None:
        super().__init__(scene)
        self.settings = {"nodes": NODES, "tolerance": tolerance}
        self._stages = NODES
        matrices, self._rule, self._shape = rule_of(NODES)
        self.nodes, self._scratch = matrices.nodes, scratch_of(NODES)
        self._steepest = growth_limit(NODES, tolerance)
        self._tolerances = (max(1e-3 * tolerance, 1e-14), dense_resolution(tolerance, NODES), self._steepest)
        self._lines = lines or lines_of(scene)
        longest = min(1.0 / _FEWEST, float(self._lines.travel.min()))
        self._span = self._lines.divisor or _FEWEST * longest
        self._count = max(1, math.ceil(self._span / longest - SAME_PLACE))
        self._network = self._compile(self._length)
        self._memory = self._begin()
        self._origin, self._done = 0.0, 0

    @property
    def _length(self) -> float:
        """Length of a step in transits; of the longest one if break points shorten some steps."""
        return self._span / self._count

    @property
    def steps(self) -> float:
        """The present number of steps per transit."""
        return 1.0 / self._length

    def advance(self, until: float) -> Pieces:
        """March to the first end of a step at or beyond `until`, but at most one chunk; see `Solver`."""
        while True:
            count = min(_CHUNK, max(1, math.ceil((until - self.time) / self._length - 1e-6)))
            pieces = empty_pieces(count, self._stages)
            steps, verdict = self._march(self._origin, self._done, self._length, count, pieces)
            self._done += steps
            if steps:
                return Pieces(*(array[:steps] for array in pieces))
            self._refine(verdict)

    def state(self) -> State:
        """As `Solver`: the ring of waves launched in past steps, and the present state (`NetworkMemory`); `counts`: steps in
        the span that they divide, steps done since `origin`, ring index, failures, iterations."""
        memory = self._memory
        counts = (self._count, self._done, memory.cursor[0], self.failures, self.iterations)
        return {
            "counts": np.array(counts, dtype=float),
            "origin": np.array([self._origin]),
            "waves": memory.waves.copy(),
            "tops": memory.tops.copy(),
            "guess": memory.guess.copy(),
            "now": memory.now.copy(),
        }

    def restore(self, state: State) -> None:
        """As `Solver`."""
        count, done, cursor, failures, iterations = whole_numbers(state, "counts", (1, 0, 0, 0, 0))
        network = self._compile(self._span / min(count, MOST_STEPS))
        layers, ring = network.impedance.size, int(network.back.max()) + 1
        shapes = {"origin": (1,), "waves": (layers, 2, ring, self._stages), **self._present()}
        saved = tables(state, shapes, self.model)
        self._count, self._done, self.failures, self.iterations = count, done, failures, iterations
        self._origin, self._network = float(saved["origin"][0]), network
        self._memory = NetworkMemory(saved["waves"], saved["tops"], saved["guess"], saved["now"], np.array([cursor % ring]))

    def _present(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the arrays that describe the present, in a state."""
        return {"tops": (len(self._lines.tops), 2), "guess": (2, self._stages), "now": (3,)}

    def _march(self, origin: float, done: int, length: float, count: int, pieces: Pieces) -> tuple[int, int]:
        """March `count` steps of `length`, the first of which begins `done` such steps after `origin`; (steps kept, verdict)."""
        scene = self.scene
        physics = (scene.law, self._network, scene.forcing, scene.drive.compiled)
        clock = (origin, done, length, count)
        arrays = (self._memory, passage_of(self._network, NODES), self._scratch)
        march = (*physics, self._rule, *arrays, *clock, *self._tolerances)
        steps, iterations, verdict = march_network(self._shape, *march, pieces)
        self.iterations += iterations
        return steps, verdict

    def _compile(self, length: float) -> Network:
        """The lines in compiled form, with their delays in steps of `length`."""
        return compiled(self.scene, self._lines, length, self.nodes)

    def _begin(self) -> NetworkMemory:
        """Memory at the start: steady sliding without waves, psi displaced if the start is a jump."""
        scene = self.scene
        now = np.zeros(3)
        now[PSI], now[ELASTIC] = scene.steady_psi + scene.start.jump_size, scene.steady_stress
        waves = np.zeros((self._lines.travel.size, 2, int(self._network.back.max()) + 1, self._stages))
        guess = np.full((2, self._stages), now[PSI])
        steady = np.full(self._stages, self._network.base)
        start = unknown_of(scene.law, scene.velocity)
        self.failures += first_guess(scene.law, scene.impedance, steady, now[PSI], start, guess[1])
        return NetworkMemory(waves, np.zeros((len(self._lines.tops), 2)), guess, now, np.zeros(1, dtype=np.int64))

    def _refine(self, verdict: int) -> None:
        """Take shorter steps; the polynomials of the stored waves give the new nodes."""
        if not self._lines.divisor:  # no step has to end on a multiple of the span
            self._origin, self._done = self.time, 0
        self._require_room(verdict)
        before, count = self._length, self._count
        self._count = self._finer()
        self._done = self._done * self._count // count
        self._resample(before, self._length)

    def _resample(self, before: float, length: float) -> None:
        """Go on with steps of `length` after steps of the length `before`."""
        old, self._network = self._memory, self._compile(length)
        ring, wanted = old.waves.shape[2], int(self._network.back.max()) + 1
        past, new = (TransitMesh(n, np.full(n, h), h * np.arange(-n, 0)) for n, h in ((ring, before), (wanted, length)))
        waves = past.resample(np.roll(old.waves, -int(old.cursor[0]), axis=2), self.nodes, new)
        guess = np.repeat([[old.now[PSI]], [float(old.guess[1, 0])]], self._stages, axis=1)
        self._memory = NetworkMemory(waves, old.tops, guess, old.now, np.zeros(1, dtype=np.int64))

    def _finer(self) -> int:
        """The next number of steps in their span of which one ends at the present moment, at the latest twice the present one:
        ends of spans, on which break points fall, then stay ends of steps."""
        count = next_count(self._count)
        while self._done * count % self._count:
            count = next_count(count)
        return count

    def _require_room(self, verdict: int) -> None:
        """Raises NumericsError unless shorter steps may be taken."""
        if self._finer() / self._span > MAX_STEPS / min(1.0, 2.0 * float(self._lines.travel.min())):
            raise self._unresolved(self.steps, verdict)


def compiled(scene: Scene, lines: Lines, length: float, nodes: Array) -> Network:
    """The lines of `scene` in compiled form for equal steps of `length` (transits)."""
    back, weights = delay_rows(lines.travel / length, nodes)
    return Network(
        lines.impedance,
        back,
        weights,
        weights[:, 0, 0, 0] == 1.0,
        np.array(lines.first),
        np.array(lines.last),
        np.array([top.spring for top in lines.tops]),
        *tops_for(lines, length, nodes.size),
        np.array([top.spring > 0.0 or top.mass > 0.0 for top in lines.tops]),
        scene.impedance,
        scene.steady_stress + scene.impedance * scene.velocity,
        lines.weight,
    )


def tops_for(lines: Lines, length: float, stages: int) -> tuple[Array, Array]:
    """`compliance` and `inertia` of the outer faces in a step of `length` (`Network`), (slabs, s, s) each."""
    rule, identity = radau(stages), np.eye(stages)
    inertia = np.array([top.mass / length * rule.inverse for top in lines.tops])
    compliance = np.zeros_like(inertia)
    for slab, top in enumerate(lines.tops):
        if not top.is_rigid:
            resistance = (top.dashpot + lines.impedance[lines.last[slab]]) * identity
            compliance[slab] = np.linalg.inv(inertia[slab] + resistance + length * top.spring * rule.integral)
    return compliance, inertia


def delay_rows(steps_back: Array, nodes: Array) -> tuple[Integers, Array]:
    """For delays of `steps_back` (L,) steps: how many steps back the two lie in which waves left, (L, 2), and their weights,
    (L, 2, s, s).

    The weights give nodal values of the L2 projection of what arrives. With values of the waves themselves, noise in a lossless
    slab would grow whenever it arrives, for some delays by a fifth.
    """
    s, basis, project, points, parts = _projection(nodes.size)
    older = np.ceil(steps_back - SAME_PLACE).astype(np.int64)
    weights = np.zeros((older.size, 2, s, s))
    for layer, share in enumerate(np.clip(older - steps_back, 0.0, 1.0)):
        if share < SAME_PLACE:
            weights[layer, 0] = np.eye(s)
            continue
        for which, (begin, length) in enumerate(((0.0, 1.0 - share), (1.0 - share, share))):
            at = begin + length * points
            moments = length * parts * np.polynomial.legendre.legvander(2.0 * at - 1.0, s - 1).T
            weights[layer, which] = project @ moments @ interpolation_matrix(basis, at + share - which)
    return np.column_stack([older, older - 1]), weights


@cache
def _projection(stages: int) -> tuple[int, Basis, Array, Array, Array]:
    """`stages`; the basis of the nodes and their values from moments; points and weights of a quadrature on the unit step."""
    nodes, (points, weights) = radau(stages).nodes, np.polynomial.legendre.leggauss(stages)
    return stages, lagrange_basis(nodes), from_moments(nodes), 0.5 * (points + 1.0), 0.5 * weights
