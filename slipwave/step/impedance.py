"""The impedance K of a slab pair over one collocation step: the stress at node j is  mu_j = S_j - sum_l K_jl v_l.

Waves that leave the interface and do not return within the step give a diagonal K with equal entries. States that respond within
the step give a full matrix; each step then costs the elimination below unless the coupling of the nodes is weak. Compiled code is
specialised on the class, so a diagonal K pays for none of it.
"""

from typing import NamedTuple, TypeAlias

import numpy as np

from slipwave.compiled import inlined, njit
from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.rows import BY_Z, CHANGE, INCREMENT, INVERSE, MISMATCH, RATE, RATE_SLOPE, RATIO, SLOPE

TOGETHER = 3e-3
"""Influence of other nodes from which all are solved for together. Below, Newton's method takes it into account in the residual
only and converges linearly, at this rate."""


class Diagonal(NamedTuple):
    """K = value times the identity."""

    value: float


class Full(NamedTuple):
    """K = matrix (s, s); `state` (s, 2 s + 1) and `rate` (s, s + 1) are scratch."""

    matrix: Array
    state: Array
    rate: Array


Impedance: TypeAlias = Diagonal | Full


def full_impedance(stages: int) -> Full:
    """A K of `stages` nodes, zero, with its scratch."""
    return Full(np.zeros((stages, stages)), np.zeros((stages, 2 * stages + 1)), np.zeros((stages, stages + 1)))


@by_class(inline=True)
def own(impedance: Impedance, j: int) -> float:
    """K_jj."""
    raise NotImplementedError(type(impedance))


@by_class(inline=True)
def others(impedance: Impedance, nodes: Nodes, j: int, work: Array) -> float:
    """Sum over l != j of K_jl v_l."""
    raise NotImplementedError(type(impedance))


@by_class(inline=True)
def influence(impedance: Impedance, nodes: Nodes, work: Array) -> float:
    """Add the stress by other nodes' rates to the mismatch of each node. Returns the largest influence of the others on a node's
    z: sum over l != j of |K_jl v_z,l| over F_z,j + K_jj v_z,j."""
    raise NotImplementedError(type(impedance))


@by_class(inline=True)
def couple(impedance: Impedance, nodes: Nodes, integral: Array, weak: bool, work: Array) -> None:
    """work[CHANGE] <- change of psi, and the mismatch as if every other node's z had changed, for all nodes together."""
    raise NotImplementedError(type(impedance))


@own.register(Diagonal)
def _own_of_diagonal(impedance, j):  # type: ignore[no-untyped-def]
    return impedance.value


@others.register(Diagonal)
def _others_of_diagonal(impedance, nodes, j, work):  # type: ignore[no-untyped-def]
    return 0.0


@influence.register(Diagonal)
def _influence_in_diagonal(impedance, nodes, work):  # type: ignore[no-untyped-def]
    return 0.0


@couple.register(Diagonal)
def _couple_diagonal(impedance, nodes, integral, weak, work):  # type: ignore[no-untyped-def]
    return None


@own.register(Full)
def _own_of_full(impedance, j):  # type: ignore[no-untyped-def]
    return impedance.matrix[j, j]


@others.register(Full)
def _others_of_full(impedance, nodes, j, work):  # type: ignore[no-untyped-def]
    matrix, total = impedance.matrix, 0.0
    for m in range(len(nodes)):
        if m != j:
            total += matrix[j, m] * work[RATE, m]
    return total


@influence.register(Full)
def _influence_in_full(impedance, nodes, work):  # type: ignore[no-untyped-def]
    matrix, largest = impedance.matrix, 0.0
    for j in range(matrix.shape[0]):
        stress, size, inverse = 0.0, 0.0, work[INVERSE, j]
        for m in range(len(nodes)):
            if m != j:
                stress += matrix[j, m] * work[RATE, m]
                size += abs(matrix[j, m]) * work[RATE_SLOPE, m]
        work[MISMATCH, j] += stress * inverse
        work[INCREMENT, j] -= work[BY_Z, j] * stress * inverse
        largest = max(largest, size * inverse)
    return largest


@couple.register(Full)
def _couple_full(impedance, nodes, integral, weak, work):  # type: ignore[no-untyped-def]
    _solve_together(nodes, impedance.matrix, impedance.state, impedance.rate, integral, weak, work)


@njit
def _solve_together(nodes: Nodes, matrix: Array, state: Array, rate: Array, integral: Array, weak: bool, work: Array) -> None:
    """With B = h G_z, P = 1 - A h G_psi and c the right-hand side of psi, linearised friction and state are

        (1 + kappa) dz + ratio dpsi = -mismatch,     dpsi = P^-1 (c + A B dz),

    kappa_jl = K_jl v_z,l / (F_z,j + K_jj v_z,j) for l != j. dpsi is eliminated; if the state couples weakly, P = 1."""
    s, rows = len(nodes), matrix.shape[0]  # equal; loops over rows are not to be unrolled
    for j in range(rows):
        total = work[CHANGE, j]
        for m in range(s):
            by_z = integral[m, j] * work[BY_Z, m]
            state[j, m] = -integral[m, j] * work[SLOPE, m] - by_z * work[RATIO, m]
            state[j, s + 1 + m] = by_z
            total += by_z * work[MISMATCH, m]
        state[j, j] += 1.0
        state[j, s] = total
    if not weak:
        eliminate(state, 2 * s + 1)
    for j in range(rows):
        ratio, inverse = work[RATIO, j], work[INVERSE, j]
        for m in range(s):
            rate[j, m] = ratio * state[j, s + 1 + m] + matrix[j, m] * work[RATE_SLOPE, m] * inverse
        rate[j, j] += 1.0 - matrix[j, j] * work[RATE_SLOPE, j] * inverse
        rate[j, s] = -work[MISMATCH, j] - ratio * state[j, s]
    eliminate(rate, s + 1)
    for j in range(rows):
        change = state[j, s]
        for m in range(s):
            change += state[j, s + 1 + m] * rate[m, s]
        work[CHANGE, j] = change
        work[MISMATCH, j] = -rate[j, s] - work[RATIO, j] * change


@inlined
def eliminate(system: Array, width: int) -> None:
    """Replace the columns after the first n by M^-1 times them; M (n, n) are the first. Gauss-Jordan with pivoting; the innermost
    loops have the constant length `width` of a row, which the compiler unrolls."""
    n = system.shape[0]
    for k in range(n):
        pivot = k
        for j in range(k + 1, n):
            if abs(system[j, k]) > abs(system[pivot, k]):
                pivot = j
        if pivot != k:
            for m in range(width):
                system[k, m], system[pivot, m] = system[pivot, m], system[k, m]
        inverse = 1.0 / system[k, k]
        for m in range(width):
            system[k, m] *= inverse
        for j in range(n):
            if j != k:
                factor = system[j, k]
                for m in range(width):
                    system[j, m] -= factor * system[k, m]
