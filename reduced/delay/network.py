"""The exact delay system of any pair of lossless slabs: unlike, layered, any outer face, round trips commensurate or not."""

import math

import numpy as np

from reduced.delay.alike import TransitMesh
from reduced.delay.flow import DelayFlow
from reduced.delay.march import DelayMarch, DelayMemory, clock_of, dense_resolution, march_delay, next_count, present
from reduced.delay.network_kernel import Network, lines_with
from reduced.delay.transmission_lines import COINCIDENT, NODES, Lines, lines_of, network_of
from slipwave.observe.pieces import Array, Pieces, empty_pieces
from slipwave.scene import Scene
from slipwave.solve import State, tables, whole_numbers
from slipwave.step.flow import Cycle, InterfaceState
from slipwave.step.nodal import PSI, Interface, constant_guess

MOST_STEPS = 1 << 20  # in the span that they divide; more than MAX_STEPS allows
_FEWEST = 3
_CHUNK = 2048


class DelayNetwork(DelayMarch):
    """Marches the exact system to `tolerance`, the requested relative error of the cycle's figures.

    If all travel times have a common divisor, the step divides it: break points then lie on the ends of steps, and a jump start
    keeps its accuracy. Otherwise delayed waves are projected onto the polynomials of a step (and a jump start needs
    `DelayBreaks`). Where a step is too long, all are shorter for the rest of the run, and the stored waves are resampled.
    `failures` counts unconverged solves; a step that cannot be solved with MAX_STEPS per transit raises NumericsError.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-9, lines: Lines | None = None) -> None:
        super().__init__(scene, NODES, tolerance, dense_resolution(tolerance, NODES))
        self.settings = {"nodes": NODES, "tolerance": tolerance}
        self._layers = lines or lines_of(scene)
        longest = min(1.0 / _FEWEST, float(self._layers.travel.min()))
        self._span = self._layers.divisor or _FEWEST * longest
        self._count = max(1, math.ceil(self._span / longest - COINCIDENT))
        network = self._compile(self._length)
        ring = int(network.back.max()) + 1
        waves, tops = np.zeros((self._layers.travel.size, 2, ring, NODES)), np.zeros((len(self._layers.tops), 2))
        self._lines = lines_with(network, waves, tops)
        psi = scene.steady_psi + scene.start.jump_size
        guess = self._first_guess(scene.impedance, np.full(NODES, network.base), psi)
        self._memory = DelayMemory(guess, present(0.0, psi, scene.steady_stress))
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
            steps, verdict = self._march(self._length, pieces)
            if steps:
                return pieces.part(slice(steps))
            self._refine(verdict)

    def state(self) -> State:
        """As `Solver`: the waves launched in past steps, oldest first, so that states at any two times can be compared, and the
        present state (`NetworkLines`, `DelayMemory`); `counts`: steps in the span that they divide, steps done since `origin`,
        ring index, failures, iterations."""
        lines, memory = self._lines, self._memory
        counts = (self._count, self._done, 0, self.failures, self.iterations)
        return {
            "counts": np.array(counts, dtype=float),
            "origin": np.array([self._origin]),
            "waves": np.roll(lines.waves, -int(lines.cursor[0]), axis=2),
            "tops": lines.tops.copy(),
            "guess": np.stack(memory.guess),
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
        self._origin, self._lines = float(saved["origin"][0]), lines_with(network, saved["waves"], saved["tops"], cursor % ring)
        self._memory = DelayMemory(Interface(*saved["guess"]), saved["now"])

    def _present(self) -> dict[str, tuple[int, ...]]:
        """Shapes of the arrays that describe the present, in a state."""
        return {"tops": (len(self._layers.tops), 2), "guess": (2, self._stages), "now": (4,)}

    def flow(self, period: float, tolerance: float) -> tuple[DelayFlow, Array]:
        """The flow in steps of the present length, and the present state as its state."""
        flow = DelayFlow(self.scene, self.steps)
        waves = np.roll(self._lines.waves, -int(self._lines.cursor[0]), axis=2)
        rest = np.append(self._lines.tops[flow.tops_remembered], self._memory.now[PSI])
        return flow, flow.sampled(waves, self._length, rest)

    def state_at_start(self, cycle: Cycle, interface: InterfaceState) -> State:
        """The state, for `restore`, at the start of `cycle`, a motion of a `DelayFlow`, in steps that are at least as short."""
        saved, length = self.state(), float(cycle.pieces.length[0])
        counts, count = saved["counts"], self._count
        while self._span / count > length / (1.0 - COINCIDENT):
            count = next_count(count)
        flow, start = DelayFlow(self.scene, 1.0 / length).remeshed(cycle, length * count / self._span)
        lines = flow.lines_at(start)
        counts[:3] = count, 0.0, flow.kept
        guess = np.stack(constant_guess(interface.psi, interface.z, self._stages))
        now, origin = present(interface.time, interface.psi, interface.elastic), np.array([interface.time])
        return saved | {"counts": counts, "origin": origin, "waves": lines.waves, "tops": lines.tops, "guess": guess, "now": now}

    def _march(self, length: float, pieces: Pieces) -> tuple[int, int]:
        """March `pieces.time.size` steps of `length`, from `_done` such steps after `_origin`; (steps kept, verdict)."""
        clock = clock_of(self._origin, self._done, pieces.time.size, length)
        march = (self._physics, self._lines, self._memory, self._nodal, clock, self._limits)
        steps, iterations, verdict = march_delay(self._shape, *march, 0, pieces)
        self._done += steps
        self.iterations += iterations
        return steps, verdict

    def _compile(self, length: float) -> Network:
        """The lines in compiled form, with their delays in steps of `length`."""
        return network_of(self.scene, self._layers, length, self.nodes)

    def _refine(self, verdict: int) -> None:
        """Take shorter steps; the polynomials of the stored waves give the new nodes."""
        if not self._layers.divisor:  # no step has to end on a multiple of the span
            self._origin, self._done = self.time, 0
        self._require_shorter(verdict)
        before, count = self._length, self._count
        self._count = self._finer()
        self._done = self._done * self._count // count
        self._resample(before, self._length)

    def _resample(self, before: float, length: float) -> None:
        """Resample the waves of steps of length `before` for steps of `length`."""
        old, network, memory = self._lines, self._compile(length), self._memory
        ring, wanted = old.waves.shape[2], int(network.back.max()) + 1
        past, new = (TransitMesh(n, np.full(n, h), h * np.arange(-n, 0)) for n, h in ((ring, before), (wanted, length)))
        waves = past.resample(np.roll(old.waves, -int(old.cursor[0]), axis=2), self.nodes, new)
        self._lines = lines_with(network, waves, old.tops)
        self._memory = DelayMemory(constant_guess(memory.now[PSI], float(memory.guess.z[0]), self._stages), memory.now)

    def _finer(self) -> int:
        """The next number of steps per span, at most twice the present one, for which a step ends at the present time: ends of
        spans, on which break points fall, stay ends of steps."""
        count = next_count(self._count)
        while self._done * count % self._count:
            count = next_count(count)
        return count

    def _require_shorter(self, verdict: int) -> None:
        """Raises NumericsError unless shorter steps may be taken."""
        if self._finer() / self._span > self._most_steps / min(1.0, 2.0 * float(self._layers.travel.min())):
            raise self._unresolved(self.steps, verdict)
