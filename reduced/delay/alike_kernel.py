"""The compiled march of the delay system for alike plain slabs: collocation steps that divide the transit.

With one slab's incoming characteristic S = mu + eps v/2 (MODEL.md section 3), the equations of interface and state are, on the t~
clock,

    F(z, psi) + (eps/2) v(z) = S,     psi' = r G(z, psi) + nudge(t),     S(t + 1) = S(t) - eps v(t) + eps V(t + 1/2),

which is (29, 35) with S = mu_ss + eps V/2 - 2 eps g(t - 1). Delayed values lie on the same collocation nodes, so nothing is
interpolated.
"""

from typing import NamedTuple

import numpy as np

from reduced.step.collocation import Nodes
from reduced.step.guess import DONE, force, hold, judge_step, predict
from reduced.step.newton import RATE, STATE, UNKNOWN, WORK_ROWS, solve_step
from slipwave.compiled import inlined, njit, overwrite
from slipwave.friction import Law
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene.drive import Constant, Ramps, velocity_at
from slipwave.scene.forcing import Forcing

# entries of `now`
TIME, PSI, ELASTIC = 0, 1, 2


class AlikeMemory(NamedTuple):
    """State at a whole transit. `incoming` (steps, s): S at the nodes of the next transit; `lengths` (steps,) of its steps in
    transits; `guess` (2, s): predicted nodal psi and z of the next step; `now`: time (transits), psi, y."""

    incoming: Array
    lengths: Array
    guess: Array
    now: Array


class Matrices(NamedTuple):
    """Transposed collocation matrices (columns contiguous) and the row that extracts the highest Legendre coefficient."""

    integral: Array
    predict: Array
    predict_state: Array
    tail: Array


@inlined
def emit(
    nodes: Nodes,
    epsilon: float,
    drive: Constant | Ramps,
    start: float,
    length: float,
    integral: Array,
    incoming: Array,
    i: int,
    guess: Array,
    work: Array,
    now: Array,
    pieces: Pieces,
    k: int,
) -> None:
    """Write the step as piece k and advance the elastic stress y' = epsilon (V - v)."""
    s = len(nodes)
    pieces.time[k] = start
    pieces.length[k] = length
    for j in range(s):
        pieces.z[k, j] = guess[UNKNOWN, j]
        pieces.psi[k, j] = guess[STATE, j]
        pieces.mu[k, j] = incoming[i, j] - 0.5 * epsilon * work[RATE, j]
        pieces.y[k, j] = now[ELASTIC]
    for m in range(s):
        factor = length * epsilon * (velocity_at(drive, start + nodes[m] * length) - work[RATE, m])
        for j in range(s):
            pieces.y[k, j] += integral[m, j] * factor
    now[ELASTIC] = pieces.y[k, s - 1]


@njit
def march_delay(
    nodes: Nodes,
    law: Law,
    epsilon: float,
    forcing: Forcing,
    drive: Constant | Ramps,
    matrices: Matrices,
    memory: AlikeMemory,
    transits: int,
    newton_tolerance: float,
    resolution: float,
    steepest: float,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March `transits` whole transits; returns (transits kept, Newton iterations, verdict of `judge_step`). If that is not DONE,
    the memory is that of the last whole transit. `pieces` has room for all steps or for those of the last transit."""
    s = len(nodes)
    incoming, guess, now = memory.incoming, memory.guess, memory.now
    integral, predict_rate, predict_state, tail = matrices.integral, matrices.predict, matrices.predict_state, matrices.tail
    transit, nudge = forcing.transit, forcing.nudge
    steps, lengths = incoming.shape[0], memory.lengths
    work, system = np.zeros((WORK_ROWS, s)), np.empty((s, s))
    saved, saved_guess, saved_now = np.empty_like(incoming), np.empty_like(guess), np.empty_like(now)
    iterations, k = 0, pieces.time.size - steps * transits
    for n in range(transits):
        overwrite(saved, incoming)
        overwrite(saved_now, now)
        overwrite(saved_guess, guess)
        for i in range(steps):
            left, start, length = now[PSI], now[TIME], lengths[i]
            h = length * transit
            if nudge != 0.0:
                force(nodes, nudge, start, length, integral, work)
            used = solve_step(nodes, law, 0.5 * epsilon, h, left, incoming, i, integral, newton_tolerance, guess, work, system)
            iterations += used
            verdict = judge_step(nodes, tail, guess, work, used, resolution, steepest)
            if verdict != DONE:
                overwrite(incoming, saved)
                overwrite(now, saved_now)
                overwrite(guess, saved_guess)
                return n, iterations, verdict
            if k >= 0:
                emit(nodes, epsilon, drive, start, length, integral, incoming, i, guess, work, now, pieces, k)
            k += 1
            for j in range(s):
                incoming[i, j] += epsilon * (velocity_at(drive, start + nodes[j] * length + 0.5) - work[RATE, j])
            now[PSI] = guess[STATE, s - 1]
            now[TIME] = start + length
            last = guess[UNKNOWN, s - 1]
            predict(nodes, predict_rate, predict_state, left, guess, work)
            if lengths[i + 1 if i + 1 < steps else 0] != length:
                hold(nodes, now[PSI], last, guess)
        now[TIME] = saved_now[TIME] + 1.0  # a sum of steps would accumulate rounding
    return transits, iterations, DONE
