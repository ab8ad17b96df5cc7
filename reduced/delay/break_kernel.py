"""The compiled march of `DelayBreaks`: steps of varying length that end on break points, with delayed waves by interpolation."""

import math
from typing import NamedTuple

from reduced.delay.alike_kernel import PSI, TIME
from reduced.delay.network_kernel import INWARD, OUTWARD, Integers, Network, NetworkMemory, Passage, march_network
from slipwave.compiled import njit
from slipwave.friction import Law
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene.drive import Constant, Ramps
from slipwave.scene.forcing import Forcing
from slipwave.step.collocation import Nodes, Rule
from slipwave.step.guess import DONE
from slipwave.step.rows import STATE, UNKNOWN, Scratch

TOO_MANY = 10
"""Verdict: the history or the list of arrivals is full."""

SHORTEST = 1e-7
_SAME = 1e-10
FILLED, WAITING, FOLLOWED = range(3)  # `History.counts`


class History(NamedTuple):
    """`starts` and `lengths` (ring,) of past steps; `arrivals` (n,), the next break points in order; `counts` (3,): past steps
    that are known, break points that wait, and those that were followed."""

    starts: Array
    lengths: Array
    arrivals: Array
    counts: Integers


class Ends(NamedTuple):
    """`travel` (layers,); rows (s,) that give a step's polynomial at its `left` end and its slopes at both ends, and the nodes'
    `barycentric` weights; per slab `resistance` Z_g + e and `mass` of its top; `inverse` (s, s) A^-1; scratch (s, 2s) to invert
    `system`; the smallest `jump` and `kink` that are followed."""

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


@njit
def look_back(nodes: Nodes, ends: Ends, network: Network, history: History, slot: int, start: float, length: float) -> bool:
    """Set the past step and the weights from which each node of the next step, which is the `slot` in the ring, reads its delayed
    waves (none before t = 0). False if the ring does not reach back so far."""
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
        invert(s, system)
        for j in range(s):
            for k in range(s):
                network.compliance[slab, j, k] = system[j, s + k]


@njit
def invert(s: int, system: Array) -> None:
    """[M, I] (s, 2s) becomes [I, M^-1]."""
    for i in range(s):
        pivot = i
        for j in range(i + 1, s):
            if abs(system[j, i]) > abs(system[pivot, i]):
                pivot = j
        for k in range(2 * s):
            system[i, k], system[pivot, k] = system[pivot, k], system[i, k]
        factor = 1.0 / system[i, i]
        for k in range(2 * s):
            system[i, k] *= factor
        for j in range(s):
            if j != i:
                factor = system[j, i]
                for k in range(2 * s):
                    system[j, k] -= factor * system[i, k]


@njit
def follow_breaks(nodes: Nodes, ends: Ends, waves: Array, history: History, slot: int, longest: float) -> None:
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
            broken = broken or abs(jump) > ends.jump or abs(slope) * longest > ends.kink
        if not broken:
            continue
        arrival, place = start + ends.travel[layer], counts[WAITING]
        while place > 0 and arrivals[place - 1] > arrival:
            place -= 1
        if place > 0 and arrival - arrivals[place - 1] < SHORTEST:
            continue
        if place < counts[WAITING] and arrivals[place] - arrival < SHORTEST:
            continue
        for k in range(counts[WAITING], place, -1):
            arrivals[k] = arrivals[k - 1]
        arrivals[place] = arrival
        counts[WAITING] += 1
        counts[FOLLOWED] += 1


@njit
def leave_behind(history: History, time: float) -> None:
    """Take the break points before `time` from the list."""
    arrivals, counts = history.arrivals, history.counts
    gone = 0
    while gone < counts[WAITING] and arrivals[gone] < time:
        gone += 1
    if gone:
        counts[WAITING] -= gone
        for k in range(counts[WAITING]):
            arrivals[k] = arrivals[k + gone]


@njit
def forget(memory: NetworkMemory) -> None:
    """Take constants as the guess: polynomials cannot be extended beyond a break point."""
    z = memory.guess[UNKNOWN, 0]
    for j in range(memory.guess.shape[1]):
        memory.guess[STATE, j], memory.guess[UNKNOWN, j] = memory.now[PSI], z


@njit
def march_breaks(
    nodes: Nodes,
    law: Law,
    network: Network,
    forcing: Forcing,
    velocity: Constant | Ramps,
    rule: Rule,
    memory: NetworkMemory,
    passage: Passage,
    scratch: Scratch,
    history: History,
    ends: Ends,
    longest: float,
    until: float,
    newton_tolerance: float,
    resolution: float,
    steepest: float,
    piece: Pieces,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March steps of at most `longest` transits to the first end at or beyond `until`, at most as many as `pieces`; `piece` is
    scratch for one. Returns (steps, Newton iterations, verdict) as `march_network`."""
    now, total = memory.now, 0
    for n in range(pieces.time.size):
        if now[TIME] >= until:
            return n, total, DONE
        start, slot = now[TIME], memory.cursor[0]
        leave_behind(history, start + SHORTEST)
        left = history.arrivals[0] - start if history.counts[WAITING] else math.inf
        length = left / math.ceil(left / longest - _SAME) if left < 64.0 * longest else longest
        room = history.arrivals.size - history.counts[WAITING] >= ends.travel.size
        if not (look_back(nodes, ends, network, history, slot, start, length) and room):
            return n, total, TOO_MANY
        set_tops(nodes, ends, rule, network, length)
        tolerances = (newton_tolerance, resolution, steepest)
        clock = (start, 0, length, 1)
        _, used, verdict = march_network(
            nodes, law, network, forcing, velocity, rule, memory, passage, scratch, *clock, *tolerances, piece
        )
        total += used
        if verdict != DONE:
            return n, total, verdict
        pieces.time[n], pieces.length[n] = piece.time[0], piece.length[0]
        for j in range(len(nodes)):
            pieces.z[n, j], pieces.psi[n, j] = piece.z[0, j], piece.psi[0, j]
            pieces.mu[n, j], pieces.y[n, j] = piece.mu[0, j], piece.y[0, j]
        history.starts[slot], history.lengths[slot] = start, length
        history.counts[FILLED] = min(history.counts[FILLED] + 1, history.starts.size)
        if abs(left - length) < _SAME:
            now[TIME] = history.arrivals[0]
            leave_behind(history, now[TIME] + SHORTEST)
            forget(memory)
        follow_breaks(nodes, ends, memory.waves, history, slot, longest)
    return pieces.time.size, total, DONE
