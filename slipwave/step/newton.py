"""Newton's method for one collocation step of friction against any linear slab pair: nodal psi and z that satisfy

    F(z_j, psi_j) + sum_l K_jl v(z_l) = S_j,     psi' = r G(z, psi) + nudge(t),

with the incoming stress S at the step's nodes and the slabs' impedance K over the step (`slipwave.step.impedance`). z is
eliminated node by node, which leaves a small linear system (`slipwave.step.linear_system`).

`nodes` is a tuple, so that the compiler knows their number and unrolls the small loops (a factor of 1.7 measured).
"""

import math

from slipwave.compiled import inlined, njit
from slipwave.friction import Law, respond
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.impedance import Impedance, influence, own
from slipwave.step.linear_system import solve_changes
from slipwave.step.rows import (
    BY_Z,
    CHANGE,
    FORCED,
    INCREMENT,
    INVERSE,
    MISMATCH,
    RATE,
    RATE_SLOPE,
    RATIO,
    SLOPE,
    STATE,
    UNKNOWN,
    WEIGHT,
    WEIGHT_STATE,
)

_MAX_NEWTON = 25
_LARGEST_CHANGE = 2.0


@inlined
def linearise(
    nodes: Nodes, law: Law, impedance: Impedance, h: float, incoming: Array, i: int, guess: Array, work: Array
) -> float:
    """Per node: linearise friction and state at the guess and eliminate z; returns the largest coupling |slope|."""
    s = len(nodes)
    coupling = 0.0
    for j in range(s):
        v, v_z, friction, friction_z, friction_psi, g, g_z, g_psi = respond(law, guess[UNKNOWN, j], guess[STATE, j])
        inverse = 1.0 / (friction_z + own(impedance, j) * v_z)
        mismatch = (friction + own(impedance, j) * v - incoming[i, j]) * inverse
        ratio = friction_psi * inverse
        slope = h * (g_psi - g_z * ratio)
        work[RATE, j] = v
        work[RATE_SLOPE, j] = v_z
        work[MISMATCH, j] = mismatch
        work[RATIO, j] = ratio
        work[INCREMENT, j] = h * (g - g_z * mismatch)
        work[SLOPE, j] = slope
        work[INVERSE, j] = inverse
        work[BY_Z, j] = h * g_z
        work[WEIGHT, j] = 0.5 * (own(impedance, j) * v_z * inverse + abs(h * g_z))
        work[WEIGHT_STATE, j] = 0.5 * abs(h * g_psi)
        coupling = max(coupling, abs(slope))
    return coupling


@inlined
def correct(nodes: Nodes, guess: Array, work: Array) -> float:
    """Apply the change to psi, z and v in place; returns an estimate of what the linear system neglects.

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
        if not neglected <= error:  # NaN stays
            error = neglected
    return error


@inlined
def solve_step(
    nodes: Nodes,
    law: Law,
    impedance: Impedance,
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
    """Newton for the step's nodal psi and z, which replace those in `guess`; nodal v in work[RATE]. Returns iterations, 0 =
    failed."""
    s = len(nodes)
    for iteration in range(1, _MAX_NEWTON + 1):
        coupling = linearise(nodes, law, impedance, h, incoming, i, guess, work)
        shared = influence(impedance, nodes, work)
        if not math.isfinite(coupling + shared):
            return 0
        for j in range(s):
            work[CHANGE, j] = psi - guess[STATE, j] + work[FORCED, j]
        for k in range(s):
            factor = work[INCREMENT, k]
            for j in range(s):
                work[CHANGE, j] += integral[k, j] * factor
        left = solve_changes(impedance, nodes, integral, coupling + shared, work, system)
        error = left + correct(nodes, guess, work)
        if error < newton_tolerance:
            return iteration
    return 0


@njit
def solve(
    nodes: Nodes,
    law: Law,
    impedance: Impedance,
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
    """`solve_step` as a function of its own: inlined into a long march it would double the time to compile."""
    return solve_step(nodes, law, impedance, h, psi, incoming, i, integral, newton_tolerance, guess, work, system)
