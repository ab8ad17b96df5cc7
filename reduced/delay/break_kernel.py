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
FILLED, WAITING, FOLLOWED = range(3)  # `History.counts`


class History(NamedTuple):
    """`starts` and `lengths` (ring,) of past steps; `arrivals` (n,), the next break points in order; `counts` (3,): past steps
    known, break points to come, break points passed. Begin (2,) and length (1,) of the `present` step."""

    starts: Array
    lengths: Array
    arrivals: Array
    counts: Integers
    present: tuple[Array, Array]


class Ends(NamedTuple):
    """`travel` (layers,); rows (s,) that give a step's polynomial at its `left` end and its slopes at both ends, and the nodes'
    `barycentric` weights; per slab `resistance` Z_g + e and `mass` of its top; `inverse` (s, s) A^-1; scratch (s, 2s) to invert
    `system`; the smallest `jump` and `kink` that become break points; the `longest` step (transits)."""

    travel: Array
    left: Array
    slope_left: Array
    slope_right: Array
    barycentric: Array
    resistance: Array
    mass: Array
    inverse: Array
    system: Array
    jump: float
    kink: float
    longest: float


@njit
def look_back(nodes: Nodes, ends: Ends, network: Network, history: History, slot: int, start: float, length: float) -> bool:
    """Set, for each node of the next step (`slot` in the ring), the past step and the weights that interpolate its delayed waves
    (none before t = 0). False if the ring does not reach back so far."""
    s, ring, known = len(nodes), history.starts.size, history.counts[FILLED]
    for layer in range(ends.travel.size):
        for j in range(s):
            wanted = start + nodes[j] * length - ends.travel[layer]
            network.back[layer, j] = 0
            for k in range(s):
                network.weights[layer, j, j, k] = 0.0
            if wanted <= _SAME or known == 0:
                continue
            young, old = 1, known  # ages, in steps, between which that of the step lies
            while young < old:
                age = (young + old) // 2
                if history.starts[(slot - age) % ring] < wanted - _SAME:
                    old = age
                else:
                    young = age + 1
            past = (slot - young) % ring
            if young == ring and history.starts[past] > wanted:
                return False
            local = min(1.0, max(0.0, (wanted - history.starts[past]) / history.lengths[past]))
            network.back[layer, j] = young
            total, hit = 0.0, -1
            for k in range(s):
                gap = local - nodes[k]
                if gap == 0.0:
                    hit = k
                else:
                    network.weights[layer, j, j, k] = ends.barycentric[k] / gap
                    total += network.weights[layer, j, j, k]
            for k in range(s):
                if hit >= 0:
                    network.weights[layer, j, j, k] = 1.0 if k == hit else 0.0
                else:
                    network.weights[layer, j, j, k] /= total
    return True


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
    """Add the arrivals of the waves that have just jumped or kinked to the break points."""
    ring, arrivals, counts = history.starts.size, history.arrivals, history.counts
    before, start = (slot - 1) % ring, history.starts[slot]
    for layer in range(ends.travel.size):
        broken = False
        for way in (OUTWARD, INWARD):
            jump, slope = 0.0, 0.0
            for k in range(len(nodes)):
                now = waves[layer, way, slot, k]
                jump += ends.left[k] * now
                slope += ends.slope_left[k] * now / history.lengths[slot]
                if start > 0.0:
                    slope -= ends.slope_right[k] * waves[layer, way, before, k] / history.lengths[before]
            if start > 0.0:
                jump -= waves[layer, way, before, len(nodes) - 1]
            broken = broken or abs(jump) > ends.jump or abs(slope) * ends.longest > ends.kink
        if not broken:
            continue
        arrival, rank = start + ends.travel[layer], counts[WAITING]
        while rank > 0 and arrivals[rank - 1] > arrival:
            rank -= 1
        if rank > 0 and arrival - arrivals[rank - 1] < SHORTEST:
            continue
        if rank < counts[WAITING] and arrivals[rank] - arrival < SHORTEST:
            continue
        for k in range(counts[WAITING], rank, -1):
            arrivals[k] = arrivals[k - 1]
        arrivals[rank] = arrival
        counts[WAITING] += 1
        counts[FOLLOWED] += 1


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
