"""The date of a slip event: the time at which v, rising to its maximum in the fall of the elastic stress, passes half of that
maximum. If v is above this level in the whole rise, the date is the beginning of the fall.

This time is close to that of the steepest rise of v. The maximum of dv/dt itself is a root of a second derivative: a polynomial
that gives v to 1e-9 gives that time to 1e-6 at best. The passage of a level is as accurate as v, and so are periods. The level
grows with the largest rate so far; the pieces from its latest passage on are kept until the maximum is known.
"""

import math

import numpy as np

from slipwave.compiled import inlined, njit
from slipwave.friction import rate_of, unknown_of
from slipwave.friction.law import Law
from slipwave.observe.extrema import bounds, evaluate, find_root
from slipwave.observe.pieces import Array, Basis

# slots of the memory of a rise: start of the fall (transits), level of z, whether v reached a new maximum in the latest piece,
# first and last (exclusive) of the pieces that are kept
START, LEVEL, RISING, FRONT, KEPT = 0, 1, 2, 3, 4
SLOTS = 5
_TIME, _LENGTH, _LOWEST = 0, 1, 2  # columns of a piece that is kept, before its values of z
HEAD = 3
_FIRST_ROOM, MOST_ROOM = 256, 1 << 16  # pieces; of a longer rise from half to full height only every other piece is kept


def room_for_rise(nodes: int, kept: Array | None = None, more: int = _FIRST_ROOM) -> Array:
    """Room for `more` pieces of `nodes` nodes each, besides those `kept` so far; at most MOST_ROOM."""
    kept = np.empty((0, HEAD + nodes)) if kept is None else kept
    room = np.zeros((min(2 * (len(kept) + more), MOST_ROOM), HEAD + nodes))
    room[: len(kept)] = kept
    return room


@njit
def begin_rise(memory: Array, time: float) -> None:
    """Begin a fall of the elastic stress at `time` (transits)."""
    memory[START] = time
    memory[LEVEL] = -math.inf
    memory[RISING] = memory[FRONT] = memory[KEPT] = 0.0


@njit
def follow_rise(law: Law, time: float, length: float, z: Array, highest: float, raised: bool, memory: Array, kept: Array) -> None:
    """Add a piece of the running fall. `highest` is the largest z in the fall; `raised` is true if it lies in this piece."""
    last = _keep(time, length, z, memory, kept)
    memory[RISING] = 1.0 if raised else 0.0
    if raised:
        memory[LEVEL] = unknown_of(law, 0.5 * rate_of(law, highest))
        while memory[FRONT] + 1 < last and kept[int(memory[FRONT]) + 1, kept.shape[1] - 1] < memory[LEVEL]:
            memory[FRONT] += 1.0
    elif kept[last, _LOWEST] < memory[LEVEL]:
        memory[FRONT] = last


@njit
def date_rise(basis: Basis, memory: Array, kept: Array) -> float:
    """Time (transits), within the fall, at which z last passed the level before the highest node of the latest piece."""
    n, last = basis.nodes.size, int(memory[KEPT]) - 1
    node = 0
    for j in range(1, n):
        if kept[last, HEAD + j] > kept[last, HEAD + node]:
            node = j
    level = min(memory[LEVEL], kept[last, HEAD + node])
    for piece in range(last, int(memory[FRONT]) - 1, -1):
        point = _passage(basis, kept[piece], level, node if piece == last else n)
        if point >= 0.0:
            return float(max(memory[START], kept[piece, _TIME] + kept[piece, _LENGTH] * point))
    return float(memory[START])


@njit
def _passage(basis: Basis, piece: Array, level: float, node: int) -> float:
    """Point of a kept piece at which z last passed `level` upwards before `node`; 1 if it did in a jump at the end of the piece,
    -1 if z was above `level` all the time."""
    z = piece[HEAD:]
    if node == z.size and z[node - 1] < level:
        return 1.0
    if piece[_LOWEST] < level:
        for j in range(min(node, z.size - 1) - 1, -1, -1):
            if z[j] < level:
                return find_root(basis, z, level, basis.nodes[j], basis.nodes[j + 1])
    return find_root(basis, z, level, 0.0, basis.nodes[0]) if evaluate(basis, z, 0.0) < level <= z[0] else -1.0


@inlined
def _keep(time: float, length: float, z: Array, memory: Array, kept: Array) -> int:
    """Append a piece and return its place. If there is no room, drop the pieces before the front, or else every other piece."""
    front, end = int(memory[FRONT]), int(memory[KEPT])
    if end == kept.shape[0]:
        step = 1 if front > 0 else 2
        for i in range((end - front) // step):
            for column in range(kept.shape[1]):
                kept[i, column] = kept[front + step * i, column]
        end = (end - front) // step
        memory[FRONT] = 0.0
    kept[end, _TIME] = time
    kept[end, _LENGTH] = length
    kept[end, _LOWEST] = bounds(z)[0]
    for j in range(z.size):
        kept[end, HEAD + j] = z[j]
    memory[KEPT] = end + 1
    return end
