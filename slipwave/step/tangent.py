"""The derivative of one collocation step of friction: of slip rate and state at its nodes by the incoming stress, the state at
the start and the state's rate.

A solved step (`slipwave.step.newton`) satisfies, at its nodes j,

    F(z_j, psi_j) + sum_l K_jl v(z_l) = S_j,     psi_j = psi_0 + sum_l A_jl g_l,     g_l = h G(z_l, psi_l).

Node by node, dz = (dS' - F_psi dpsi)/(F_z + K_jj v_z) with the stress dS' = dS - sum over l != j of K_jl dv_l, as in Newton's
method. So v and h G answer to S' and psi of their own node, and with dg = p dS' + q dpsi + dg_given

    (1 - A diag(q)) dpsi = 1 dpsi_0 + A diag(p) dS' + A dg_given.

What other nodes contribute to S' is then fed back. A parameter p of friction or of the clock enters as dS = -F_p dp and dg = (h
G)_p dp, so these answers contain its derivative too. The caller adds the memory of the slab model, in which the step is linear.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import allocating, inlined, njit
from slipwave.compiled.dispatch import by_class
from slipwave.friction import Law, respond
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.impedance import Diagonal, Full, Impedance, own
from slipwave.step.newton import eliminate
from slipwave.step.port import Port


class Motion(NamedTuple):
    """Nodal `z` and `psi` (steps, s) of a motion, and whether psi is held, `frozen`, when it is changed."""

    z: Array
    psi: Array
    frozen: bool


class Answer(NamedTuple):
    """`matrix` (2 s, 2 s + 1) of `step_answer`. Scratch (s,): derivatives of v by the stress S' and by psi, and of h G by S' and
    psi; `state` (s, 2 s + 1)."""

    matrix: Array
    rate_by_stress: Array
    rate_by_psi: Array
    by_stress: Array
    by_psi: Array
    state: Array


@allocating
def blank_answer(nodes: Nodes) -> Answer:
    """Room for the answer of a step."""
    s, row = len(nodes), np.empty((4, len(nodes)))
    return Answer(np.empty((2 * s, 2 * s + 1)), row[0], row[1], row[2], row[3], np.empty((s, 2 * s + 1)))


@njit
def step_answer(
    nodes: Nodes, law: Law, impedance: Impedance, h: float, integral: Array, motion: Motion, k: int, answer: Answer
) -> None:
    """answer.matrix <- d(v at the nodes, psi at the nodes)/d(S at the nodes, psi at the start, h G at the nodes) of step `k` of
    the `motion`, with impedance K and the length `h` (friction clock). `integral` is A transposed.

    If psi is frozen, v answers to S alone, and psi to nothing.
    """
    s, rows, state, matrix = len(nodes), motion.z.shape[1], answer.state, answer.matrix  # s, rows: not to be unrolled
    free = 0.0 if motion.frozen else 1.0
    for m in range(rows):
        _, v_z, _, friction_z, friction_psi, _, g_z, g_psi = respond(law, motion.z[k, m], motion.psi[k, m])
        inverse = 1.0 / (friction_z + own(impedance, m) * v_z)
        answer.rate_by_stress[m], answer.rate_by_psi[m] = v_z * inverse, -v_z * inverse * friction_psi
        answer.by_stress[m], answer.by_psi[m] = h * g_z * inverse, h * (g_psi - g_z * inverse * friction_psi)
    for j in range(rows):
        for m in range(s):
            state[j, m] = -integral[m, j] * answer.by_psi[m]
            state[j, s + 1 + m] = integral[m, j]
        state[j, j] += 1.0
        state[j, s] = 1.0
    eliminate(state, 2 * s + 1)
    for j in range(rows):
        for m in range(s):
            matrix[s + j, m] = free * state[j, s + 1 + m] * answer.by_stress[m]
        for m in range(s, 2 * s + 1):
            matrix[s + j, m] = free * state[j, m]
        for m in range(2 * s + 1):
            matrix[j, m] = answer.rate_by_psi[j] * matrix[s + j, m]
        matrix[j, j] += answer.rate_by_stress[j]
    _feed_back(impedance, nodes, matrix)


@by_class(inline=True)
def _feed_back(impedance: Any, nodes: Nodes, answer: Array) -> None:
    """Add to `answer` what other nodes' rates contribute to the stress of a node."""
    _solve_together(nodes, impedance.matrix, answer)


@_feed_back.register(Diagonal)
def _feed_back_nothing(impedance, nodes, answer):  # type: ignore[no-untyped-def]
    return None


@allocating
def _solve_together(nodes: Nodes, impedance: Array, answer: Array) -> None:
    """With K' the off-diagonal part of K = `impedance` (s, s), and Y and Y_psi the responses of v and psi to stress,

    (1 + Y K') dv = dv_alone,     dpsi = dpsi_alone - Y_psi K' dv."""
    s, rows = len(nodes), impedance.shape[0]
    rate, others = np.empty((s, 3 * s + 1)), np.empty(s)
    for j in range(rows):
        for m in range(s):
            rate[j, m] = _by_others(impedance, answer, j, m)
        for m in range(2 * s + 1):
            rate[j, s + m] = answer[j, m]
        rate[j, j] += 1.0
    eliminate(rate, 3 * s + 1)
    for j in range(rows):
        for m in range(s):
            others[m] = _by_others(impedance, answer, s + j, m)
        for m in range(2 * s + 1):
            answer[j, m] = rate[j, s + m]
            for k in range(s):
                answer[s + j, m] -= others[k] * rate[k, s + m]


@inlined
def _by_others(impedance: Array, answer: Array, row: int, m: int) -> float:
    """What `row` of the answer loses to stress by node m at all other nodes."""
    total = 0.0
    for k in range(impedance.shape[0]):
        if k != m:
            total += answer[row, k] * impedance[k, m]
    return total


@allocating
def carry(
    nodes: Nodes,
    law: Law,
    port: Port,
    transit: float,
    integral: Array,
    plan: NDArray[np.int64],
    motion: Motion,
    values: Array,
    state: Array,
) -> None:
    """Carry m disturbances, of the port's `values` (m, n) and of psi, `state` (m,), along the `motion` in steps of the levels
    `plan`. One `transit` on the friction clock; `integral` is A transposed."""
    s, count, n, scratch = len(nodes), state.size, values.shape[1], blank_answer(nodes)
    answer = scratch.matrix
    stress, rate = np.empty((count, s)), np.empty((count, s))
    kept, gained = np.empty_like(values), np.empty_like(values)
    for k in range(plan.size):
        level = plan[k]
        impedance = Full(port.impedance[level])
        step_answer(nodes, law, impedance, port.length[level] * transit, integral, motion, k, scratch)
        np.dot(values, port.free[level], stress)
        for c in range(count):
            for j in range(s):
                rate[c, j] = answer[j, s] * state[c]
                for m in range(s):
                    rate[c, j] += answer[j, m] * stress[c, m]
            end = answer[2 * s - 1, s] * state[c]
            for m in range(s):
                end += answer[2 * s - 1, m] * stress[c, m]
            state[c] = end
        np.dot(values, port.change[level, :n], kept)
        np.dot(rate, port.change[level, n : n + s], gained)
        for c in range(count):
            for i in range(n):
                values[c, i] += kept[c, i] + gained[c, i]


@allocating
def carry_back(
    nodes: Nodes,
    law: Law,
    port: Port,
    transit: float,
    integral: Array,
    plan: NDArray[np.int64],
    motion: Motion,
    values: Array,
    pulses: Array,
) -> None:
    """The adjoint of `carry`: pulses (2, k, s) <- derivatives of a functional of the state at the motion's end, of the port's
    values, `values` (n,), and then of psi, by the incoming stress and by the drive at the nodes of all steps."""
    s, n, scratch = len(nodes), values.size - 1, blank_answer(nodes)
    answer = scratch.matrix
    memory, psi = values[:n], values[n]
    for k in range(plan.size - 1, -1, -1):
        level = plan[k]
        change = port.change[level]
        step_answer(nodes, law, Full(port.impedance[level]), port.length[level] * transit, integral, motion, k, scratch)
        by_rate = np.dot(change[n : n + s], memory)
        by_answer = np.dot(by_rate, answer[:s]) + psi * answer[2 * s - 1]
        pulses[0, k], psi = by_answer[:s], by_answer[s]
        pulses[1, k] = np.dot(port.driven[level], by_answer[:s]) + np.dot(change[n + s :], memory)
        memory += np.dot(change[:n], memory) + np.dot(port.free[level], by_answer[:s])
