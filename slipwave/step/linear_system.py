"""The linear system of one Newton iteration of a collocation step: changes of psi and z at all nodes.

Where the impedance couples no nodes, z is eliminated node by node and a system for psi is left: a Neumann series while the state
couples weakly, as during stick, and elimination otherwise. Where it couples them, sweeps over the nodes take the place of the
series, and elimination of all of them is the last resort.
"""

from slipwave.compiled import inlined, njit
from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.impedance import Diagonal, Full, Impedance
from slipwave.step.rows import BY_Z, CHANGE, FRESH, INVERSE, MISMATCH, PREVIOUS, RATE_SLOPE, RATIO, SLOPE, STRESS

_WEAK_COUPLING = 0.04

SWEPT = 0.5
"""Influence of all nodes on a node up to which they are solved for by sweeps."""


@by_class(inline=True)
def solve_changes(impedance: Impedance, nodes: Nodes, integral: Array, total: float, work: Array, system: Array) -> float:
    """work[CHANGE], the right-hand side of psi, <- change of psi, and the mismatch as if every other node's z had changed.
    `total`: largest influence of all nodes on the z and psi of one. Returns the error that is left; `system` is scratch."""
    raise NotImplementedError(type(impedance))


@solve_changes.register(Diagonal)
def _solve_alone(impedance, nodes, integral, total, work, system):  # type: ignore[no-untyped-def]
    if total < _WEAK_COUPLING:
        neumann(nodes, integral, work, 2 if total < 0.01 else 3)
    else:
        eliminate_state(nodes, integral, work, system)
    return 0.0


@solve_changes.register(Full)
def _solve_coupled(impedance, nodes, integral, total, work, system):  # type: ignore[no-untyped-def]
    if total < SWEPT:
        return _sweep(nodes, impedance.matrix, integral, total, work)
    _solve_together(nodes, impedance.matrix, impedance.state, impedance.rate, integral, work)
    return 0.0


@inlined
def neumann(nodes: Nodes, integral: Array, work: Array, sweeps: int) -> None:
    """change <- (1 + K + ... + K^sweeps) change; accurate enough for a Newton iteration if K = A diag(slope) is small."""
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
def eliminate_state(nodes: Nodes, integral: Array, work: Array, system: Array) -> None:
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


@njit
def _sweep(nodes: Nodes, matrix: Array, integral: Array, total: float, work: Array) -> float:
    """The equations of `_solve_together`, solved in turn for dz and for dpsi:

        dz = -mismatch - kappa dz - ratio dpsi,     dpsi = c + A (slope dpsi - B kappa dz).

    An early node influences a late one as in an integral, so that sweeps converge faster than powers of `total`."""
    s, moved = len(nodes), 0.0
    for j in range(s):
        work[STRESS, j] = 0.0
        work[PREVIOUS, j] = work[CHANGE, j]
    for _ in range(2 if total < 0.05 else 4 if total < 0.2 else 6):
        moved = 0.0
        for j in range(s):
            change = -work[MISMATCH, j] - work[STRESS, j] - work[RATIO, j] * work[PREVIOUS, j]
            work[FRESH, j] = work[RATE_SLOPE, j] * change
        for j in range(s):
            stress = 0.0
            for m in range(s):
                if m != j:
                    stress += matrix[j, m] * work[FRESH, m]
            stress *= work[INVERSE, j]
            moved = max(moved, abs(stress - work[STRESS, j]))
            work[STRESS, j] = stress
        for j in range(s):
            work[FRESH, j] = work[SLOPE, j] * work[PREVIOUS, j] - work[BY_Z, j] * work[STRESS, j]
        for j in range(s):
            change = work[CHANGE, j]
            for m in range(s):
                change += integral[m, j] * work[FRESH, m]
            moved = max(moved, abs(change - work[PREVIOUS, j]))
            work[PREVIOUS, j] = change
    for j in range(s):
        work[MISMATCH, j] += work[STRESS, j]
        work[CHANGE, j] = work[PREVIOUS, j]
    return moved * total


@njit
def _solve_together(nodes: Nodes, matrix: Array, state: Array, rate: Array, integral: Array, work: Array) -> None:
    """With B = h G_z, P = 1 - A h G_psi and c the right-hand side of psi, linearised friction and state are

        (1 + kappa) dz + ratio dpsi = -mismatch,     dpsi = P^-1 (c + A B dz),

    kappa_jl = K_jl v_z,l / (F_z,j + K_jj v_z,j) for l != j. dpsi is eliminated."""
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
