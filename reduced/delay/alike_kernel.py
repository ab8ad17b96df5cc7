"""The compiled march of the delay system for alike plain slabs: collocation steps that divide the transit.

With one slab's incoming characteristic S = mu + eps v/2 (MODEL.md section 3), interface and state obey, on the t~ clock,

    F(z, psi) + (eps/2) v(z) = S,     psi' = r G(z, psi) + nudge(t),     S(t + 1) = S(t) - eps v(t) + eps V(t + 1/2),

which is (29, 35) with S = mu_ss + eps V/2 - 2 eps g(t - 1). Delayed values fall on the same collocation nodes: no interpolation.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    """State at a step's end. `incoming` (steps, s): S at the nodes of the coming transit, from row `cursor[0]` on cyclically;
    `lengths` (steps,) of the steps in transits; `guess` (2, s): predicted nodal psi and z of the next step; `now`: time
    (transits), psi, y."""

    incoming: Array
    lengths: Array
    guess: Array
    now: Array
    cursor: NDArray[np.int64]


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
    count: int,
    newton_tolerance: float,
    resolution: float,
    steepest: float,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March `count` steps; returns (steps kept, Newton iterations, verdict of `judge_step`). Where that is not DONE the memory is
    back at the last whole transit."""
    s = len(nodes)
    incoming, guess, now = memory.incoming, memory.guess, memory.now
    integral, predict_rate, predict_state, tail = matrices.integral, matrices.predict, matrices.predict_state, matrices.tail
    transit, nudge = forcing.transit, forcing.nudge
    steps, lengths = incoming.shape[0], memory.lengths
    work, system = np.zeros((WORK_ROWS, s)), np.empty((s, s))
    saved, saved_guess, saved_now = np.empty_like(incoming), np.empty_like(guess), np.empty_like(now)
    overwrite(saved, incoming)
    overwrite(saved_now, now)
    overwrite(saved_guess, guess)
    i, anchor, iterations = memory.cursor[0], 0, 0
    for n in range(count):
        if i == 0:
            anchor = n
            overwrite(saved, incoming)
            overwrite(saved_now, now)
            overwrite(saved_guess, guess)
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
            memory.cursor[0] = (i - (n - anchor)) % steps
            return anchor, iterations, verdict
        if pieces.time.size == count:
            emit(nodes, epsilon, drive, start, length, integral, incoming, i, guess, work, now, pieces, n)
        elif n == count - 1:
            emit(nodes, epsilon, drive, start, length, integral, incoming, i, guess, work, now, pieces, 0)
        for j in range(s):
            incoming[i, j] += epsilon * (velocity_at(drive, start + nodes[j] * length + 0.5) - work[RATE, j])
        now[PSI] = guess[STATE, s - 1]
        now[TIME] = start + length
        i, last = i + 1 if i + 1 < steps else 0, guess[UNKNOWN, s - 1]
        predict(nodes, predict_rate, predict_state, left, guess, work)
        if lengths[i] != length:
            hold(nodes, now[PSI], last, guess)
    memory.cursor[0] = i
    return count, iterations, DONE
