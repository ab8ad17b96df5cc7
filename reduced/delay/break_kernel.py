"""The compiled march of `DelayBreaks`: steps of varying length that end on break points, with delayed waves by interpolation."""

import math
from typing import NamedTuple

from reduced.delay.kernel import Clock, DelayMemory, march_delay
from reduced.delay.network_kernel import INWARD, OUTWARD, Integers, Network, NetworkLines
from slipwave.compiled import njit
from slipwave.observe.pieces import Array, Pieces
from slipwave.step.collocation import Nodes, Rule
from slipwave.step.newton import eliminate
from slipwave.step.nodal import DONE, PSI, TIME, Limits, Nodal, Physics, hold

TOO_MANY = 10
"""Verdict: the history or the list of arrivals is full."""

SHORTEST = 1e-7
_SAME = 1e-10
_LONGER = 4.0  # where a break arrives, steps are at most so much longer than where it was launched
FILLED, WAITING, FOLLOWED = range(3)  # `History.counts`


class History(NamedTuple):
    """`starts` and `lengths` (ring,) of past steps; `arrivals` (n,), the next break points in order; `counts` (3,): past steps
    known, break points to come, break points passed. Begin (2,) and length (1,) of the `present` step. `nearby` (layers,): ring
    index of the step that was read last."""

    starts: Array
    lengths: Array
    arrivals: Array
    counts: Integers
    present: tuple[Array, Array]
    nearby: Integers


class Ends(NamedTuple):
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
def look_back(nodes: Nodes, ends: Ends, network: Network, history: History, slot: int, start: float, length: float) -> bool:
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
            weigh(nodes, ends.barycentric, local, network.weights[layer, j, 0])
    return True


@njit
def _starts_before(history: History, slot: int, age: int, time: float) -> bool:
    """Whether the step that lies `age` steps before the one in the `slot` starts before `time`."""
    return bool(history.starts[slot - age if slot >= age else slot - age + history.starts.size] < time - _SAME)


@njit
def weigh(nodes: Nodes, barycentric: Array, local: float, weights: Array) -> None:
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
def set_tops(nodes: Nodes, ends: Ends, rule: Rule, network: Network, length: float) -> None:
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
def follow_breaks(nodes: Nodes, ends: Ends, waves: Array, history: History, slot: int) -> None:
    """Add the arrivals of the waves that have just jumped, in value or in one of three derivatives, to the break points."""
    arrivals, counts, start = history.arrivals, history.counts, history.starts[slot]
    for layer in range(ends.travel.size):
        outward, inward = waves[layer, OUTWARD], waves[layer, INWARD]
        within = min(leeway(ends, outward, history, slot), leeway(ends, inward, history, slot))
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
def leeway(ends: Ends, wave: Array, history: History, slot: int) -> float:
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
                here = rest_of(ends.coefficients, wave[slot])
                there = rest_of(ends.coefficients, wave[before]) if started else 0.0
            if abs(jump) > ends_of_rest * (here * share + there * share_before):
                own = longest * (ends.smallest / abs(jump)) ** (1.0 / m) if m else 0.0
                nearest = min(nearest, max(own, SHORTEST))
        missed *= 0.5 / degree
        ends_of_rest *= (degree + m + 2) * (degree - m + 1) / (m + 1)
    return nearest


@njit
def rest_of(coefficients: Array, values: Array) -> float:
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
def leave_behind(history: History, time: float) -> None:
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
def march_breaks(
    nodes: Nodes,
    physics: Physics,
    lines: NetworkLines,
    memory: DelayMemory,
    nodal: Nodal,
    trail: tuple[History, Ends],
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
        leave_behind(history, start + SHORTEST)
        left = history.arrivals[0] - start if history.counts[WAITING] else math.inf
        length = left / math.ceil(left / longest - _SAME) if left < 64.0 * longest else longest
        has_space = history.arrivals.size - history.counts[WAITING] >= ends.travel.size
        if not (look_back(nodes, ends, lines.network, history, slot, start, length) and has_space):
            return n, total, TOO_MANY
        set_tops(nodes, ends, physics.rule, lines.network, length)
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
            leave_behind(history, now[TIME] + SHORTEST)
            hold(nodes, now[PSI], memory.guess.z[0], memory.guess)  # polynomials cannot be extended beyond a break point
        follow_breaks(nodes, ends, lines.waves, history, slot)
    return pieces.time.size, total, DONE
