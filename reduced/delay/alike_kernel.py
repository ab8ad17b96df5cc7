"""The compiled march of the delay system for alike plain slabs: collocation steps that divide the transit.

With one slab's incoming characteristic S = mu + eps v/2 (MODEL.md section 3), the equations of interface and state are, on the t~
clock,

    F(z, psi) + (eps/2) v(z) = S,     psi' = r G(z, psi) + nudge(t),     S(t + 1) = S(t) - eps v(t) + eps V(t + 1/2),

which is (29, 35) with S = mu_ss + eps V/2 - 2 eps g(t - 1). Delayed values lie on the same collocation nodes, so nothing is
interpolated.
"""

from typing import NamedTuple

from slipwave.compiled import inlined, njit, overwrite
from slipwave.friction import Law
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene.drive import Constant, Ramps, velocity_at
from slipwave.scene.forcing import Forcing
from slipwave.step.collocation import EQUAL, Nodes, Rule
from slipwave.step.guess import DONE, force, hold, judge_step, predict
from slipwave.step.impedance import Diagonal
from slipwave.step.newton import solve
from slipwave.step.record import emit
from slipwave.step.rows import DRIVE, RATE, STATE, UNKNOWN, Scratch

# entries of `now`
TIME, PSI, ELASTIC = 0, 1, 2


class AlikeMemory(NamedTuple):
    """State at a whole transit. `incoming` (steps, s): S at the nodes of the next transit; `lengths` (steps,) of its steps in
    transits; `guess` (2, s): predicted nodal psi and z of the next step; `now`: time (transits), psi, y."""

    incoming: Array
    lengths: Array
    guess: Array
    now: Array


@inlined
def _copy(source: AlikeMemory, target: AlikeMemory) -> None:
    overwrite(target.incoming, source.incoming)
    overwrite(target.guess, source.guess)
    overwrite(target.now, source.now)


@njit
def march_delay(
    nodes: Nodes,
    law: Law,
    epsilon: float,
    forcing: Forcing,
    drive: Constant | Ramps,
    rule: Rule,
    memory: AlikeMemory,
    saved: AlikeMemory,
    scratch: Scratch,
    transits: int,
    newton_tolerance: float,
    resolution: float,
    steepest: float,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March `transits` whole transits; returns (transits kept, Newton iterations, verdict of `judge_step`). If that is not DONE,
    the memory is that of the last whole transit, kept in `saved`. `pieces` has room for all steps or for those of the last
    transit."""
    s = len(nodes)
    incoming, guess, now = memory.incoming, memory.guess, memory.now
    transit, nudge = forcing.transit, forcing.nudge
    steps, lengths = incoming.shape[0], memory.lengths
    work, system, impedance = scratch.work, scratch.system, Diagonal(0.5 * epsilon)
    iterations, k = 0, pieces.time.size - steps * transits
    for n in range(transits):
        _copy(memory, saved)
        for i in range(steps):
            left, start, length = now[PSI], now[TIME], lengths[i]
            h, middle = length * transit, start + 0.5 * length
            if nudge != 0.0:
                force(nodes, nudge, start, length, rule.integral, work)
            used = solve(nodes, law, impedance, h, left, incoming, i, rule.integral, newton_tolerance, guess, work, system)
            iterations += used
            verdict = judge_step(nodes, rule.tail, guess, work, used, resolution, steepest)
            if verdict != DONE:
                _copy(saved, memory)
                return n, iterations, verdict
            if k >= 0:
                for j in range(s):
                    work[DRIVE, j] = velocity_at(drive, start + nodes[j] * length, middle)
                now[ELASTIC] = emit(
                    nodes, epsilon, impedance, start, length, rule.integral, incoming, i, guess, work, now[ELASTIC], pieces, k
                )
            k += 1
            for j in range(s):
                incoming[i, j] += epsilon * (velocity_at(drive, start + nodes[j] * length + 0.5, middle + 0.5) - work[RATE, j])
            now[PSI] = guess[STATE, s - 1]
            now[TIME] = start + length
            last = guess[UNKNOWN, s - 1]
            overwrite(scratch.guess, guess)
            predict(nodes, rule, EQUAL, left, scratch.guess, guess)
            if lengths[i + 1 if i + 1 < steps else 0] != length:
                hold(nodes, now[PSI], last, guess)
        now[TIME] = saved.now[TIME] + 1.0  # a sum of steps would accumulate rounding
    return transits, iterations, DONE
