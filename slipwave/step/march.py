"""The march of friction against any port (`slipwave.step.port`): collocated steps whose lengths follow the motion.

A step is accepted if the highest Legendre coefficients of z and of psi are below the resolution and no disturbance grows faster
than a step reproduces (`grows_unseen`). Otherwise a step half as long is tried. A step twice as long follows where the
coefficients are small; it begins at a multiple of its length, so that a jump of the motion at a whole transit stays at the end of
a step.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import inlined, njit
from slipwave.friction import Law
from slipwave.observe.pieces import SAME, Array, Pieces
from slipwave.scene.drive import Constant, Ramps, velocity_at
from slipwave.scene.forcing import Forcing
from slipwave.step.collocation import EQUAL, RATIOS, Nodes, Rule
from slipwave.step.guess import force, hold, predict
from slipwave.step.impedance import Full, own
from slipwave.step.newton import solve
from slipwave.step.port import Port, arrive, take_in
from slipwave.step.record import emit
from slipwave.step.rows import BY_Z, DRIVE, INVERSE, RATE_SLOPE, RATIO, SLOPE, STATE, UNKNOWN, Scratch

# entries of `Memory.now`; LEFT is psi at the start of the last step
TIME, PSI, ELASTIC, END, LEFT = range(5)
# entries of `Memory.levels`
NEXT, LAST = 0, 1

DONE, TOO_LONG, NOT_READY = range(3)
"""Why a march ends: it is where it should be; no step is short enough; the port has no tables for the next step yet."""

ANY_LENGTH: NDArray[np.int64] = np.empty(0, dtype=np.int64)
"""The plan of a march whose steps follow the motion."""

_NONE = -1


class Limits(NamedTuple):
    """`newton` and `resolution`: allowed errors of the iteration and of the polynomials; `growth`: the largest that a step
    reproduces; `impedance` (L,): Z at s = growth/length of every level, in units of the normal stress over V*."""

    newton: float
    resolution: float
    growth: float
    impedance: Array


class Memory(NamedTuple):
    """`last` (2, s): psi and z at the nodes of the last step; `now` (5,): time (transits), psi, y, z at the present, psi at the
    last step's start; `levels` (2,): of the next step and of the last (-1: none)."""

    last: Array
    now: Array
    levels: NDArray[np.int64]


def resolution_of(tolerance: float, stages: int) -> float:
    """The highest Legendre coefficient of z and psi in a step that fits `tolerance`, the relative error of a cycle's figures."""
    return float(tolerance ** (stages / (stages + 2.0)))


def begin(psi: float, elastic: float, z: float, stages: int) -> Memory:
    """Memory at t = 0."""
    return Memory(np.zeros((2, stages)), np.array([0.0, psi, elastic, z, psi]), np.array([0, _NONE]))


@njit
def _guess(nodes: Nodes, rule: Rule, memory: Memory, guess: Array) -> None:
    """Guess of the next step: the last step's polynomials, extended, or constant values after a step of very different length."""
    last, now, levels = memory.last, memory.now, memory.levels
    ratio = levels[LAST] - levels[NEXT] + EQUAL
    if levels[LAST] == _NONE or ratio < 0 or ratio >= len(RATIOS):
        hold(nodes, now[PSI], now[END], guess)
        return
    predict(nodes, rule, ratio, now[LEFT], last, guess)


@inlined
def _size_of_tail(nodes: Nodes, tail: Array, guess: Array) -> float:
    """The larger of the highest Legendre coefficients of z and psi."""
    z, psi = 0.0, 0.0
    for j in range(len(nodes)):
        z += tail[j] * guess[UNKNOWN, j]
        psi += tail[j] * guess[STATE, j]
    return max(abs(z), abs(psi)) if math.isfinite(z + psi) else math.inf


@njit
def grows_unseen(nodes: Nodes, impedance: Full, limits: Limits, level: int, work: Array) -> bool:
    """Whether a disturbance of the state at some node would grow by more than e^g within the step, g = `limits.growth`.

    With coefficients frozen at a node, the growth rates s are the zeros of (F_z + Z(s) v_z)(s - G_psi) + F_psi G_z. This is
    positive for large s; if it is negative at s = g/length, there is a real zero beyond.
    """
    for j in range(len(nodes)):
        total = 1.0 / work[INVERSE, j]
        resistance = total + (limits.impedance[level] - own(impedance, j)) * work[RATE_SLOPE, j]
        by_psi = work[SLOPE, j] + work[BY_Z, j] * work[RATIO, j]
        if resistance * (limits.growth - by_psi) + work[RATIO, j] * total * work[BY_Z, j] < 0.0:
            return True
    return False


@inlined
def _may_double(time: float, origin: float, length: float) -> bool:
    """Whether `time` is a multiple of twice the length."""
    count = (time - origin) / (2.0 * length)
    return abs(count - math.floor(count + 0.5)) < 1e-3


@inlined
def _end_of(start: float, origin: float, length: float) -> float:
    """End of a step that begins at `start`, a multiple of its length: a sum would miss a far break by its rounding."""
    return origin + length * (math.floor((start - origin) / length + 0.5) + 1.0)


@njit
def march(
    nodes: Nodes,
    law: Law,
    forcing: Forcing,
    drive: Constant | Ramps,
    port: Port,
    rule: Rule,
    memory: Memory,
    impedance: Full,
    scratch: Scratch,
    until: float,
    origin: float,
    stop: float,
    limits: Limits,
    plan: NDArray[np.int64],
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March to `until`, or until the pieces are full; returns (steps, Newton iterations, why it ended). Step lengths hold from
    `origin`; the last step may end beyond `until`, but not beyond `stop`. `plan`: the level of each step, whatever the motion;
    empty: lengths follow the motion."""
    s = len(nodes)
    last, now, levels = memory.last, memory.now, memory.levels
    guess, work, system, incoming = scratch
    deepest = port.length.size - 1
    iterations, k, planned = 0, 0, plan.size > 0
    while k < pieces.time.size and now[TIME] < min(until, stop) - SAME:
        if planned:
            levels[NEXT] = plan[k]
        while levels[NEXT] < deepest and now[TIME] + port.length[levels[NEXT]] > stop + SAME:
            levels[NEXT] += 1
        level = levels[NEXT]
        if not port.ready[level]:
            return k, iterations, NOT_READY
        start, left, length = now[TIME], now[PSI], port.length[level]
        for j in range(s):
            work[DRIVE, j] = velocity_at(drive, start + nodes[j] * length, start + 0.5 * length)
            for m in range(s):
                impedance.matrix[j, m] = port.impedance[level, j, m]
        _guess(nodes, rule, memory, guess)
        arrive(port, nodes, level, incoming, work)
        if forcing.nudge != 0.0:
            force(nodes, forcing.nudge, start, length, rule.integral, work)
        h = length * forcing.transit
        used = solve(nodes, law, impedance, h, left, incoming, 0, rule.integral, limits.newton, guess, work, system)
        iterations += used
        size = _size_of_tail(nodes, rule.tail, guess)
        rough = not planned and (not size <= limits.resolution or grows_unseen(nodes, impedance, limits, level, work))
        if used == 0 or rough:
            if planned and levels[LAST] != _NONE:  # try again from constant values
                levels[LAST] = _NONE
                continue
            if planned or level == deepest:
                return k, iterations, TOO_LONG
            levels[NEXT] = level + 1
            continue
        now[ELASTIC] = emit(
            nodes, forcing.stiffness, impedance, start, length, rule.integral, incoming, 0, guess, work, now[ELASTIC], pieces, k
        )
        take_in(port, nodes, level, rule.integral, incoming, work)
        for j in range(s):
            last[STATE, j], last[UNKNOWN, j] = guess[STATE, j], guess[UNKNOWN, j]
        now[TIME], now[LEFT], now[PSI] = _end_of(start, origin, length), left, guess[STATE, s - 1]
        now[END] = guess[UNKNOWN, s - 1]
        levels[LAST] = level
        longer = level > 0 and size < 0.5 ** (s + 1) * limits.resolution and _may_double(now[TIME], origin, length)
        levels[NEXT] = level - 1 if longer else level
        k += 1
    return k, iterations, DONE
