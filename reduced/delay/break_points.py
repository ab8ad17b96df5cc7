"""The delay system for jumps or kinks whose echoes fall within equal steps: here steps end on the break points.

A jump at t = 0 returns after every round trip, and after every sum of round trips, for ever (MODEL.md section 7). The same holds
for the kink that a knot of the drive causes. Breaks are measured: at each step's start the waves just launched at every end of
every layer are compared, in value and in slope, with those of the step before. If the difference is above the tolerance, the time
at which it arrives at the layer's other end becomes a break point, where a step will end. Smaller breaks are no longer followed.
"""

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from reduced.delay.alike import next_count
from reduced.delay.alike_kernel import PSI, TIME
from reduced.delay.network import DelayNetwork, tops_for
from reduced.delay.transmission_lines import Lines
from slipwave.errors import NumericsError
from slipwave.friction import respond
from slipwave.observe.pieces import SAME, Pieces, empty_pieces, interpolation_matrix, lagrange_basis
from slipwave.observe.restoring import tables, whole_numbers
from slipwave.observe.solver import State
from slipwave.scene import Scene
from slipwave.step.guess import DONE
from slipwave.step.rows import UNKNOWN

_RING = 8192
_PIECES = 256
_SAME = 1e-10
_SHORTEST = 1e-7
_KINK = 100.0  # smallest kink over the largest coefficient left out of a step: slopes are so much less accurate than values


class DelayBreaks(DelayNetwork):
    """As `DelayNetwork`, with steps of varying length that end where a break arrives; costs about 0.2 ms per step.

    A node reads its delayed waves from the past step in which they left, by interpolation. Equal steps need a projection
    (`delay_rows`), because some delays amplify noise at every return; steps of varying length do not: for such delays psi(600)
    agrees with the full wave to 2e-11, at a tolerance of 1e-9 and with no more steps.

    `break_points` counts the jumps and kinks that were followed. Raises NumericsError if they need more than the stored history.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-9, lines: Lines | None = None) -> None:
        super().__init__(scene, tolerance, lines=lines)
        layers, each = self._lines.travel.size, (self._lines.travel.size, self._stages)
        weights = np.zeros((*each, self._stages, self._stages))  # every node reads from a step of its own
        self._network = self._network._replace(
            whole=np.zeros(layers, dtype=np.bool_), back=np.zeros(each, dtype=np.int64), weights=weights
        )
        psi, z = scene.steady_psi, float(self._memory.guess[UNKNOWN, 0])
        self._smallest_jump = tolerance * respond(scene.law, z, psi)[3]
        basis = lagrange_basis(self.nodes)
        self._left = interpolation_matrix(basis, np.zeros(1))[0]
        self._slope_left, self._slope_right = self._left @ basis.derivative, basis.derivative[-1]
        self._smallest_kink = max(self._smallest_jump, _KINK * self._tolerances[1] * respond(scene.law, z, psi)[3])
        self._start_times, self._lengths, self._filled = np.empty(_RING), np.ones(_RING), 0
        self._memory = self._memory._replace(waves=np.zeros((layers, 2, _RING, self._stages)))
        self._arrivals = [float(time) for time in scene.drive.knots if time > 0.0]
        self.break_points = 0

    def advance(self, until: float) -> Pieces:
        """March to the first end of a step at or beyond `until`, but at most one chunk; see `Solver`."""
        pieces = empty_pieces(_PIECES, self._stages)
        k = 0
        while k < _PIECES and self.time < until - SAME:
            if self._step(Pieces(*(array[k : k + 1] for array in pieces))):
                k += 1
        return Pieces(*(array[:k] for array in pieces))

    def _step(self, piece: Pieces) -> bool:
        """March one step, at most to the next break point. Returns False if it was rejected; the longest step is shorter then."""
        now, slot = self._memory.now, int(self._memory.cursor[0])
        while self._arrivals and self._arrivals[0] < now[TIME] + _SHORTEST:
            heapq.heappop(self._arrivals)
        left = self._arrivals[0] - now[TIME] if self._arrivals else math.inf
        length = left / math.ceil(left / self._length - _SAME) if left < 64.0 * self._length else self._length
        start = float(now[TIME])
        self._look_back(start, length, slot)
        steps, verdict = self._march(start, 0, length, 1, piece)
        if verdict != DONE:
            self._refine(verdict)
            return False
        self._start_times[slot], self._lengths[slot], self._filled = start, length, min(self._filled + 1, _RING)
        if abs(left - length) < _SAME:
            now[TIME] = heapq.heappop(self._arrivals)
            self._forget_guess()
        self._follow_breaks(slot, start)
        return steps == 1

    def _look_back(self, start: float, length: float, slot: int) -> None:
        """Set the past step and the weights from which each node of the next step reads its delayed waves (none before t = 0)."""
        network = self._network
        wanted = start + self.nodes * length - self._lines.travel[:, None]
        order = self._order(slot)
        past = self._start_times[order]
        if order.size == _RING and wanted.min() < past[0]:
            raise NumericsError(
                f"delay: more than {_RING} break points within a travel time at t = {start:.6g} transits (scene "
                f"{self.scene.name!r}, digest {self.scene.digest})"
            )
        row = np.searchsorted(past, wanted - _SAME) - 1
        exists = (row >= 0) & (wanted > _SAME)
        chosen = order[np.clip(row, 0, None)] if order.size else np.zeros_like(row)
        local = np.clip((wanted - self._start_times[chosen]) / self._lengths[chosen], 0.0, 1.0)
        weights = interpolation_matrix(lagrange_basis(self.nodes), np.where(exists, local, 0.5).ravel())
        node = np.arange(self._stages)
        network.weights[:, node, node] = weights.reshape(*wanted.shape, -1) * exists[:, :, None]
        network.back[:] = (slot - chosen) % _RING
        compliance, inertia = tops_for(self._lines, length, self._stages)
        self._network = network._replace(compliance=compliance, inertia=inertia)

    def _order(self, slot: int) -> NDArray[np.int64]:
        """Ring indices of the past steps, oldest first; `slot` is that of the next one."""
        return (slot - self._filled + np.arange(self._filled)) % _RING

    def _follow_breaks(self, slot: int, start: float) -> None:
        """Add the arrivals of the waves that have just jumped or kinked to the break points."""
        waves = self._memory.waves
        now, before = waves[:, :, slot], waves[:, :, slot - 1] if start > 0.0 else np.zeros(waves[:, :, slot].shape)
        jumps = np.abs(now @ self._left - before[:, :, -1])
        slopes = now @ self._slope_left / self._lengths[slot] - before @ self._slope_right / self._lengths[slot - 1]
        broken = (jumps > self._smallest_jump) | (np.abs(slopes) * self._length > self._smallest_kink)
        for layer in np.flatnonzero(broken.any(axis=1)):
            arrival = start + float(self._lines.travel[layer])
            if not any(abs(arrival - known) < _SHORTEST for known in self._arrivals):
                heapq.heappush(self._arrivals, arrival)
                self.break_points += 1

    def _forget_guess(self) -> None:
        """Take constants as the guess: polynomials cannot be extended beyond a break point."""
        guess = self._memory.guess
        guess[0] = self._memory.now[PSI]
        guess[UNKNOWN] = guess[UNKNOWN, 0]

    def _refine(self, verdict: int) -> None:
        """Shorten the longest step; past steps keep their own lengths."""
        self._require_room(verdict)
        self._count = next_count(self._count)
        self._forget_guess()

    def state(self) -> State:
        """As `Solver`: start and length of the `past` steps (steps, 2), the `waves` launched in them (layers, 2, steps, s), the
        next break points as a heap, `arrivals` (points, 1), and the present state; `counts`: longest steps in their span, break
        points, failures, iterations."""
        memory, order = self._memory, self._order(int(self._memory.cursor[0]))
        return {
            "counts": np.array([self._count, self.break_points, self.failures, self.iterations], dtype=float),
            "past": np.column_stack([self._start_times[order], self._lengths[order]]),
            "waves": memory.waves[:, :, order],
            "arrivals": np.array(self._arrivals, dtype=float)[:, None],
            "tops": memory.tops.copy(),
            "guess": memory.guess.copy(),
            "now": memory.now.copy(),
        }

    def restore(self, state: State) -> None:
        """As `Solver`."""
        count, points, failures, iterations = whole_numbers(state, "counts", (1, 0, 0, 0))
        steps = min(state["past"].shape[0] if "past" in state else 0, _RING)
        shapes = {"past": (steps, 2), "waves": (self._lines.travel.size, 2, steps, self._stages), "arrivals": (-1, 1)}
        saved = tables(state, shapes | self._present(), self.model)
        self._count, self.break_points, self.failures, self.iterations = count, points, failures, iterations
        self._filled, self._arrivals = steps, saved["arrivals"].ravel().tolist()
        self._start_times[:steps], self._lengths[:steps] = saved["past"].T
        self._memory.waves[:, :, :steps] = saved["waves"]
        present = {name: saved[name] for name in self._present()}
        self._memory = self._memory._replace(cursor=np.array([steps % _RING]), **present)
