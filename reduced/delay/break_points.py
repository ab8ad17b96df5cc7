"""The delay system when jumps or kinks echo where no equal steps can end: steps end on the break points.

A jump at t = 0 returns with every round trip, and with every sum of round trips, for ever (MODEL.md section 7); so does the kink
that a knot of the drive makes. What breaks is measured: at each step's start the waves just launched at every end of every layer
are compared, in value and in slope, with those of the step before; a break above the tolerance makes its arrival at the layer's
other end a break point, where a step will end. Breaks that have faded are forgotten.
"""

import heapq
import math

import numpy as np

from reduced.delay.alike_kernel import PSI, TIME
from reduced.delay.network import DelayNetwork
from reduced.step.guess import DONE
from reduced.step.newton import UNKNOWN
from slipwave.errors import NumericsError
from slipwave.friction import respond
from slipwave.observe.pieces import Pieces, empty_pieces, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene

_RING = 8192
_PIECES = 256
_SAME = 1e-10
_SHORTEST = 1e-7
_KINK = 100.0  # smallest kink over the largest coefficient left out of a step: slopes are that much less certain than values


class DelayBreaks(DelayNetwork):
    """As `DelayNetwork`, with steps of varying length that end where a break arrives; costs about 0.2 ms a step.

    `break_points` counts the jumps and kinks that were followed. Raises NumericsError where they outgrow the stored history.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-9) -> None:
        super().__init__(scene, tolerance)
        self._network = self._network._replace(whole=False)
        psi, z = scene.steady_psi, float(self._memory.guess[UNKNOWN, 0])
        self._smallest_jump = tolerance * respond(scene.law, z, psi)[3]
        basis = lagrange_basis(self.nodes)
        self._left = interpolation_matrix(basis, np.zeros(1))[0]
        self._slope_left, self._slope_right = self._left @ basis.derivative, basis.derivative[-1]
        self._smallest_kink = max(self._smallest_jump, _KINK * self._tolerances[1] * respond(scene.law, z, psi)[3])
        self._start_times, self._lengths = np.full(_RING, np.nan), np.ones(_RING)
        layers = self._lines.travel.size
        self._memory = self._memory._replace(waves=np.zeros((layers, 2, _RING, self._stages)))
        self._arrivals = [float(time) for time in scene.drive.knots if time > 0.0]
        self.break_points = 0

    def advance(self, until: float) -> Pieces:
        """March to the first step end at or beyond `until`, at most one chunk; see `Solver`."""
        pieces = empty_pieces(_PIECES, self._stages)
        k = 0
        while k < _PIECES and self.time < until - 1e-9:
            if self._step(Pieces(*(array[k : k + 1] for array in pieces))):
                k += 1
        return Pieces(*(array[:k] for array in pieces))

    def _step(self, piece: Pieces) -> bool:
        """One step to the next break point at most; False if it was refused and the longest step has been halved."""
        now, slot = self._memory.now, int(self._memory.cursor[0])
        full = self._length
        while self._arrivals and self._arrivals[0] < now[TIME] + _SHORTEST:
            heapq.heappop(self._arrivals)
        left = self._arrivals[0] - now[TIME] if self._arrivals else math.inf
        length = left / math.ceil(left / full - _SAME) if left < 64.0 * full else full
        start = float(now[TIME])
        self._look_back(start, length, slot)
        self._length = length
        steps, verdict = self._march(1, piece)
        self._length = full
        if verdict != DONE:
            self._refine(verdict)
            return False
        self._start_times[slot], self._lengths[slot] = start, length
        if abs(left - length) < _SAME:
            now[TIME] = heapq.heappop(self._arrivals)
            self._forget_guess()
        self._follow_breaks(slot, start)
        return steps == 1

    def _look_back(self, start: float, length: float, slot: int) -> None:
        """Fill in where each node of the step to come finds its delayed waves; before t = 0 there were none."""
        network = self._network
        wanted = start + self.nodes * length - self._lines.travel[:, None]
        oldest = int(np.isnan(self._start_times).argmax()) if np.isnan(self._start_times).any() else _RING
        filled = min(oldest, _RING)
        order = (slot - filled + np.arange(filled)) % _RING
        past = self._start_times[order]
        if filled == _RING and wanted.min() < past[0]:
            raise NumericsError(
                f"delay: more than {_RING} break points within a travel time at t = {start:.6g} transits (scene "
                f"{self.scene.name!r}, digest {self.scene.digest})"
            )
        row = np.searchsorted(past, wanted - _SAME) - 1
        exists = (row >= 0) & (wanted > _SAME)
        chosen = order[np.clip(row, 0, None)] if filled else np.zeros_like(row)
        local = np.clip((wanted - self._start_times[chosen]) / self._lengths[chosen], 0.0, 1.0)
        weights = interpolation_matrix(lagrange_basis(self.nodes), np.where(exists, local, 0.5).ravel())
        network.weights[:] = weights.reshape(network.weights.shape) * exists[:, :, None]
        network.back[:] = (slot - chosen) % _RING
        self._network = network._replace(grip=self._grip_response(length))

    def _follow_breaks(self, slot: int, start: float) -> None:
        """Make break points of the arrivals of what has just jumped or kinked."""
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
        """After a break point no polynomial extends."""
        guess = self._memory.guess
        guess[0] = self._memory.now[PSI]
        guess[UNKNOWN] = guess[UNKNOWN, 0]

    def _refine(self, verdict: int) -> None:
        """Half the longest step; the history keeps its own lengths."""
        self._require_room(verdict)
        self._length *= 0.5
        self._forget_guess()
