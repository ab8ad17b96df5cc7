"""The one stiff integrator of all ODE reductions: Radau collocation of the whole network with the friction interface.

With the stage impedance K of `step_tables`, every reduction is the same interface condition at the nodes of a step,

    F(z_j, psi_j) + epsilon sum_l K_jl v_l = E_j,      psi_j = psi_0 + h sum_l A_jl (r G(z_l, psi_l) + nudge(t_l)),

where E_j follows from the states at the step's start. Newton solves for (psi, z) at the nodes. Steps have lengths
longest / 2^level. A step is accepted if the highest Legendre coefficients of z and of psi are below the resolution and no
disturbance grows faster than a step reproduces (`grows_unseen`).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.ode.step_tables import Tables
from reduced.step.collocation import Nodes
from slipwave.compiled import inlined, njit
from slipwave.friction import Law, respond
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene.drive import Constant, Ramps, velocity_at
from slipwave.scene.forcing import Forcing
from slipwave.scene.start import nudge_rate

TIME, PSI, SPRING, ELASTIC, RATE, UNKNOWN_END = range(6)
STATE, UNKNOWN = 0, 1
_V, _V_Z, _F, _F_Z, _F_PSI, _G, _G_Z, _G_PSI, _DRIVE, _EXTERNAL, _FORCED = range(11)
_WORK_ROWS = 11
_MAX_NEWTON = 12
_LARGEST_CHANGE = 2.0
_FAR = 1e3
SAME = 1e-9  # transits; two times that differ by less are equal


class Rule(NamedTuple):
    """Collocation matrices: `integral` (s, s), `tail` (s,) for the highest Legendre coefficient, and extrapolation to a step as
    long and twice as long, `predict` (2, s, s), `predict_state` (2, s, s + 1)."""

    integral: Array
    tail: Array
    predict: Array
    predict_state: Array


class Limits(NamedTuple):
    """`newton` and `resolution`: allowed errors of the iteration and of the polynomials; `growth`: the largest that a step
    reproduces; `impedance` (L,): Z/epsilon at s = growth/length of every level."""

    newton: float
    resolution: float
    growth: float
    impedance: Array


class ReducedMemory(NamedTuple):
    """`modes` (N, 2): tau, p relative to epsilon; `guess` (2, s); `now`: time, psi, spring stress / epsilon, y, v, z;
    `level` (1,) of the next step."""

    modes: Array
    guess: Array
    now: Array
    level: NDArray[np.int64]


@inlined
def external_stress(
    nodes: Nodes, epsilon: float, tables: Tables, level: int, modes: Array, spring: float, rate: float, work: Array
) -> None:
    """E_j: spring, modes and momentum at the step's start, and the drive's part of the stage impedance."""
    s = len(nodes)
    for j in range(s):
        total = spring + tables.inertia[level, j] * rate
        for n in range(modes.shape[0]):
            total += tables.free[level, n, 0, j] * modes[n, 0] + tables.free[level, n, 1, j] * modes[n, 1]
        for m in range(s):
            total += tables.elastic[level, j, m] * work[_DRIVE, m]
        work[_EXTERNAL, j] = epsilon * total


@njit
def force(nodes: Nodes, nudge: float, start: float, length: float, work: Array) -> None:
    """work[_FORCED] <- the nudge at the nodes; done outside the Newton loop, which it would slow down."""
    for j in range(len(nodes)):
        work[_FORCED, j] = length * nudge_rate(nudge, start + nodes[j] * length)


@inlined
def linearise(
    nodes: Nodes,
    law: Law,
    epsilon: float,
    h: float,
    psi: float,
    integral: Array,
    impedance: Array,
    level: int,
    guess: Array,
    work: Array,
    system: Array,
    change: Array,
) -> None:
    """Newton system: rows 0..s-1 the state equation, rows s..2s-1 friction; columns psi then z."""
    s = len(nodes)
    for j in range(s):
        answer = respond(law, guess[UNKNOWN, j], guess[STATE, j])
        work[_V, j], work[_V_Z, j], work[_F, j], work[_F_Z, j] = answer[0], answer[1], answer[2], answer[3]
        work[_F_PSI, j], work[_G, j], work[_G_Z, j], work[_G_PSI, j] = (
            answer[4],
            h * answer[5] + work[_FORCED, j],
            h * answer[6],
            h * answer[7],
        )
    for j in range(s):
        change[j] = psi - guess[STATE, j]
        change[s + j] = work[_EXTERNAL, j] - work[_F, j]
        for m in range(s):
            change[j] += integral[j, m] * work[_G, m]
            change[s + j] -= epsilon * impedance[level, j, m] * work[_V, m]
            system[j, m] = -integral[j, m] * work[_G_PSI, m]
            system[j, s + m] = -integral[j, m] * work[_G_Z, m]
            system[s + j, m] = 0.0
            system[s + j, s + m] = epsilon * impedance[level, j, m] * work[_V_Z, m]
        system[j, j] += 1.0
        system[s + j, j] += work[_F_PSI, j]
        system[s + j, s + j] += work[_F_Z, j]


@inlined
def eliminate(nodes: Nodes, system: Array, change: Array) -> bool:
    """change <- system^-1 change by Gaussian elimination with pivoting; False if singular."""
    s = len(nodes)
    n = 2 * s
    for k in range(n):
        pivot = k
        for j in range(k + 1, n):
            if abs(system[j, k]) > abs(system[pivot, k]):
                pivot = j
        if not abs(system[pivot, k]) > 0.0:
            return False
        if pivot != k:
            for m in range(k, n):
                system[k, m], system[pivot, m] = system[pivot, m], system[k, m]
            change[k], change[pivot] = change[pivot], change[k]
        inverse = 1.0 / system[k, k]
        for j in range(k + 1, n):
            factor = system[j, k] * inverse
            if factor != 0.0:
                for m in range(k + 1, n):
                    system[j, m] -= factor * system[k, m]
                change[j] -= factor * change[k]
    for k in range(n - 1, -1, -1):
        for m in range(k + 1, n):
            change[k] -= system[k, m] * change[m]
        change[k] /= system[k, k]
    return True


@inlined
def correct(nodes: Nodes, epsilon: float, impedance: Array, level: int, guess: Array, work: Array, change: Array) -> float:
    """Apply the change; v is continued by v'' = v. Returns an estimate of what the linearisation neglects; inf if too large."""
    s = len(nodes)
    error = 0.0
    for j in range(s):
        by_psi, by_z = change[j], change[s + j]
        if not abs(by_z) + abs(by_psi) < _FAR:
            return math.inf
        by_z = min(_LARGEST_CHANGE, max(-_LARGEST_CHANGE, by_z))
        guess[STATE, j] += by_psi
        guess[UNKNOWN, j] += by_z
        square = by_z * by_z
        stiff = epsilon * abs(impedance[level, j, j]) * work[_V_Z, j]
        weight = 0.5 * (stiff / (work[_F_Z, j] + stiff) + abs(work[_G_Z, j]))
        error = max(error, weight * square + 0.5 * abs(work[_G_PSI, j]) * by_psi * by_psi + 1e-2 * square * square * abs(by_z))
        even = 1.0 + square * (0.5 + square / 24.0)
        odd = by_z * (1.0 + square * (1.0 / 6.0 + square / 120.0))
        work[_V, j] = work[_V, j] * even + work[_V_Z, j] * odd
    return error


@inlined
def advance_modes(nodes: Nodes, tables: Tables, level: int, modes: Array, length: float, integral: Array, work: Array) -> None:
    """Modes at the step's end from the nodal rates."""
    s = len(nodes)
    for n in range(modes.shape[0]):
        momentum, tau = 0.0, 0.0
        for j in range(s):
            tau = tables.free[level, n, 0, j] * modes[n, 0] + tables.free[level, n, 1, j] * modes[n, 1]
            for m in range(s):
                tau -= tables.forced[level, n, j, m] * (work[_V, m] - work[_DRIVE, m])
            slip = work[_V, j] - work[_DRIVE, j]
            momentum += integral[s - 1, j] * (tables.offset[n] * slip + tables.omega_squared[n] * tau)
        modes[n, 0] = tau
        modes[n, 1] -= length * momentum


@inlined
def grows_unseen(nodes: Nodes, epsilon: float, limits: Limits, level: int, work: Array) -> bool:
    """Whether a disturbance of the state at some node would grow by more than e^g within the step, g = `limits.growth`.

    With coefficients frozen at a node, the growth rates s are the zeros of (F_z + Z(s) v_z)(s - G_psi) + F_psi G_z. This is
    positive for large s; if it is negative at s = g/length, there is a real zero beyond.
    """
    g = limits.growth
    for j in range(len(nodes)):
        resistance = work[_F_Z, j] + epsilon * limits.impedance[level] * work[_V_Z, j]
        if resistance * (g - work[_G_PSI, j]) + work[_F_PSI, j] * work[_G_Z, j] < 0.0:
            return True
    return False


@inlined
def predict(
    nodes: Nodes, predict_rate: Array, predict_state: Array, ratio: int, left: float, pieces: Pieces, k: int, guess: Array
) -> None:
    """Nodal guess for the next step: the polynomials of piece k, extended."""
    s = len(nodes)
    for j in range(s):
        psi, z = predict_state[ratio, j, 0] * left, 0.0
        for m in range(s):
            psi += predict_state[ratio, j, m + 1] * pieces.psi[k, m]
            z += predict_rate[ratio, j, m] * pieces.z[k, m]
        guess[STATE, j] = psi
        guess[UNKNOWN, j] = z


@inlined
def hold(nodes: Nodes, now: Array, guess: Array) -> None:
    """Take the present values as the guess for a step to which no polynomial was extended."""
    for j in range(len(nodes)):
        guess[STATE, j] = now[PSI]
        guess[UNKNOWN, j] = now[UNKNOWN_END]


@njit
def march_ladder(
    nodes: Nodes,
    law: Law,
    epsilon: float,
    forcing: Forcing,
    drive: Constant | Ramps,
    tables: Tables,
    rule: Rule,
    memory: ReducedMemory,
    until: float,
    stop: float,
    limits: Limits,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March to `until`, or until the pieces are full; returns (steps, Newton iterations, verdict). Verdict 0: done; 1: no step is
    short enough. The last step may end beyond `until`, but not beyond `stop`."""
    s = len(nodes)
    nudge, stiffness = forcing.nudge, forcing.stiffness
    modes, guess, now, levels = memory.modes, memory.guess, memory.now, memory.level
    integral, tail, impedance = rule.integral, rule.tail, tables.impedance
    work, system, change = np.zeros((_WORK_ROWS, s)), np.empty((2 * s, 2 * s)), np.empty(2 * s)
    deepest = tables.length.size - 1
    iterations, k = 0, 0
    while k < pieces.time.size and now[TIME] < min(until, stop) - SAME:
        level = levels[0]
        while level < deepest and now[TIME] + tables.length[level] > stop + SAME:
            level += 1
        if level != levels[0]:
            levels[0] = level
            hold(nodes, now, guess)
        length = tables.length[level]
        h = length * forcing.transit
        psi, start = now[PSI], now[TIME]
        for j in range(s):
            work[_DRIVE, j] = velocity_at(drive, start + nodes[j] * length)
        external_stress(nodes, epsilon, tables, level, modes, now[SPRING], now[RATE], work)
        if nudge != 0.0:
            force(nodes, nudge, start, length, work)
        solved = False
        for _ in range(_MAX_NEWTON):
            iterations += 1
            linearise(nodes, law, epsilon, h, psi, integral, impedance, level, guess, work, system, change)
            if not eliminate(nodes, system, change):
                break
            error = correct(nodes, epsilon, impedance, level, guess, work, change)
            if error < limits.newton:
                solved = True
                break
            if not error < _FAR:
                break
        tail_z, tail_psi = 0.0, 0.0
        for j in range(s):
            tail_z += tail[j] * guess[UNKNOWN, j]
            tail_psi += tail[j] * guess[STATE, j]
        size = max(abs(tail_z), abs(tail_psi))
        if not (solved and size <= limits.resolution) or grows_unseen(nodes, epsilon, limits, level, work):
            if level == deepest:
                return k, iterations, 1
            levels[0] = level + 1
            hold(nodes, now, guess)
            continue
        pieces.time[k] = start
        pieces.length[k] = length
        slip = 0.0
        for j in range(s):
            pieces.z[k, j] = guess[UNKNOWN, j]
            pieces.psi[k, j] = guess[STATE, j]
            pieces.mu[k, j] = respond(law, guess[UNKNOWN, j], guess[STATE, j])[2]
            slip = 0.0
            for m in range(s):
                slip += length * integral[j, m] * (work[_DRIVE, m] - work[_V, m])
            pieces.y[k, j] = now[ELASTIC] + stiffness * slip
        advance_modes(nodes, tables, level, modes, length, integral, work)
        now[SPRING] += tables.spring * slip
        now[ELASTIC] += stiffness * slip
        now[PSI], now[RATE], now[UNKNOWN_END] = guess[STATE, s - 1], work[_V, s - 1], guess[UNKNOWN, s - 1]
        now[TIME] = start + length
        longer = level > 0 and size < 0.5 ** (s + 1) * limits.resolution
        levels[0] = level - 1 if longer else level
        predict(nodes, rule.predict, rule.predict_state, 1 if longer else 0, psi, pieces, k, guess)
        k += 1
    return k, iterations, 0
