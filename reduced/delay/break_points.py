"""The delay system for jumps or kinks whose echoes fall within equal steps: here steps end on the break points.

A jump at t = 0 returns after every round trip, and after every sum of round trips, for ever (MODEL.md section 7). The same holds
for the kink that a knot of the drive causes, and for the jump of a higher derivative that it causes behind a mass. Breaks are
measured: at each step's start the waves just launched at every end of every layer are compared, in value and three derivatives,
with those of the step before. If a step without an end there would err by more than the tolerance, its arrival at the layer's
other end becomes a break point, where a step ends. Smaller breaks are not followed.
"""

import numpy as np

from reduced.delay.break_kernel import FILLED, FOLLOWED, TOO_MANY, WAITING, Ends, History, march_breaks
from reduced.delay.kernel import DelayMemory
from reduced.delay.march import next_count
from reduced.delay.network import DelayNetwork
from reduced.delay.transmission_lines import NODES, Lines
from slipwave.errors import NumericsError
from slipwave.friction import respond
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene
from slipwave.solve import State, tables, whole_numbers
from slipwave.step.collocation import radau
from slipwave.step.nodal import PSI, TIME, Interface, constant_guess

_RING = 8192
_PIECES = 256
_DERIVATIVES = 3  # a jump of V makes a face with a mass and no dashpot jump in the second, a kink of V in the third


class DelayBreaks(DelayNetwork):
    """As `DelayNetwork`, with steps of varying length that end where a break arrives; about 4 microseconds per step.

    Delayed waves at a node are interpolated in the past step in which they left. Equal steps need a projection (`delay_rows`),
    because some delays amplify noise at every return; steps of varying length do not: for such delays psi(600) agrees with the
    full wave to 2e-11, at a tolerance of 1e-9 and with no more steps.

    `break_points` counts the jumps and kinks that were followed. Raises NumericsError if they need more than the stored history.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-9, lines: Lines | None = None) -> None:
        super().__init__(scene, tolerance, lines=lines)
        layers, each = self._layers.travel.size, (self._layers.travel.size, self._stages)
        weights = np.zeros((*each, 1, self._stages))  # every node reads from a step of its own
        network = self._lines.network._replace(
            whole=np.zeros(layers, dtype=np.bool_), back=np.zeros(each, dtype=np.int64), weights=weights
        )
        self._lines = self._lines._replace(network=network, waves=np.zeros((layers, 2, _RING, self._stages)))
        self._ends = self._ends_for(tolerance)
        self._remember(np.empty((0, 2)), np.array([time for time in scene.drive.knots if time > 0.0]), 0)

    @property
    def break_points(self) -> int:
        """Number of jumps and kinks followed so far."""
        return int(self._history.counts[FOLLOWED])

    def advance(self, until: float) -> Pieces:
        """March to the first end of a step at or beyond `until`, but at most one chunk; see `Solver`."""
        pieces = empty_pieces(_PIECES, self._stages)
        while True:
            trail = (self._history, self._ends._replace(longest=self._length))
            march = (self._physics, self._lines, self._memory, self._nodal, trail, self._limits, until - SAME)
            steps, iterations, verdict = march_breaks(self._shape, *march, pieces)
            self.iterations += iterations
            if steps:
                return pieces.part(slice(steps))
            self._refine(verdict)

    def _ends_for(self, tolerance: float) -> Ends:
        scene, lines, basis = self.scene, self._layers, lagrange_basis(self.nodes)
        friction_z = respond(scene.law, float(self._memory.guess.z[0]), scene.steady_psi)[3]
        each = [np.linalg.matrix_power(basis.derivative, m) for m in range(_DERIVATIVES + 1)]
        left = interpolation_matrix(basis, np.zeros(1))[0]
        return Ends(
            travel=lines.travel,
            left=np.array([left @ one for one in each]),
            right=np.array([one[-1] for one in each]),
            barycentric=basis.weights,
            resistance=np.array([top.dashpot for top in lines.tops]) + lines.impedance[list(lines.last)],
            mass=np.array([top.mass for top in lines.tops]),
            inverse=radau(self._stages).inverse,
            system=np.zeros((self._stages, 2 * self._stages)),
            coefficients=np.asarray(np.linalg.inv(np.polynomial.legendre.legvander(2.0 * self.nodes - 1.0, NODES - 1)), float),
            smallest=tolerance * friction_z,
            longest=self._length,
        )

    def _remember(self, past: Array, arrivals: Array, followed: int) -> None:
        """Set the history to these past steps (start and length) and next break points."""
        counts = np.array([past.shape[0], arrivals.size, followed])
        present, nearby = (np.zeros(2), np.zeros(1)), np.zeros(self._layers.travel.size, dtype=np.int64)
        self._history = History(np.empty(_RING), np.ones(_RING), np.empty(_RING + arrivals.size), counts, present, nearby)
        self._history.starts[: past.shape[0]], self._history.lengths[: past.shape[0]] = past.T
        self._history.arrivals[: arrivals.size] = arrivals

    def _refine(self, verdict: int) -> None:
        """Shorten the longest step; past steps keep their own lengths."""
        if verdict == TOO_MANY:
            raise NumericsError(
                f"delay: more than {_RING} break points within a travel time at t = {self._memory.now[TIME]:.6g} transits (scene "
                f"{self.scene.name!r}, digest {self.scene.digest})"
            )
        self._require_shorter(verdict)
        self._count = next_count(self._count)
        self._memory = DelayMemory(
            constant_guess(self._memory.now[PSI], self._memory.guess.z[0], self._stages), self._memory.now
        )  # polynomials fit the old lengths

    def state(self) -> State:
        """As `Solver`: start and length of the `past` steps (steps, 2), the `waves` launched in them (layers, 2, steps, s), the
        next break points in order, `arrivals` (points, 1), and the present state; `counts`: longest steps in their span, break
        points, failures, iterations."""
        lines, memory, history = self._lines, self._memory, self._history
        filled, waiting, followed = (int(count) for count in history.counts[[FILLED, WAITING, FOLLOWED]])
        order = (int(lines.cursor[0]) - filled + np.arange(filled)) % _RING
        return {
            "counts": np.array([self._count, followed, self.failures, self.iterations], dtype=float),
            "past": np.column_stack([history.starts[order], history.lengths[order]]),
            "waves": lines.waves[:, :, order],
            "arrivals": history.arrivals[:waiting, None].copy(),
            "tops": lines.tops.copy(),
            "guess": np.stack(memory.guess),
            "now": memory.now.copy(),
        }

    def restore(self, state: State) -> None:
        """As `Solver`."""
        count, points, failures, iterations = whole_numbers(state, "counts", (1, 0, 0, 0))
        steps = min(state["past"].shape[0] if "past" in state else 0, _RING)
        shapes = {"past": (steps, 2), "waves": (self._layers.travel.size, 2, steps, self._stages), "arrivals": (-1, 1)}
        saved = tables(state, shapes | self._present(), self.model)
        self._count, self.failures, self.iterations = count, failures, iterations
        self._remember(saved["past"], saved["arrivals"].ravel(), points)
        self._lines.waves[:, :, :steps] = saved["waves"]
        self._lines = self._lines._replace(tops=saved["tops"], cursor=np.array([steps % _RING]))
        self._memory = DelayMemory(Interface(*saved["guess"]), saved["now"])
