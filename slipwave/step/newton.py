"""Newton's method for one collocation step of friction against any linear slab pair: nodal psi and z that satisfy

    F(z_j, psi_j) + sum_l K_jl v(z_l) = S_j,     psi' = r G(z, psi) + nudge(t),

with the incoming stress S at the step's nodes and the slabs' impedance K over the step (`slipwave.step.impedance`). z is
eliminated node by node. The small linear system that is left is solved by sweeps over the nodes where these couple weakly, as
during stick, and by elimination otherwise.

Where the slip rate changes its sign, |v|, and with it the rate of the state, has a kink, which no polynomial through the nodes
integrates. So the integral of the state's rate is computed in parts that end at the zeros of v, along the polynomials of the
solved step, and the step is solved again with the difference. The stress has no such kink: at v = 0 it does not depend on the
state.

`nodes` is a tuple, so that the compiler knows their number and unrolls the small loops (a factor of 1.7 measured).
"""

from typing import Any

import numpy as np

from slipwave.compiled import inlined, njit
from slipwave.compiled.dispatch import by_class
from slipwave.friction import Law, OfStep, law_of_step, respond, to_own, to_step, with_bend
from slipwave.friction.interface import solve_interface
from slipwave.observe.extrema import evaluate, find_root
from slipwave.observe.pieces import Array, Pieces
from slipwave.step.collocation import Nodes, Rule, rule_of
from slipwave.step.impedance import Diagonal, Impedance, influence, others, own
from slipwave.step.nodal import Interface, Nodal, constant_guess, nodal_of

_MAX_NEWTON = 25
_RESOLVED = 1e-3  # of the tolerance: what sweeps need not resolve
_LARGEST_CHANGE = 2.0
_LOST = 1e4  # error from which a shorter step, or another guess, is cheaper than more iterations; one of 300 was seen to converge
_SWEPT, _FINE = 3, 1e-12  # iterations that may sweep over strongly coupled nodes; tolerance below which none does
_ROUNDING = 1e-14  # of a stress, and of an iteration's error
_MOST_CORRECTIONS = 10
_GAUSS = (
    (0.06943184420297371, 0.1739274225687269),
    (0.33000947820757187, 0.3260725774312731),
    (0.6699905217924281, 0.3260725774312731),
    (0.9305681557970262, 0.1739274225687269),
)  # points and weights on the unit interval


@njit
def _iterate(nodes: Nodes, law: Law, impedance: Impedance, h: float, integral: Array, tolerance: float, nodal: Nodal) -> int:
    """Newton for psi, z and v at the nodes of a step of length `h` (friction clock), from those in `nodal`. `integral` is A
    transposed. Returns iterations, 0 = failed. Not inlined: that would double the compile time of a march."""
    s = len(nodes)
    for iteration in range(1, _MAX_NEWTON + 1):
        coupling = _linearise(nodes, law, impedance, h, nodal)
        shared = influence(impedance, nodes, nodal)
        total = coupling + shared
        for j in range(s):
            nodal.change[j] = nodal.left[j] - nodal.psi[j]
        for k in range(s):
            for j in range(s):
                nodal.change[j] += integral[k, j] * nodal.gain[k]
        sweeps, left = _sweeps_for(impedance, total, iteration > _SWEPT or tolerance < _FINE), 0.0
        if sweeps:
            enough = _RESOLVED * tolerance / total if shared > 0.0 else 0.0
            moved = _relax(nodes, impedance, integral, sweeps, enough, nodal)
            left = total * moved if shared > 0.0 else 0.0
        else:
            _eliminate_nodes(impedance, nodes, integral, nodal)
        error = left + _correct(nodes, law, impedance, nodal)
        if error < tolerance:
            return iteration
        if not error < _LOST:
            return 0
    return 0


@by_class()
def solve(law: Law, nodes: Nodes, impedance: Impedance, h: float, rule: Rule, tolerance: float, nodal: Nodal) -> int:
    """Newton for psi, z and v at the nodes of a step of length `h` (friction clock), from those in `nodal`. Returns iterations,
    0 = failed."""
    return _iterate(nodes, law, impedance, h, rule.integral, tolerance, nodal)


@solve.register(OfStep)
def _solve_through_rest(law, nodes, impedance, h, rule, tolerance, nodal):  # type: ignore[no-untyped-def]
    used = _iterate(nodes, law, impedance, h, rule.integral, tolerance, nodal)
    if used == 0:  # after a jump of the stress: psi as before it, and friction at each node for itself, from rest
        for j in range(len(nodes)):
            nodal.psi[j] = nodal.left[j]
            nodal.z[j], _ = solve_interface(law, own(impedance, j), nodal.incoming[j], nodal.psi[j], 0.0)
        used = _iterate(nodes, law, impedance, h, rule.integral, tolerance, nodal)
    if used == 0 or h == 0.0 or not _reverses(nodes, rule, nodal):
        return used
    for j in range(len(nodes)):
        nodal.missed[j] = 0.0
    for _ in range(_MOST_CORRECTIONS):
        if _add_missed(nodes, law, h, rule, nodal) <= tolerance:
            return used
        more = _iterate(nodes, law, impedance, h, rule.integral, tolerance, nodal)
        if more == 0:
            return 0
        used += more
    return 0


@njit
def _reverses(nodes: Nodes, rule: Rule, nodal: Nodal) -> bool:
    """Whether v changes its sign within the step."""
    before = evaluate(rule.basis, nodal.z, 0.0)
    for j in range(len(nodes)):
        if before * nodal.z[j] < 0.0:
            return True
        before = nodal.z[j]
    return False


@njit
def _add_missed(nodes: Nodes, law: Law, h: float, rule: Rule, nodal: Nodal) -> float:
    """nodal.missed <- what the integral of the state's rate up to each node misses by the kinks at the zeros of v; nodal.left
    contains it. Returns its largest change."""
    s, gained, largest = len(nodes), 0.0, 0.0
    left, before = 0.0, evaluate(rule.basis, nodal.z, 0.0)
    for k in range(s):
        nodal.gain[k] = h * respond(law, nodal.z[k], nodal.psi[k])[5]
    for j in range(s):
        right, z = nodes[j], nodal.z[j]
        if before * z < 0.0:
            zero = find_root(rule.basis, nodal.z, 0.0, left, right)
            gained += _gained(law, rule, nodal, left, zero)
            left = zero
        gained += _gained(law, rule, nodal, left, right)
        left, before = right, z
        missed = h * gained
        for k in range(s):
            missed -= rule.integral[k, j] * nodal.gain[k]
        largest = max(largest, abs(missed - nodal.missed[j]))
        nodal.left[j] += missed - nodal.missed[j]
        nodal.missed[j] = missed
    return largest


@njit
def _gained(law: Law, rule: Rule, nodal: Nodal, left: float, right: float) -> float:
    """Integral of the state's rate from `left` to `right` (of the step)."""
    total = 0.0
    for point, weight in _GAUSS:
        at = left + point * (right - left)
        z, psi = evaluate(rule.basis, nodal.z, at), evaluate(rule.basis, nodal.psi, at)
        total += weight * respond(law, z, psi)[5]
    return total * (right - left)


@inlined
def _linearise(nodes: Nodes, law: Law, impedance: Impedance, h: float, nodal: Nodal) -> float:
    """Per node: linearise friction and state at the guess and eliminate z; nodal.gain <- change of psi by its rate. Returns the
    largest coupling |slope|."""
    coupling = 0.0
    for j in range(len(nodes)):
        v, v_z, friction, friction_z, friction_psi, g, g_z, g_psi = respond(law, nodal.z[j], nodal.psi[j])
        inverse = 1.0 / (friction_z + own(impedance, j) * v_z)
        mismatch = (friction + own(impedance, j) * v - nodal.incoming[j]) * inverse
        ratio = friction_psi * inverse
        slope = h * (g_psi - g_z * ratio)
        nodal.v[j] = v
        nodal.v_z[j] = v_z
        nodal.mismatch[j] = mismatch
        nodal.ratio[j] = ratio
        nodal.gain[j] = h * (g - g_z * mismatch)
        nodal.slope[j] = slope
        nodal.inverse[j] = inverse
        nodal.by_z[j] = h * g_z
        coupling = max(coupling, abs(slope))
    return coupling


@inlined
def _correct(nodes: Nodes, law: Law, impedance: Impedance, nodal: Nodal) -> float:
    """Apply the change to psi, z and v in place; returns an estimate of what the linear system neglects.

    v is continued by v'' = v, exact for v = e^z and v = 2 c sinh z, so no exponential is evaluated again.
    """
    error = 0.0
    for j in range(len(nodes)):
        by_psi = nodal.change[j]
        by_z = -nodal.mismatch[j] - nodal.ratio[j] * by_psi
        by_z = min(_LARGEST_CHANGE, max(-_LARGEST_CHANGE, by_z))
        nodal.psi[j] += by_psi
        nodal.z[j] += by_z
        square = by_z * by_z
        even = 1.0 + square * (0.5 + square / 24.0)
        odd = by_z * (1.0 + square * (1.0 / 6.0 + square / 120.0))
        nodal.v[j] = nodal.v[j] * even + nodal.v_z[j] * odd
        by_rate = own(impedance, j) * nodal.v_z[j] * nodal.inverse[j] + abs(nodal.by_z[j])
        by_rate = with_bend(law, by_rate, nodal.v_z[j])
        by_state = abs(nodal.slope[j] + nodal.by_z[j] * nodal.ratio[j])
        neglected = 0.5 * (by_rate * square + by_state * by_psi * by_psi) + 1e-2 * square * square * abs(by_z)
        if not neglected <= error:  # NaN stays
            error = neglected
    return error


@inlined
def _relax(nodes: Nodes, impedance: Impedance, integral: Array, sweeps: int, enough: float, nodal: Nodal) -> float:
    """nodal.change, the right-hand side c of psi, <- change of psi, and the mismatch as if every other node's z had changed, by
    `sweeps` over the equations

        dz = -mismatch - kappa dz - ratio dpsi,     dpsi = c + A (slope dpsi - B kappa dz),

    B = h G_z and kappa_jl = K_jl v_z,l/(F_z,j + K_jj v_z,j) for l != j. Returns the last change; if that is below `enough`, the
    sweeps end. An early node influences a late one as in an integral, so that sweeps converge faster than powers of the largest
    influence on a node.
    """
    s, moved = len(nodes), 0.0
    for j in range(s):
        nodal.stress[j] = 0.0
        nodal.trial[j] = nodal.change[j]
    for _ in range(sweeps):
        moved = _pull(impedance, nodes, nodal)
        for j in range(s):
            nodal.gain[j] = nodal.slope[j] * nodal.trial[j] - nodal.by_z[j] * nodal.stress[j]
        for j in range(s):
            change = nodal.change[j]
            for m in range(s):
                change += integral[m, j] * nodal.gain[m]
            moved = max(moved, abs(change - nodal.trial[j]))
            nodal.trial[j] = change
        if enough > 0.0 and moved < enough:
            break
    for j in range(s):
        nodal.mismatch[j] += nodal.stress[j]
        nodal.change[j] = nodal.trial[j]
    return moved


@by_class(inline=True)
def _sweeps_for(impedance: Impedance, total: float, exactly: bool) -> int:
    """Sweeps that a Newton iteration needs if the largest influence of all nodes on one is `total`; 0: elimination is cheaper, or
    wanted because it solves strongly coupled nodes `exactly`."""
    if total < 0.5:
        return 2 if total < 0.05 else 4 if total < 0.2 else 6
    return 0 if exactly or total > 3.0 else 8 if total < 1.0 else 10


@_sweeps_for.register(Diagonal)
def _sweeps_alone(impedance, total, exactly):  # type: ignore[no-untyped-def]
    return 2 if total < 0.01 else 3 if total < 0.04 else 0  # what they leave, total^(sweeps + 1) < 3e-6, is not measured


@by_class(inline=True)
def _pull(impedance: Impedance, nodes: Nodes, nodal: Nodal) -> float:
    """nodal.stress <- kappa dz, what the other nodes add to the mismatch of a node; returns the largest change."""
    s, moved = len(nodes), 0.0
    for j in range(s):
        change = -nodal.mismatch[j] - nodal.stress[j] - nodal.ratio[j] * nodal.trial[j]
        nodal.gain[j] = nodal.v_z[j] * change
    for j in range(s):
        stress = others(impedance, nodes, j, nodal.gain) * nodal.inverse[j]
        moved = max(moved, abs(stress - nodal.stress[j]))
        nodal.stress[j] = stress
    return moved


@_pull.register(Diagonal)
def _pull_nothing(impedance, nodes, nodal):  # type: ignore[no-untyped-def]
    return 0.0


@by_class()
def _eliminate_nodes(impedance: Any, nodes: Nodes, integral: Array, nodal: Nodal) -> None:
    """As `_relax`, by elimination of all nodes. With P = 1 - A h G_psi and c the right-hand side of psi, linearised friction and
    state are

        (1 + kappa) dz + ratio dpsi = -mismatch,     dpsi = P^-1 (c + A B dz).

    dpsi is eliminated."""
    matrix, state, rate = impedance.matrix, nodal.state, nodal.rate
    s, rows = len(nodes), matrix.shape[0]  # equal; loops over rows are not to be unrolled
    for j in range(rows):
        total = nodal.change[j]
        for m in range(s):
            by_z = integral[m, j] * nodal.by_z[m]
            state[j, m] = -integral[m, j] * nodal.slope[m] - by_z * nodal.ratio[m]
            state[j, s + 1 + m] = by_z
            total += by_z * nodal.mismatch[m]
        state[j, j] += 1.0
        state[j, s] = total
    eliminate(state, 2 * s + 1)
    for j in range(rows):
        ratio, inverse = nodal.ratio[j], nodal.inverse[j]
        for m in range(s):
            rate[j, m] = ratio * state[j, s + 1 + m] + matrix[j, m] * nodal.v_z[m] * inverse
        rate[j, j] += 1.0 - matrix[j, j] * nodal.v_z[j] * inverse
        rate[j, s] = -nodal.mismatch[j] - ratio * state[j, s]
    eliminate(rate, s + 1)
    for j in range(rows):
        change = state[j, s]
        for m in range(s):
            change += state[j, s + 1 + m] * rate[m, s]
        nodal.change[j] = change
        nodal.mismatch[j] = -rate[j, s] - nodal.ratio[j] * change


@_eliminate_nodes.register(Diagonal)
def _eliminate_alone(impedance, nodes, integral, nodal):  # type: ignore[no-untyped-def]
    """change <- (1 - A diag(slope))^-1 change."""
    s, state = len(nodes), nodal.state
    for j in range(s):
        for m in range(s):
            state[j, m] = -integral[m, j] * nodal.slope[m]
        state[j, j] += 1.0
        state[j, s] = nodal.change[j]
    eliminate(state, s + 1)
    for j in range(s):
        nodal.change[j] = state[j, s]


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


@inlined
def emit(
    nodes: Nodes,
    stiffness: float,
    impedance: Impedance,
    step: tuple[float, float],
    integral: Array,
    nodal: Nodal,
    elastic: float,
    pieces: Pieces,
    k: int,
) -> float:
    """Piece k <- the `step` (start, length), with the stress S - K v and the elastic stress y' = stiffness (V - v). `elastic` is
    y at the step's start; returns the change of y in it."""
    s, (start, length) = len(nodes), step
    pieces.time[k] = start
    pieces.length[k] = length
    for j in range(s):
        pieces.z[k, j] = nodal.z[j]
        pieces.psi[k, j] = nodal.psi[j]
        pieces.mu[k, j] = nodal.incoming[j] - own(impedance, j) * nodal.v[j] - others(impedance, nodes, j, nodal.v)
        nodal.trial[j] = 0.0
    for m in range(s):
        factor = length * stiffness * (nodal.drive[m] - nodal.v[m])
        for j in range(s):
            nodal.trial[j] += integral[m, j] * factor
    for j in range(s):
        pieces.y[k, j] = elastic + nodal.trial[j]
    return float(nodal.trial[s - 1])


def first_guess(nodes: Nodes, law: Law, impedance: float, incoming: Array, psi: float, z: float) -> tuple[Interface, bool]:
    """Nodal z for constant psi under the `incoming` stress (s,), from a guess `z`, and whether Newton's method converged; for a
    step without an earlier one to extrapolate. psi does not change in a step of length 0."""
    stages, (v, _, friction, *_) = len(nodes), respond(law, z, psi)
    if np.abs(friction + impedance * v - incoming).max() < _ROUNDING:  # steady sliding
        return constant_guess(psi, z, stages), True
    rule, nodal, here = rule_of(stages)[1], nodal_of(stages), law_of_step(law, psi)
    nodal.incoming[:], nodal.left[:], nodal.psi[:], nodal.z[:] = incoming, psi, psi, z
    to_step(here, law, nodal.z)
    used = solve(here, nodes, Diagonal(impedance), 0.0, rule, _ROUNDING, nodal)
    if not used:
        return constant_guess(psi, z, stages), False
    to_own(here, nodal.z)
    return Interface(nodal.psi, nodal.z), True
