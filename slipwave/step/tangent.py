"""The derivative of one collocation step of friction: how slip rate and state at its nodes answer to changes of the incoming
stress, of the state at the start and of the state's rate.

A solved step (`slipwave.step.newton`) satisfies, at its nodes j,

    F(z_j, psi_j) + sum_l K_jl v(z_l) = S_j,     psi_j = psi_0 + sum_l A_jl g_l,     g_l = h G(z_l, psi_l).

Node by node, dz = (dS' - F_psi dpsi)/(F_z + K_jj v_z) with the stress dS' = dS - sum over l != j of K_jl dv_l, as in Newton's
method. So v and h G answer to S' and psi of their own node, and with dg = p dS' + q dpsi + dg_given

    (1 - A diag(q)) dpsi = 1 dpsi_0 + A diag(p) dS' + A dg_given.

What other nodes contribute to S' is then fed back. A parameter p of friction or of the clock enters as dS = -F_p dp and
dg = (h G)_p dp, so these answers contain its derivative too. Whoever made the step adds what a slab model remembers: the step is
linear in that.
"""

import numpy as np

from slipwave.compiled import allocating, inlined, njit
from slipwave.compiled.dispatch import by_class
from slipwave.friction import Law, respond
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.impedance import Diagonal, Full, Impedance, own
from slipwave.step.linear_system import eliminate

_RATE_BY_STRESS, _RATE_BY_PSI, _BY_STRESS, _BY_PSI = range(4)
SLOPES = 4
"""Rows of the scratch array `slopes` of `step_answer`."""


@njit
def step_answer(
    nodes: Nodes,
    law: Law,
    impedance: Impedance,
    h: float,
    integral: Array,
    z: Array,
    psi: Array,
    frozen: bool,
    slopes: Array,
    state: Array,
    answer: Array,
) -> None:
    """answer (2 s, 2 s + 1) <- d(v at the nodes, psi at the nodes)/d(S at the nodes, psi at the start, h G at the nodes) of the
    step with nodal `z` and `psi`, impedance K, and `h`, its length on the friction clock. `integral` is A transposed.

    `frozen`: psi is held; then v answers to S alone, and psi to nothing. `slopes` (SLOPES, s) and `state` (s, 2 s + 1) are
    scratch.
    """
    s, rows = len(nodes), z.size  # equal; loops over rows are not to be unrolled
    free = 0.0 if frozen else 1.0
    for m in range(rows):
        _, v_z, _, friction_z, friction_psi, _, g_z, g_psi = respond(law, z[m], psi[m])
        inverse = 1.0 / (friction_z + own(impedance, m) * v_z)
        slopes[_RATE_BY_STRESS, m], slopes[_RATE_BY_PSI, m] = v_z * inverse, -v_z * inverse * friction_psi
        slopes[_BY_STRESS, m], slopes[_BY_PSI, m] = h * g_z * inverse, h * (g_psi - g_z * inverse * friction_psi)
    for j in range(rows):
        for m in range(s):
            state[j, m] = -integral[m, j] * slopes[_BY_PSI, m]
            state[j, s + 1 + m] = integral[m, j]
        state[j, j] += 1.0
        state[j, s] = 1.0
    eliminate(state, 2 * s + 1)
    for j in range(rows):
        for m in range(s):
            answer[s + j, m] = free * state[j, s + 1 + m] * slopes[_BY_STRESS, m]
        for m in range(s, 2 * s + 1):
            answer[s + j, m] = free * state[j, m]
        for m in range(2 * s + 1):
            answer[j, m] = slopes[_RATE_BY_PSI, j] * answer[s + j, m]
        answer[j, j] += slopes[_RATE_BY_STRESS, j]
    feed_back(impedance, nodes, answer)


@by_class(inline=True)
def feed_back(impedance: Impedance, nodes: Nodes, answer: Array) -> None:
    """Add to `answer` what other nodes' rates contribute to the stress of a node."""
    raise NotImplementedError(type(impedance))


@feed_back.register(Diagonal)
def _feed_back_nothing(impedance, nodes, answer):  # type: ignore[no-untyped-def]
    return None


@feed_back.register(Full)
def _feed_back_all(impedance, nodes, answer):  # type: ignore[no-untyped-def]
    _solve_together(nodes, impedance.matrix, answer)


@allocating
def _solve_together(nodes: Nodes, impedance: Array, answer: Array) -> None:
    """With K' the entries of K = `impedance` (s, s) beside its diagonal, and Y and Y_psi the answers of v and psi to stress,

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
