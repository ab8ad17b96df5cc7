"""The compiled march of the delay system for alike plain slabs: collocation steps that divide the transit.

With one slab's incoming characteristic S = mu + eps v/2 (MODEL.md section 3), interface and state obey, on the t~ clock,

    F(z, psi) + (eps/2) v(z) = S,     psi' = r G(z, psi) + nudge(t),     S(t + 1) = S(t) - eps v(t) + eps V(t + 1/2),

which is (29, 35) with S = mu_ss + eps V/2 - 2 eps g(t - 1). Delayed values fall on the same collocation nodes: no interpolation.

`nodes` is a tuple so that the compiler knows how many there are and unrolls the small loops (a factor 1.7 measured); the parts
are inlined and take arrays one by one: calls, tuples of arrays and row views cost reference counting (a factor 1.5 measured).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.collocation import Nodes
from scene.compiled import inlined, njit, overwrite
from scene.drive import interpolate_drive
from scene.friction import Law, respond
from scene.interface import solve_interface
from scene.observe.pieces import Array, Pieces
from scene.start import NUDGE_CENTRE, NUDGE_REACH

_MAX_NEWTON = 25
_LARGEST_CHANGE = 2.0
_WEAK_COUPLING = 0.04


# rows of the guess, entries of `now`, rows of the scratch
STATE, UNKNOWN = 0, 1
TIME, PSI, ELASTIC = 0, 1, 2
RATE, RATE_SLOPE, MISMATCH, RATIO, INCREMENT, SLOPE, WEIGHT, WEIGHT_STATE, CHANGE, PREVIOUS, FRESH, FORCED = range(12)
WORK_ROWS = 12


class Memory(NamedTuple):
    """State at a step's end. `incoming` (steps, s): S at the nodes of the coming transit, from row `cursor[0]` on cyclically;
    `guess` (2, s): predicted nodal psi and z of the next step; `now`: time (transits), psi, y."""

    incoming: Array
    guess: Array
    now: Array
    cursor: NDArray[np.int64]


class Matrices(NamedTuple):
    """Transposed collocation matrices (columns contiguous) and the row that extracts the highest Legendre coefficient."""

    integral: Array
    predict: Array
    predict_state: Array
    tail: Array


class Physics(NamedTuple):
    """epsilon, round trip r, nudge size, times and velocities of the drive (arrays of equal length)."""

    epsilon: float
    round_trip: float
    nudge: float
    drive_times: Array
    drive_velocities: Array


@inlined
def linearise(nodes: Nodes, law: Law, impedance: float, h: float, incoming: Array, i: int, guess: Array, work: Array) -> float:
    """Per node: friction and state linearised at the guess with z eliminated; returns the largest coupling |slope|."""
    s = len(nodes)
    coupling = 0.0
    for j in range(s):
        v, v_z, friction, friction_z, friction_psi, g, g_z, g_psi = respond(law, guess[UNKNOWN, j], guess[STATE, j])
        inverse = 1.0 / (friction_z + impedance * v_z)
        mismatch = (friction + impedance * v - incoming[i, j]) * inverse
        ratio = friction_psi * inverse
        slope = h * (g_psi - g_z * ratio)
        work[RATE, j] = v
        work[RATE_SLOPE, j] = v_z
        work[MISMATCH, j] = mismatch
        work[RATIO, j] = ratio
        work[INCREMENT, j] = h * (g - g_z * mismatch)
        work[SLOPE, j] = slope
        work[WEIGHT, j] = 0.5 * (impedance * v_z * inverse + abs(h * g_z))
        work[WEIGHT_STATE, j] = 0.5 * abs(h * g_psi)
        coupling = max(coupling, abs(slope))
    return coupling


@inlined
def neumann(nodes: Nodes, integral: Array, work: Array, sweeps: int) -> None:
    """change <- (1 + K + ... + K^sweeps) change with K = A diag(slope), small: enough inside a Newton iteration."""
    s = len(nodes)
    for j in range(s):
        work[PREVIOUS, j] = work[CHANGE, j]
    for _ in range(sweeps):
        for j in range(s):
            work[FRESH, j] = work[CHANGE, j]
        for k in range(s):
            factor = work[SLOPE, k] * work[PREVIOUS, k]
            for j in range(s):
                work[FRESH, j] += integral[k, j] * factor
        for j in range(s):
            work[PREVIOUS, j] = work[FRESH, j]
    for j in range(s):
        work[CHANGE, j] = work[PREVIOUS, j]


@inlined
def eliminate(nodes: Nodes, integral: Array, work: Array, system: Array) -> None:
    """change <- (1 - A diag(slope))^-1 change by Gaussian elimination; the diagonal dominates for any resolved step."""
    s = len(nodes)
    for k in range(s):
        factor = work[SLOPE, k]
        for j in range(s):
            system[j, k] = -integral[k, j] * factor
        system[k, k] += 1.0
    for k in range(s):
        inverse = 1.0 / system[k, k]
        system[k, k] = inverse
        for j in range(k + 1, s):
            factor = system[j, k] * inverse
            for m in range(k + 1, s):
                system[j, m] -= factor * system[k, m]
            work[CHANGE, j] -= factor * work[CHANGE, k]
    for k in range(s - 1, -1, -1):
        factor = work[CHANGE, k] * system[k, k]
        work[CHANGE, k] = factor
        for j in range(k):
            work[CHANGE, j] -= system[j, k] * factor


@inlined
def correct(nodes: Nodes, guess: Array, work: Array) -> float:
    """Apply the change to psi, z and v in place; returns an estimate of what the linearisation neglected.

    v is continued by v'' = v, exact for v = e^z and v = 2 c sinh z, so no exponential is evaluated again.
    """
    s = len(nodes)
    error = 0.0
    for j in range(s):
        by_psi = work[CHANGE, j]
        by_z = -work[MISMATCH, j] - work[RATIO, j] * by_psi
        by_z = min(_LARGEST_CHANGE, max(-_LARGEST_CHANGE, by_z))
        guess[STATE, j] += by_psi
        guess[UNKNOWN, j] += by_z
        square = by_z * by_z
        even = 1.0 + square * (0.5 + square / 24.0)
        odd = by_z * (1.0 + square * (1.0 / 6.0 + square / 120.0))
        work[RATE, j] = work[RATE, j] * even + work[RATE_SLOPE, j] * odd
        neglected = work[WEIGHT, j] * square + work[WEIGHT_STATE, j] * by_psi * by_psi + 1e-2 * square * square * abs(by_z)
        error = max(error, neglected)
    return error


@njit
def force(nodes: Nodes, nudge: float, start: float, length: float, integral: Array, work: Array) -> None:
    """work[FORCED] <- integral of the nudge from the step's start to each node; kept out of the Newton loop, which it would slow
    by a quarter."""
    for j in range(len(nodes)):
        work[FORCED, j] = 0.0
    if abs(start - NUDGE_CENTRE) > NUDGE_REACH:
        return
    for k in range(len(nodes)):
        since = start + nodes[k] * length - NUDGE_CENTRE
        size = length * nudge * math.exp(-since * since)
        for j in range(len(nodes)):
            work[FORCED, j] += integral[k, j] * size


@inlined
def solve_step(
    nodes: Nodes,
    law: Law,
    impedance: float,
    h: float,
    psi: float,
    incoming: Array,
    i: int,
    integral: Array,
    newton_tolerance: float,
    guess: Array,
    work: Array,
    system: Array,
) -> int:
    """Newton for the step's nodal psi and z, from and into `guess`, nodal v into work[RATE]; returns iterations, 0 = failed.

    z is eliminated node by node, and the small system for psi is summed (Neumann) where the state couples weakly, as in
    the stick, else eliminated.
    """
    s = len(nodes)
    for iteration in range(1, _MAX_NEWTON + 1):
        coupling = linearise(nodes, law, impedance, h, incoming, i, guess, work)
        if not math.isfinite(coupling):
            return 0
        for j in range(s):
            work[CHANGE, j] = psi - guess[STATE, j] + work[FORCED, j]
        for k in range(s):
            factor = work[INCREMENT, k]
            for j in range(s):
                work[CHANGE, j] += integral[k, j] * factor
        if coupling < _WEAK_COUPLING:
            neumann(nodes, integral, work, 2 if coupling < 0.01 else 3)
        else:
            eliminate(nodes, integral, work, system)
        error = correct(nodes, guess, work)
        if error < newton_tolerance:
            return iteration
    return 0


@inlined
def predict(nodes: Nodes, predict_rate: Array, predict_state: Array, left: float, guess: Array, work: Array) -> None:
    """Replace the nodal values by those one step on of their polynomials: the next step's guess."""
    s = len(nodes)
    for j in range(s):
        work[PREVIOUS, j] = predict_state[0, j] * left
        work[FRESH, j] = 0.0
    for k in range(s):
        psi, z = guess[STATE, k], guess[UNKNOWN, k]
        for j in range(s):
            work[PREVIOUS, j] += predict_state[k + 1, j] * psi
            work[FRESH, j] += predict_rate[k, j] * z
    for j in range(s):
        guess[STATE, j] = work[PREVIOUS, j]
        guess[UNKNOWN, j] = work[FRESH, j]


@inlined
def emit(
    nodes: Nodes,
    epsilon: float,
    velocity: float,
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
        pieces.unknown[k, j] = guess[UNKNOWN, j]
        pieces.state[k, j] = guess[STATE, j]
        pieces.stress[k, j] = incoming[i, j] - 0.5 * epsilon * work[RATE, j]
        pieces.elastic[k, j] = now[ELASTIC]
    for m in range(s):
        factor = length * epsilon * (velocity - work[RATE, m])
        for j in range(s):
            pieces.elastic[k, j] += integral[m, j] * factor
    now[ELASTIC] = pieces.elastic[k, s - 1]


@njit
def march_delay(
    nodes: Nodes,
    law: Law,
    physics: Physics,
    matrices: Matrices,
    memory: Memory,
    count: int,
    newton_tolerance: float,
    resolution: float,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March `count` steps; returns (steps kept, Newton iterations, verdict): verdict 0 done, 1 Newton failed, 2 the step's
    polynomial is not resolved to `resolution`. After 1 or 2 the memory is back at the last whole transit."""
    s = len(nodes)
    incoming, guess, now = memory.incoming, memory.guess, memory.now
    integral, predict_rate, predict_state, tail = matrices.integral, matrices.predict, matrices.predict_state, matrices.tail
    epsilon, nudge, velocities = physics.epsilon, physics.nudge, physics.drive_velocities
    steps = incoming.shape[0]
    length = 1.0 / steps
    h = length * physics.round_trip
    work, system = np.zeros((WORK_ROWS, s)), np.empty((s, s))
    saved, saved_guess, saved_now = np.empty_like(incoming), np.empty_like(guess), np.empty_like(now)
    overwrite(saved, incoming)
    overwrite(saved_now, now)
    overwrite(saved_guess, guess)
    i, anchor, iterations = memory.cursor[0], 0, 0
    drive_times = physics.drive_times
    constant, velocity = velocities.size == 1, velocities[0]
    for n in range(count):
        if i == 0:
            anchor = n
            overwrite(saved, incoming)
            overwrite(saved_now, now)
            overwrite(saved_guess, guess)
        left, start = now[PSI], now[TIME]
        if nudge != 0.0:
            force(nodes, nudge, start, length, integral, work)
        used = solve_step(
            nodes,
            law,
            0.5 * epsilon,
            h,
            left,
            incoming,
            i,
            integral,
            newton_tolerance,
            guess,
            work,
            system,
        )
        iterations += used
        unresolved = 0.0
        for j in range(s):
            unresolved += tail[j] * guess[UNKNOWN, j]
        if used == 0 or not abs(unresolved) <= resolution:
            overwrite(incoming, saved)
            overwrite(now, saved_now)
            overwrite(guess, saved_guess)
            memory.cursor[0] = (i - (n - anchor)) % steps
            return anchor, iterations, 1 if used == 0 else 2
        if not constant:
            velocity = interpolate_drive(drive_times, velocities, start + 0.5 * length)
        if pieces.time.size == count:
            emit(nodes, epsilon, velocity, start, length, integral, incoming, i, guess, work, now, pieces, n)
        elif n == count - 1:
            emit(nodes, epsilon, velocity, start, length, integral, incoming, i, guess, work, now, pieces, 0)
        for j in range(s):
            if not constant:
                velocity = interpolate_drive(drive_times, velocities, start + nodes[j] * length + 0.5)
            incoming[i, j] += epsilon * (velocity - work[RATE, j])
        now[PSI] = guess[STATE, s - 1]
        now[TIME] = start + length
        i = i + 1 if i + 1 < steps else 0
        predict(nodes, predict_rate, predict_state, left, guess, work)
    memory.cursor[0] = i
    return count, iterations, 0


@njit
def first_guess(law: Law, impedance: float, incoming: Array, psi: float, z: float, guess: Array) -> int:
    """Nodal z for frozen psi; returns the number of non-converged solves. Used where there is no earlier step to extend."""
    failures = 0
    for j in range(guess.size):
        z, iterations = solve_interface(law, impedance, incoming[j], psi, z)
        guess[j] = z
        failures += iterations == 0
    return failures
