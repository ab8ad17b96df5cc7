"""The delay system for jumps or kinks whose echoes fall within equal steps: here steps end on the break points.

A jump at t = 0 returns after every round trip, and after every sum of round trips, for ever (MODEL.md section 7). The same holds
for the kink that a knot of the drive causes, and for the jump of a higher derivative that it causes behind a mass. Breaks are
measured: at each step's start the waves just launched at every end of every layer are compared, in value and three derivatives,
with those of the step before. If a step without an end there would err by more than the tolerance, its arrival at the layer's
other end becomes a break point, where a step ends. Smaller breaks are not followed. Where none is left, because sliding has
damped all echoes, steps are equal, as in any network, until V has its next kink. Delayed waves are interpolated.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.delay.alike import TransitMesh
from reduced.delay.leaping_network import LeapingNetwork
from reduced.delay.march import Clock, DelayMemory, march_delay, next_count
from reduced.delay.network_kernel import INWARD, OUTWARD, Integers, Network, NetworkLines, lines_with
from reduced.delay.transmission_lines import NODES, Lines
from slipwave.compiled import njit
from slipwave.errors import NumericsError
from slipwave.friction import respond
from slipwave.observe.pieces import SAME, Array, Pieces, empty_pieces, interpolation_matrix, lagrange_basis
from slipwave.scene import Scene
from slipwave.solve import State, tables, whole_numbers
from slipwave.step.collocation import Nodes, Rule, radau
from slipwave.step.newton import eliminate
from slipwave.step.nodal import DONE, PSI, TIME, Interface, Limits, Nodal, Physics, constant_guess, hold

TOO_MANY = 10
"""Verdict: the history or the list of arrivals is full."""

SHORTEST = 1e-7
_SAME = 1e-10
_LONGER = 4.0  # where a break arrives, steps are at most so much longer than where it was launched
FILLED, WAITING, FOLLOWED = range(3)  # `_History.counts`

_RING = 8192
_PIECES = 256
_SOON = 64.0  # steps; equal steps are not worth while before a kink of V that lies nearer
_DERIVATIVES = 3  # a jump of V makes a face with a mass and no dashpot jump in the second, a kink of V in the third


class _History(NamedTuple):
    """`starts` and `lengths` (ring,) of past steps; `arrivals` (n,), the next break points in order; `counts` (3,): past steps
    known, break points to come, break points passed. Begin (2,) and length (1,) of the `present` step. `nearby` (layers,): ring
    index of the step that was read last."""

    starts: Array
    lengths: Array
    arrivals: Array
    counts: Integers
    present: tuple[Array, Array]
    nearby: Integers


class _Ends(NamedTuple):
    """`travel` (layers,); rows (4, s) that give value and first three derivatives of a step's polynomial, over its length, at its
    `left` and at its `right` end; the nodes' `barycentric` weights; per slab `resistance` Z_g + e and `mass` of its top;
    `inverse` (s, s) A^-1; scratch (s, 2s) to invert `system`; `coefficients` (s, s), rows that give the Legendre coefficients;
    the `smallest` error that makes a break point; the `longest` step (transits)."""

    travel: Array
    left: Array
    right: Array
    barycentric: Array
    resistance: Array
    mass: Array
    inverse: Array
    system: Array
    coefficients: Array
    smallest: float
    longest: float


@njit
def _look_back(nodes: Nodes, ends: _Ends, network: Network, history: _History, slot: int, start: float, length: float) -> bool:
    """Set, for each node of the next step (`slot` in the ring), the past step and the weights that interpolate its delayed waves
    (none before t = 0). False if the ring does not reach back so far."""
    s, ring, known = len(nodes), history.starts.size, history.counts[FILLED]
    for layer in range(ends.travel.size):
        age = (slot - history.nearby[layer]) % ring
        age = age if 0 < age <= known else known
        for j in range(s):
            wanted = start + nodes[j] * length - ends.travel[layer]
            network.back[layer, j] = 0
            for k in range(s):
                network.weights[layer, j, 0, k] = 0.0
            if wanted <= _SAME or known == 0:
                continue
            while age < known and not _starts_before(history, slot, age, wanted):
                age += 1
            while age > 1 and _starts_before(history, slot, age - 1, wanted):
                age -= 1
            past = slot - age if slot >= age else slot - age + ring
            if age == ring and history.starts[past] > wanted:
                return False
            history.nearby[layer] = past
            network.back[layer, j] = age
            local = min(1.0, max(0.0, (wanted - history.starts[past]) / history.lengths[past]))
            _weigh(nodes, ends.barycentric, local, network.weights[layer, j, 0])
    return True


@njit
def _starts_before(history: _History, slot: int, age: int, time: float) -> bool:
    """Whether the step that lies `age` steps before the one in the `slot` starts before `time`."""
    return bool(history.starts[slot - age if slot >= age else slot - age + history.starts.size] < time - _SAME)


@njit
def _weigh(nodes: Nodes, barycentric: Array, local: float, weights: Array) -> None:
    """Set the `weights` (s,) that interpolate a step's polynomial at `local`, a share of its length."""
    total, hit = 0.0, -1
    for k in range(len(nodes)):
        gap = local - nodes[k]
        if gap == 0.0:
            hit = k
        else:
            weights[k] = barycentric[k] / gap
            total += weights[k]
    for k in range(len(nodes)):
        weights[k] = (1.0 if k == hit else 0.0) if hit >= 0 else weights[k] / total


@njit
def _set_tops(nodes: Nodes, ends: _Ends, rule: Rule, network: Network, length: float) -> None:
    """`compliance` and `inertia` of the tops that remember, for a step of `length`: see `tops_for`."""
    s, system = len(nodes), ends.system
    for slab in range(network.first.size):
        if not network.remembers[slab]:
            continue
        for j in range(s):
            for k in range(s):
                network.inertia[slab, j, k] = ends.mass[slab] / length * ends.inverse[j, k]
                system[j, k] = network.inertia[slab, j, k] + length * network.spring[slab] * rule.integral[k, j]
                system[j, s + k] = 0.0
            system[j, j] += ends.resistance[slab]
            system[j, s + j] = 1.0
        eliminate(system, 2 * s)
        for j in range(s):
            for k in range(s):
                network.compliance[slab, j, k] = system[j, s + k]


@njit
def _follow_breaks(nodes: Nodes, ends: _Ends, waves: Array, history: _History, slot: int) -> None:
    """Add the arrivals of the waves that have just jumped, in value or in one of three derivatives, to the break points."""
    arrivals, counts, start = history.arrivals, history.counts, history.starts[slot]
    for layer in range(ends.travel.size):
        outward, inward = waves[layer, OUTWARD], waves[layer, INWARD]
        within = min(_leeway(ends, outward, history, slot), _leeway(ends, inward, history, slot))
        if within == math.inf:
            continue
        arrival, rank = start + ends.travel[layer], counts[WAITING]
        while rank > 0 and arrivals[rank - 1] > arrival:
            rank -= 1
        if rank > 0 and arrival - arrivals[rank - 1] < within:
            continue
        if rank < counts[WAITING] and arrivals[rank] - arrival < within:
            continue
        for k in range(counts[WAITING], rank, -1):
            arrivals[k] = arrivals[k - 1]
        arrivals[rank] = arrival
        counts[WAITING] += 1
        counts[FOLLOWED] += 1


@njit
def _leeway(ends: _Ends, wave: Array, history: _History, slot: int) -> float:
    """How far a step's end may lie from the break of `wave` (ring, s) at the start of the step in the `slot`; infinite without
    one.

    Within a step h, a polynomial of degree n misses a jump q of the m-th derivative by about q (h/n)^m/2^(m + 1). A break is one
    that is missed by more than the `smallest` error, and by more than the jump that the rest of both polynomials feigns; if its
    end is off by d, it is missed by q d^m."""
    s, ring, nearest = wave.shape[1], history.starts.size, math.inf
    before, started, degree = (slot - 1) % ring, history.starts[slot] > 0.0, wave.shape[1] - 1
    here, there = -1.0, 0.0  # rests of both polynomials, once they are needed
    missed, ends_of_rest = 1.0, 1.0
    longest = min(ends.longest, _LONGER * max(history.lengths[slot], history.lengths[before]))
    for m in range(ends.left.shape[0]):
        jump, last = 0.0, 0.0
        for k in range(s):
            jump += ends.left[m, k] * wave[slot, k]
            last += ends.right[m, k] * wave[before, k]
        share, share_before = (longest / history.lengths[slot]) ** m, (longest / history.lengths[before]) ** m
        jump *= share
        if started:
            jump -= last * share_before
        if abs(jump) * missed > ends.smallest:
            if here < 0.0:
                here = _rest_of(ends.coefficients, wave[slot])
                there = _rest_of(ends.coefficients, wave[before]) if started else 0.0
            if abs(jump) > ends_of_rest * (here * share + there * share_before):
                own = longest * (ends.smallest / abs(jump)) ** (1.0 / m) if m else 0.0
                nearest = min(nearest, max(own, SHORTEST))
        missed *= 0.5 / degree
        ends_of_rest *= (degree + m + 2) * (degree - m + 1) / (m + 1)
    return nearest


@njit
def _rest_of(coefficients: Array, values: Array) -> float:
    """Size of the Legendre coefficient that follows those of a polynomial with these nodal `values`: the last, times the ratio
    of the last to the larger of both before it."""
    s, last, before = values.size, 0.0, 0.0
    for row in range(s - 3, s):
        total = 0.0
        for k in range(s):
            total += coefficients[row, k] * values[k]
        if row == s - 1:
            last = abs(total)
        else:
            before = max(before, abs(total))
    return last * min(1.0, last / before) if before > 0.0 else last


@njit
def _leave_behind(history: _History, time: float) -> None:
    """Remove the break points before `time` from the list."""
    arrivals, counts = history.arrivals, history.counts
    gone = 0
    while gone < counts[WAITING] and arrivals[gone] < time:
        gone += 1
    if gone:
        counts[WAITING] -= gone
        for k in range(counts[WAITING]):
            arrivals[k] = arrivals[k + gone]


@njit
def _march_breaks(
    nodes: Nodes,
    physics: Physics,
    lines: NetworkLines,
    memory: DelayMemory,
    nodal: Nodal,
    trail: tuple[_History, _Ends],
    limits: Limits,
    until: float,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March to the first end at or beyond `until`, at most as many steps as `pieces`. Returns (steps, Newton iterations, verdict)
    as `march_delay`."""
    history, ends = trail
    now, total, longest = memory.now, 0, ends.longest
    begin, lengths = history.present
    for n in range(pieces.time.size):
        if now[TIME] >= until:
            return n, total, DONE
        start, slot = now[TIME], lines.cursor[0]
        _leave_behind(history, start + SHORTEST)
        left = history.arrivals[0] - start if history.counts[WAITING] else math.inf
        length = left / math.ceil(left / longest - _SAME) if left < 64.0 * longest else longest
        has_space = history.arrivals.size - history.counts[WAITING] >= ends.travel.size
        if not (_look_back(nodes, ends, lines.network, history, slot, start, length) and has_space):
            return n, total, TOO_MANY
        _set_tops(nodes, ends, physics.rule, lines.network, length)
        begin[1], lengths[0] = length, length
        clock = Clock(start, begin, lengths, 1)
        _, used, verdict = march_delay(nodes, physics, lines, memory, nodal, clock, limits, n, pieces)
        total += used
        if verdict != DONE:
            return n, total, verdict
        history.starts[slot], history.lengths[slot] = start, length
        history.counts[FILLED] = min(history.counts[FILLED] + 1, history.starts.size)
        if abs(left - length) < _SAME:
            now[TIME] = history.arrivals[0]
            _leave_behind(history, now[TIME] + SHORTEST)
            hold(nodes, now[PSI], memory.guess.z[0], memory.guess)  # polynomials cannot be extended beyond a break point
        _follow_breaks(nodes, ends, lines.waves, history, slot)
    return pieces.time.size, total, DONE


class DelayBreaks(LeapingNetwork):
    """As `DelayNetwork`, with steps of varying length that end where a break arrives; about 4 microseconds per step.

    Delayed waves at a node are interpolated in the past step in which they left. Equal steps need a projection (`delay_rows`),
    because some delays amplify noise at every return; steps of varying length do not: for such delays psi(600) agrees with the
    full wave to 2e-11, at a tolerance of 1e-9 and with no more steps.

    `break_points` counts the jumps and kinks that were followed. Where none is to come but kinks of V, `leap` takes the equal
    steps and the leaps of `LeapingNetwork`; from two steps before a kink of V on, breaks are followed again. Raises NumericsError
    if they need more than the stored history.
    """

    def __init__(self, scene: Scene, tolerance: float = 1e-9, lines: Lines | None = None) -> None:
        super().__init__(scene, tolerance, lines=lines)
        self._ends = self._ends_for(tolerance)
        self._lines, self._follows = self._lines_of_breaks(np.empty((0, 2)), self._lines.waves[:, :, :0], self._lines.tops), True
        self._remember(np.empty((0, 2)), self._kinks(), 0)

    @property
    def break_points(self) -> int:
        """Number of jumps and kinks followed so far."""
        return int(self._history.counts[FOLLOWED])

    def advance(self, until: float) -> Pieces:
        """March to the first end of a step at or beyond `until`, but at most one chunk; see `Solver`."""
        if not self._follows:
            near = self._next_kink() - 2.0 * self._length
            if self.time < near:
                return super().advance(min(until, near))
            self._follow()
        pieces = empty_pieces(_PIECES, self._stages)
        while True:
            trail = (self._history, self._ends._replace(longest=self._length))
            march = (self._physics, self._lines, self._memory, self._nodal, trail, self._limits_of_breaks, until - SAME)
            steps, iterations, verdict = _march_breaks(self._shape, *march, pieces)
            self.iterations += iterations
            if steps:
                return pieces.part(slice(steps))
            self._refine(verdict)

    def leap(self, until: float, end: float, gaps: bool) -> Pieces:
        """As `Leaping`."""
        if not self._follows:
            return super().leap(until, end, gaps)
        if not self._is_quiet():
            return self.advance(until)
        pieces = self.advance(self.time + 0.5 * self._length)  # one step, at whose start a break may still be launched
        if self._is_quiet():
            self._settle()
        return pieces

    def _kinks(self) -> Array:
        """The kinks of V that are still to come."""
        return np.array([time for time in self.scene.drive.knots if time > self.time])

    def _is_quiet(self) -> bool:
        """Whether no break point is to come but kinks of V, none of them soon, and the past steps reach back far enough."""
        counts, reach = self._history.counts, float(self._layers.travel.max()) + _SOON * self._length
        if counts[WAITING] > len(self.scene.drive.knots) or counts[WAITING] > self._kinks().size or not counts[FILLED]:
            return False
        known = self._history.starts[self._order()[0]] < self.time - reach
        return bool(known and self._next_kink() > self.time + reach)

    def _settle(self) -> None:
        """Go on in equal steps."""
        order, network = self._order(), self._compile(self._length)
        ring = int(network.back.max()) + 1
        kept = order[np.searchsorted(self._history.starts[order], self.time - ring * self._length, side="right") - 1 :]
        starts, lengths = self._history.starts[kept] - self.time, self._history.lengths[kept]
        past, new = (TransitMesh(n.size, n, begin) for n, begin in ((lengths, starts), self._equal(ring)))
        waves = past.resample(self._lines.waves[:, :, kept], self.nodes, new)
        self._lines, self._follows = lines_with(network, waves, self._lines.tops), False
        self._begin_anew()

    def _follow(self) -> None:
        """Go on in steps that end on break points."""
        _, _, waves, tops, cursor, _ = self._lines
        ring, followed = waves.shape[2], self.break_points
        lengths, starts = self._equal(ring)
        past = np.column_stack([self.time + starts, lengths])
        self._lines, self._follows = self._lines_of_breaks(past, np.roll(waves, -int(cursor[0]), axis=2), tops), True
        self._remember(past, self._kinks(), followed)
        self._begin_anew()

    def _equal(self, ring: int) -> tuple[Array, Array]:
        """Lengths of the last `ring` equal steps, and their starts (transits from now)."""
        return np.full(ring, self._length), self._length * np.arange(-ring, 0.0)

    def _begin_anew(self) -> None:
        """Begin a new grid of steps now."""
        now, z = self._memory.now, float(self._memory.guess.z[0])
        self._memory = DelayMemory(constant_guess(now[PSI], z, self._stages), now)
        self._origin, self._done = self.time, 0
        self._forget_steps()

    def _order(self) -> NDArray[np.int64]:
        """Ring indices of the past steps, oldest first."""
        filled = int(self._history.counts[FILLED])
        return (int(self._lines.cursor[0]) - filled + np.arange(filled)) % _RING

    def _lines_of_breaks(self, past: Array, waves: Array, tops: Array) -> NetworkLines:
        """The lines with the `waves` of the `past` steps, oldest first; every node reads from a step of its own."""
        layers, steps = self._layers.travel.size, past.shape[0]
        network = self._compile(self._length)._replace(
            whole=np.zeros(layers, dtype=np.bool_),
            back=np.zeros((layers, self._stages), dtype=np.int64),
            weights=np.zeros((layers, self._stages, 1, self._stages)),
        )
        ring = np.zeros((layers, 2, _RING, self._stages))
        ring[:, :, :steps] = waves
        return lines_with(network, ring, tops, steps % _RING)

    def _ends_for(self, tolerance: float) -> _Ends:
        scene, lines, basis = self.scene, self._layers, lagrange_basis(self.nodes)
        friction_z = respond(scene.law, float(self._memory.guess.z[0]), scene.steady_psi)[3]
        each = [np.linalg.matrix_power(basis.derivative, m) for m in range(_DERIVATIVES + 1)]
        left = interpolation_matrix(basis, np.zeros(1))[0]
        return _Ends(
            travel=lines.travel,
            left=np.array([left @ values for values in each]),
            right=np.array([values[-1] for values in each]),
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
        self._history = _History(np.empty(_RING), np.ones(_RING), np.empty(_RING + arrivals.size), counts, present, nearby)
        self._history.starts[: past.shape[0]], self._history.lengths[: past.shape[0]] = past.T
        self._history.arrivals[: arrivals.size] = arrivals

    def _refine(self, verdict: int) -> None:
        """Shorten the longest step; past steps keep their own lengths."""
        if not self._follows:
            super()._refine(verdict)
            return
        if verdict == TOO_MANY:
            raise NumericsError(
                f"delay: more than {_RING} break points within a travel time at t = {self._memory.now[TIME]:.6g} transits: every "
                f"jump comes back from each layer and face, and so does every echo; use dg:8, or start.kind = 'nudge' and a V "
                f"without jumps (scene {self.scene.name!r}, digest {self.scene.digest})"
            )
        self._require_shorter(verdict)
        self._count = next_count(self._count)
        self._memory = DelayMemory(
            constant_guess(self._memory.now[PSI], self._memory.guess.z[0], self._stages), self._memory.now
        )  # polynomials fit the old lengths

    def state(self) -> State:
        """As `Solver`: start and length of the `past` steps (steps, 2), the `waves` launched in them (layers, 2, steps, s), the
        next break points in order, `arrivals` (points, 1), and the present state; `counts`: longest steps in their span, break
        points, 0, failures, iterations. In equal steps as `LeapingNetwork`, no `past`, and `arrivals` (1, 1): break points."""
        if not self._follows:
            return super().state() | {"past": np.empty((0, 2)), "arrivals": np.array([[float(self.break_points)]])}
        lines, memory, history, order = self._lines, self._memory, self._history, self._order()
        waiting, followed = (int(count) for count in history.counts[[WAITING, FOLLOWED]])
        return {
            "counts": np.array([self._count, followed, 0, self.failures, self.iterations], dtype=float),
            "origin": np.zeros(1),
            "past": np.column_stack([history.starts[order], history.lengths[order]]),
            "waves": lines.waves[:, :, order],
            "arrivals": history.arrivals[:waiting, None].copy(),
            "tops": lines.tops.copy(),
            "guess": np.stack(memory.guess),
            "now": memory.now.copy(),
        } | self._state_of_leaps()

    def restore(self, state: State) -> None:
        """As `Solver`."""
        steps = min(state["past"].shape[0] if "past" in state else 0, _RING)
        if not steps and "waves" in state and state["waves"].shape[2:3] > (0,):
            kept = tables(state, {"past": (0, 2), "arrivals": (1, 1)}, self.model)
            super().restore(state)
            self._follows = False
            self._remember(kept["past"], np.empty(0), int(kept["arrivals"][0, 0]))
            return
        leaps = self._leaps_of(state)
        count, points, _, failures, iterations = whole_numbers(state, "counts", (1, 0, 0, 0, 0))
        shapes = {
            "origin": (1,),
            "past": (steps, 2),
            "waves": (self._layers.travel.size, 2, steps, self._stages),
            "arrivals": (-1, 1),
        }
        saved = tables(state, shapes | self._present(), self.model)
        self._follows, self._count, self.failures, self.iterations = True, count, failures, iterations
        self._remember(saved["past"], saved["arrivals"].ravel(), points)
        self._lines = self._lines_of_breaks(saved["past"], saved["waves"], saved["tops"])
        self._memory = DelayMemory(Interface(*saved["guess"]), saved["now"])
        self._restore_leaps(leaps)
