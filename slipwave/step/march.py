"""The march of friction against any port (`slipwave.step.port`): collocated steps whose lengths follow the motion.

A step is accepted if the highest Legendre coefficients of z and of psi are below the resolution and no disturbance grows faster
than a step reproduces (`_grows_unseen`). Otherwise a step half as long is tried. A step twice as long follows where the
coefficients are small; it begins at a multiple of its length, so that a jump of the motion at a whole transit stays at the end of
a step.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import njit
from slipwave.friction import Law, law_of_step, to_own, to_step
from slipwave.observe.pieces import Array, Pieces, slack
from slipwave.step.collocation import EQUAL, RATIOS, Nodes, Rule
from slipwave.step.impedance import Full, own
from slipwave.step.newton import emit, solve
from slipwave.step.nodal import (
    DONE,
    ELASTIC,
    PSI,
    TIME,
    Interface,
    Limits,
    Nodal,
    Physics,
    begin_step,
    hold,
    predict,
    tail_of,
)
from slipwave.step.port import Port, arrive, take_in

END, LEFT = 3, 4
"""Further entries of `Memory.now`: z at the present, psi at the start of the last step."""

# entries of `Memory.levels`
NEXT, LAST = 0, 1

TOO_LONG, NOT_READY = 1, 2
"""Why a march ends if not DONE: no step is short enough; the port has no tables for the next step yet."""

ANY_LENGTH: NDArray[np.int64] = np.empty(0, dtype=np.int64)
"""The plan of a march whose steps follow the motion."""

_NONE = -1


class Memory(NamedTuple):
    """`last`: psi and z of the `law_of_step` at the nodes of the last step; `now` (5,): time (transits), psi, y, z now,
    psi at the last step's start; `levels` (2,): of the next step and of the last (-1: none)."""

    last: Interface
    now: Array
    levels: NDArray[np.int64]


class Stretch(NamedTuple):
    """Steps whose lengths hold from the time `origin` (transits), to `until`: the last may end beyond that, but not beyond
    `stop`. `resistance` (L,): Z at s = growth/length of every level, in units of the normal stress over V*. `plan`: the level of
    each step, whatever the motion; empty: lengths follow the motion."""

    origin: float
    until: float
    stop: float
    resistance: Array
    plan: NDArray[np.int64]


def resolution_of(tolerance: float, stages: int) -> float:
    """The highest Legendre coefficient of z and psi in a step that fits `tolerance`, the relative error of a cycle's figures."""
    return float(tolerance ** (stages / (stages + 2.0)))


def begin(psi: float, elastic: float, z: float, stages: int) -> Memory:
    """Memory of a march that starts from `psi`, the `elastic` stress and `z`, at t = 0."""
    return Memory(Interface(*np.zeros((2, stages))), np.array([0.0, psi, elastic, z, psi]), np.array([0, _NONE]))


@njit
def _guess(nodes: Nodes, law: Law, own: Law, rule: Rule, memory: Memory, nodal: Nodal) -> None:
    """Guess of the next step, in the rate unknown of its `law`: the last step's polynomials, extrapolated, or constants after a
    step of very different length. `own`: the law of which it is the `law_of_step`."""
    now, levels, guess = memory.now, memory.levels, Interface(nodal.psi, nodal.z)
    ratio = levels[LAST] - levels[NEXT] + EQUAL
    if levels[LAST] == _NONE or ratio < 0 or ratio >= len(RATIOS):
        hold(nodes, now[PSI], now[END], guess)
    else:
        predict(nodes, rule, ratio, now[LEFT], memory.last, guess)
        to_own(law_of_step(own, now[LEFT]), nodal.z)
    to_step(law, own, nodal.z)


@njit
def _grows_unseen(
    nodes: Nodes, impedance: Full, resistance: float, limits: Limits, nodal: Nodal, first: int = 0, longer: float = 1.0
) -> bool:
    """Whether a disturbance of the state at some node, from the `first` on, would grow by more than e^`growth` within a step
    `longer` times as long as this one, where the slabs' impedance for such growth is `resistance`, or might grow while it swings
    by more than the angle `swing` of the `limits`.

    With coefficients frozen at a node, the growth rates s are the zeros of (F_z + Z(s) v_z)(s - G_psi) + F_psi G_z. This is
    positive for large s; if it is negative at s = growth/length, there is a real zero beyond. Passive slabs (Re Z >= 0) let only
    those swings grow for which friction weakens, Re (F_z + F_psi G_z/(i w - G_psi)) < 0: of angles up to
    (w length)^2 = F_psi G_z G_psi/F_z - G_psi^2, with G times the length.
    """
    growth = limits.growth
    for j in range(first, len(nodes)):
        total, by_z = 1.0 / nodal.inverse[j], longer * nodal.by_z[j]
        resists = total + (resistance - own(impedance, j)) * nodal.v_z[j]
        by_psi = longer * nodal.slope[j] + by_z * nodal.ratio[j]
        friction_z = total - own(impedance, j) * nodal.v_z[j]
        swing = by_psi * (nodal.ratio[j] * total * by_z / friction_z - by_psi)
        if swing > limits.swing * limits.swing or resists * (growth - by_psi) + nodal.ratio[j] * total * by_z < 0.0:
            return True
    return False


@njit
def march(
    nodes: Nodes, physics: Physics, port: Port, memory: Memory, nodal: Nodal, limits: Limits, stretch: Stretch, pieces: Pieces
) -> tuple[int, int, int]:
    """March over a `stretch`, or until the pieces are full; returns (steps, Newton iterations, why it ended)."""
    s, (own_law, forcing, _, rule) = len(nodes), physics
    now, levels, origin, plan = memory.now, memory.levels, stretch.origin, stretch.plan
    deepest = port.length.size - 1
    iterations, k, planned = 0, 0, plan.size > 0
    while k < pieces.time.size and now[TIME] < min(stretch.until, stretch.stop) - slack(now[TIME]):
        if planned:
            levels[NEXT] = plan[k]
        while levels[NEXT] < deepest and now[TIME] + port.length[levels[NEXT]] > stretch.stop + slack(now[TIME]):
            levels[NEXT] += 1
        level = levels[NEXT]
        if not port.ready[level]:
            return k, iterations, NOT_READY
        start, left, length = now[TIME], now[PSI], port.length[level]
        impedance, law = Full(port.impedance[level]), law_of_step(own_law, left)
        begin_step(nodes, physics, start, length, left, nodal)
        _guess(nodes, law, own_law, rule, memory, nodal)
        arrive(port, nodes, level, nodal)
        used = solve(law, nodes, impedance, length * forcing.transit, rule, limits.newton, nodal)
        iterations += used
        tails = tail_of(nodes, rule.tail, nodal.z), tail_of(nodes, rule.tail, nodal.psi)
        size = max(abs(tails[0]), abs(tails[1])) if math.isfinite(tails[0] + tails[1]) else math.inf
        rough = not planned and (
            not size <= limits.resolution or _grows_unseen(nodes, impedance, stretch.resistance[level], limits, nodal)
        )
        if used == 0 or rough:
            if planned and levels[LAST] != _NONE:  # try again from constant values
                levels[LAST] = _NONE
                continue
            if planned or level == deepest:
                return k, iterations, TOO_LONG
            levels[NEXT] = level + 1
            continue
        for j in range(s):
            memory.last.psi[j], memory.last.z[j] = nodal.psi[j], nodal.z[j]
        to_own(law, nodal.z)
        step = (start, length)
        now[ELASTIC] += emit(nodes, forcing.stiffness, impedance, step, rule.integral, nodal, now[ELASTIC], pieces, k)
        take_in(port, nodes, level, rule.integral, nodal)
        # `start` is a multiple of the length: its end, without the rounding of a sum, which would miss a late break point
        now[TIME] = origin + length * (math.floor((start - origin) / length + 0.5) + 1.0)
        now[LEFT], now[PSI], now[END] = left, nodal.psi[s - 1], nodal.z[s - 1]
        levels[LAST] = level
        pairs = (now[TIME] - origin) / (2.0 * length)
        may_double = abs(pairs - math.floor(pairs + 0.5)) < 1e-3  # the end is a multiple of twice the length
        longer = level > 0 and size < 0.5 ** (s + 1) * limits.resolution and may_double
        if longer and not planned:  # not tried in vain where already the end of this step forbids it
            longer = not _grows_unseen(nodes, impedance, stretch.resistance[level - 1], limits, nodal, s - 1, 2.0)
        levels[NEXT] = level - 1 if longer else level
        k += 1
    return k, iterations, DONE
