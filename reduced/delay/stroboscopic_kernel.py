"""Compiled leaps from block to block of a stick (`stroboscopic`), by the multirevolution method (`multirevolution`)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.delay.march import EXTREMES, LOST, Clock, DelayMemory, march_delay
from reduced.delay.multirevolution import LONGEST
from reduced.delay.network_kernel import Integers, NetworkLines
from slipwave.compiled import allocating, njit
from slipwave.friction import rate_of, respond
from slipwave.observe.pieces import Array, Pieces
from slipwave.step.collocation import Nodes
from slipwave.step.nodal import ELASTIC, PSI, TIME, Interface, Limits, Nodal, Physics

NEXT, REACH, KNOWN, SHOWN, SKIPPED, ITERATIONS = range(6)
"""Of `Walk.counts`: number of the next block, blocks that the next leap skips, marched blocks that are known, pieces, blocks
skipped, Newton iterations."""

_SHRINK, _SAFETY, _GROW = 0.2, 0.9, 2.0
_CORRECTED = 0.1  # of the correction: error that it leaves, by the constants of Adams's methods a thirtieth
_ROUNDING = 0.02  # of the allowed error: less may be rounding, which does not grow as a leap's error


class LineMarch(NamedTuple):
    """What `march_delay` needs."""

    physics: Physics
    lines: NetworkLines
    memory: DelayMemory
    nodal: Nodal
    limits: Limits


class StickBlock(NamedTuple):
    """So many `steps` of a `length` in which all waves of a stick nearly repeat. Of their map B (n, n) without slip, transposed:
    `powers` 1, 2, 4, .. (m, n, n), and B^(k + 1), `after` a leap over k blocks, in slot[k], if that is not negative. `by_slip`
    (steps s, n): change of the memory by the slip rate at the nodes, but for psi. `stress` (n - 2,) that an entry of the memory
    causes, 0 if no wave reads it. `nodes` and `weights` of `sum_rules`."""

    steps: int
    length: float
    powers: Array
    after: Array
    slot: Integers
    by_slip: Array
    stress: Array
    nodes: Array
    weights: Array


class WalkTask(NamedTuple):
    """To walk to the block `last` in leaps over at least `least` blocks, which err by less than is `allowed`, while z is below
    the `limit` of sticks and V is `velocity`. The walk begins `done` steps after `origin` (transits); `shift` (n,): memory of
    slabs that move apart with V."""

    last: int
    least: int
    allowed: float
    limit: float
    velocity: float
    origin: float
    done: int
    shift: Array


class Walk(NamedTuple):
    """The memory `now` (n,), as a difference from `WalkTask.shift`, and the `guess` for its first step. Of the blocks that were
    marched, the latest last: `number` (p + 1,), `change` (p + 1, n) of the memory in the frame of `now`, `highest` (p + 1, q);
    the first row is left from the leap before. `counts` (6,)."""

    now: Array
    guess: Interface
    number: Array
    change: Array
    highest: Array
    counts: Integers


@allocating
def _weights_at(number: Array, at: float) -> Array:
    """Weights (p,) that give, `at` a number, the polynomial through values at other numbers (p,)."""
    weights, span = np.empty(number.size), number[-1] - number[0]
    for i in range(number.size):
        weights[i] = 1.0 / (at - number[i])
        for j in range(number.size):
            if j != i:
                weights[i] *= span / (number[i] - number[j])
    weights /= weights.sum()
    return weights


@allocating
def _weights_of_sum(number: Array, first: float, nodes: Array, weights: Array) -> Array:
    """Weights (p,) that give the sum of that polynomial from `first` on, by the rule of the sum."""
    total = np.zeros(number.size)
    for k in range(nodes.size):
        if weights[k] > 0.0:
            total += weights[k] * _weights_at(number, first + nodes[k])
    return total


@allocating
def _sum_of_new(number: Array, first: float, nodes: Array, weights: Array) -> float:
    """The sum of the polynomial that is 1 at the last of `number` (p,) and 0 at the others."""
    total = 0.0
    for k in range(nodes.size):
        share = weights[k]
        for other in number[:-1]:
            share *= (first + nodes[k] - other) / (number[-1] - other)
        total += share
    return total


@allocating
def turns(number: Array, highest: Array) -> NDArray[np.intp]:
    """The numbers between the last two of `number` (p,) at which one of the quantities `highest` (p, q), rising before, has its
    maximum by the polynomial through its values, in order."""
    first, rising = int(number[-2]) + 1, highest[-2] > highest[-3]
    inside = int(number[-1]) - first
    chosen = np.zeros(inside, dtype=np.bool_)
    if inside and rising.any():
        turned = rising & (np.dot(_weights_at(number, number[-1] - 1.0), highest) > highest[-1])
        best, at = np.full(turned.size, -np.inf), np.zeros(turned.size, dtype=np.int64)
        for i in range(inside if turned.any() else 0):
            values = np.dot(_weights_at(number, float(first + i)), highest)
            for q in range(values.size):
                if values[q] > best[q]:
                    best[q], at[q] = values[q], i
        for q in range(turned.size):
            if turned[q]:
                chosen[at[q]] = True
    return first + np.flatnonzero(chosen)


@allocating
def carried(block: StickBlock, vector: Array, count: int) -> Array:
    """The memory `vector` (n,) after `count` blocks without slip."""
    for bit in range(block.powers.shape[0]):
        if count >> bit & 1:
            vector = np.dot(vector, block.powers[bit])
    return vector


@njit
def _put(values: Array, into: Array) -> None:
    """Copy `values` (n,): numba compiles an assignment to a slice thirty times as long."""
    for i in range(values.size):
        into[i] = values[i]


@allocating
def memory_of(lines: NetworkLines, memory: DelayMemory) -> Array:
    """The memory (n,): waves, the oldest step first, outer faces, psi and y."""
    (layers, ways, ring, s), at = lines.waves.shape, 0
    vector = np.empty(lines.waves.size + lines.tops.size + 2)
    for layer in range(layers):
        for way in range(ways):
            for step in range(ring):
                _put(lines.waves[layer, way, (lines.cursor[0] + step) % ring], vector[at : at + s])
                at += s
    _put(lines.tops.reshape(-1), vector[at:])
    vector[-2], vector[-1] = memory.now[PSI], memory.now[ELASTIC]
    return vector


@allocating
def _place(march: LineMarch, block: StickBlock, task: WalkTask, walk: Walk, vector: Array, number: int) -> None:
    """Set the state at the beginning of the block `number` to a `vector` (n,) as `Walk.now`."""
    lines, memory, whole, size = march.lines, march.memory, vector + task.shift, march.lines.waves.size
    _put(whole[:size], lines.waves.reshape(-1))
    _put(whole[size:-2], lines.tops.reshape(-1))
    lines.cursor[0] = 0
    _put(walk.guess.psi, memory.guess.psi)
    _put(walk.guess.z, memory.guess.z)
    memory.now[TIME], memory.now[LOST] = task.origin + (task.done + number * block.steps) * block.length, 0.0
    memory.now[PSI], memory.now[ELASTIC] = whole[-2], whole[-1]


@allocating
def _marched(
    nodes: Nodes, march: LineMarch, block: StickBlock, task: WalkTask, number: int, pieces: Pieces, at: int, count: Integers
) -> bool:
    """March the block `number` as pieces from `at` on; whether it is one of a stick."""
    first = task.done + number * block.steps
    begin = block.length * np.arange(first, first + block.steps + 1).astype(np.float64)
    clock = Clock(task.origin, begin, np.full(block.steps, block.length), 1)
    physics, lines, memory, nodal, limits = march
    done, iterations, _ = march_delay(nodes, physics, lines, memory, nodal, clock, limits, at, pieces)
    count[ITERATIONS] += iterations
    return done == block.steps and pieces.z[at : at + done].max() <= task.limit


@allocating
def _ahead(block: StickBlock, walk: Walk, reach: int) -> Array:
    """The memory (n,) after `reach` more blocks, by the polynomial through past changes."""
    weights = _weights_of_sum(walk.number[1:], float(walk.counts[NEXT]), block.nodes[reach], block.weights[reach])
    return carried(block, walk.now + np.dot(weights, walk.change[1:]), reach)


@allocating
def size_of_change(stress: Array, change: Array, friction_z: float) -> float:
    """Size of a `change` (n,) of the memory: the largest of the changes of psi, y and ln v (that of the stress of a wave over
    F_z)."""
    size = max(abs(change[-2]), abs(change[-1]))
    for i in range(stress.size):
        size = max(size, abs(change[i]) * stress[i] / friction_z)
    return float(size)


@allocating
def _of_few_powers(number: float) -> int:
    """`number` rounded down so that the map's power with this exponent is a product of at most three of `StickBlock.powers`."""
    most, unit = int(min(number, float(LONGEST))), 1
    while most // unit >= 8:
        unit *= 2
    return most // unit * unit


@allocating
def _change(nodes: Nodes, march: LineMarch, block: StickBlock, task: WalkTask, z: Array, psi: float) -> Array:
    """The change (n,) of the memory by slip in the block that ends now, of `z` (steps, s) and `psi` at its beginning."""
    slip = np.empty(z.size)
    for i in range(z.shape[0]):
        for j in range(z.shape[1]):
            slip[i * z.shape[1] + j] = rate_of(march.physics.law, z[i, j]) - task.velocity
    change: Array = np.dot(slip, block.by_slip)
    change[-2] = march.memory.now[PSI] - psi
    return change


@allocating
def walk_on(nodes: Nodes, march: LineMarch, block: StickBlock, task: WalkTask, walk: Walk, pieces: Pieces) -> None:
    """Walk until `block` lacks a power of the map, the `pieces` are full or no leap saves time; the state is then at NEXT. The
    pieces of blocks between two marched ones, in which a quantity comes to its maximum, follow those of the later."""
    count, order, steps = walk.counts, walk.number.size - 1, block.steps
    while count[REACH] >= task.least and count[NEXT] + count[REACH] < task.last and block.slot[count[REACH]] >= 0:
        reach, known, first, last = count[REACH], count[KNOWN] == order, count[NEXT], count[NEXT] + count[REACH]
        begin = count[SHOWN] + (0 if known else reach * steps)  # pieces of the block `last`
        end = begin + steps
        if end + EXTREMES * steps > pieces.time.size:
            break
        _place(march, block, task, walk, _ahead(block, walk, reach) if known else walk.now, last if known else first)
        good, psi, scale, missed = True, 0.0, 0.0, np.zeros(walk.now.size)
        for at in range(count[SHOWN], end, steps):
            psi = march.memory.now[PSI]
            good = good and _marched(nodes, march, block, task, last - (begin - at) // steps, pieces, at, count)
        z, mu, y = pieces.z[begin:end], pieces.mu[begin:end], pieces.y[begin:end]
        change = _change(nodes, march, block, task, z, psi)
        past = np.dot(walk.change[1:], block.after[block.slot[reach]])
        number = np.empty(order + 1)
        number[-1] = last
        _put(walk.number[1:], number)
        if good and known:
            missed = change - np.dot(_weights_at(number[:-1], number[-1]), past)
            missed *= _sum_of_new(number[1:], float(first), block.nodes[reach], block.weights[reach])
            error = _CORRECTED * size_of_change(
                block.stress, missed, respond(march.physics.law, z[-1, -1], march.memory.now[PSI])[3]
            )
            good = error <= task.allowed
            scale = _SAFETY * (task.allowed / error) ** (1.0 / (order + 1)) if error >= _ROUNDING * task.allowed else np.inf
        if not good:
            count[REACH] = _of_few_powers(max(_SHRINK, scale) * reach) if count[SKIPPED] else 0
            continue
        for k in range(order):
            _put(walk.highest[k + 1], walk.highest[k])
        _put(np.array([z.max(), mu.max(), y.max(), -z.min(), -mu.min(), -y.min()]), walk.highest[-1])
        now = memory_of(march.lines, march.memory) - task.shift + missed
        guess, shown = (march.memory.guess.psi.copy(), march.memory.guess.z.copy()), end
        if known:
            for visited in turns(number[1:], walk.highest[1:]):
                _place(march, block, task, walk, _ahead(block, walk, visited - first), visited)
                _marched(nodes, march, block, task, visited, pieces, shown, count)
                shown += steps
            count[SKIPPED] += reach - (shown - end) // steps
            count[REACH] = _of_few_powers(min(_GROW, scale) * reach)
        _put(now, walk.now)
        _put(number, walk.number)
        _put(guess[0], walk.guess.psi)
        _put(guess[1], walk.guess.z)
        _put(change, walk.change[-1])
        for k in range(order):
            _put(past[k], walk.change[k])
        count[SHOWN], count[NEXT], count[KNOWN] = shown, last + 1, min(count[KNOWN] + 1, order)
    _place(march, block, task, walk, walk.now, count[NEXT])
