"""Solves one collocation step of friction (`slipwave.step.newton`), also where the slip rate changes its sign.

There |v|, and with it the rate of the state, has a kink, which no polynomial through the nodes integrates. So the integral of the
state's rate is computed in parts that end at the zeros of v, along the polynomials of the solved step, and the step is solved
again with the difference. The stress has no such kink: at v = 0 it does not depend on the state.
"""

import numpy as np

from slipwave.compiled import njit
from slipwave.compiled.dispatch import by_class
from slipwave.friction import Law, OfStep, law_of_step, respond, to_own, to_step
from slipwave.friction.interface import solve_interface
from slipwave.observe.extrema import evaluate, find_root
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes, Rule, rule_of
from slipwave.step.impedance import Diagonal, Impedance, own
from slipwave.step.newton import iterate
from slipwave.step.nodal import Interface, Nodal, constant_guess, nodal_of

_ROUNDING = 1e-14  # of a stress, and of an iteration's error
_MOST_CORRECTIONS = 10
_GAUSS = (
    (0.06943184420297371, 0.1739274225687269),
    (0.33000947820757187, 0.3260725774312731),
    (0.6699905217924281, 0.3260725774312731),
    (0.9305681557970262, 0.1739274225687269),
)  # points and weights on the unit interval


@by_class()
def solve(law: Law, nodes: Nodes, impedance: Impedance, h: float, rule: Rule, tolerance: float, nodal: Nodal) -> int:
    """Newton for psi, z and v at the nodes of a step of length `h` (friction clock), from those in `nodal`. Returns iterations,
    0 = failed."""
    return iterate(nodes, law, impedance, h, rule.integral, tolerance, nodal)


@solve.register(OfStep)
def _solve_through_rest(law, nodes, impedance, h, rule, tolerance, nodal):  # type: ignore[no-untyped-def]
    used = iterate(nodes, law, impedance, h, rule.integral, tolerance, nodal)
    if used == 0:  # after a jump of the stress: psi as before it, and friction at each node for itself, from rest
        for j in range(len(nodes)):
            nodal.psi[j] = nodal.left[j]
            nodal.z[j], _ = solve_interface(law, own(impedance, j), nodal.incoming[j], nodal.psi[j], 0.0)
        used = iterate(nodes, law, impedance, h, rule.integral, tolerance, nodal)
    if used == 0 or h == 0.0 or not _reverses(nodes, rule, nodal):
        return used
    for j in range(len(nodes)):
        nodal.missed[j] = 0.0
    for _ in range(_MOST_CORRECTIONS):
        if _correct(nodes, law, h, rule, nodal) <= tolerance:
            return used
        more = iterate(nodes, law, impedance, h, rule.integral, tolerance, nodal)
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
def _correct(nodes: Nodes, law: Law, h: float, rule: Rule, nodal: Nodal) -> float:
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
