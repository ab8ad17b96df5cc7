"""The one interface condition (MODEL.md section 3), shared by every solver.

At slip rate v the slabs give the stress  R - Z v  and friction requires F(v, psi). The balance

    F(z, psi) + Z v(z) = R

is one scalar equation. It is monotone in the rate unknown z because F_z > 0 and Z >= 0, so it has exactly one root. Solvers solve
it for z instead of stepping the friction law; therefore the stiffness a/v limits no solver's step.
"""

import math

from slipwave.compiled import inlined
from slipwave.friction import Law, respond

MAX_ITERATIONS = 200
_LARGEST_STEP = 4.0
_OVERFLOWN = 1e300
_PATIENCE = 40  # iterations of Newton; from a start hundreds above the root, where v = e^z dominates, each gains only 1 in z
_TOLERANCE = 1e-8  # of a Newton step; the remaining error is of the order of its square


@inlined
def solve_interface(law: Law, impedance: float, incoming: float, psi: float, z: float) -> tuple[float, int]:
    """Root z of F(z, psi) + impedance * v(z) = incoming, by Newton kept inside a bracket.

    `impedance` is Z = 1/(1/eps_1 + 1/eps_2) (>= 0) and `incoming` is R = Z (S_1/eps_1 + S_2/eps_2), both in units of the normal
    stress; `z` is the starting value. Returns (z, iterations). iterations = 0 means no convergence; the caller counts these.
    Dimensionless; no clock.
    """
    low, high = -math.inf, math.inf
    for iteration in range(1, MAX_ITERATIONS + 1):
        v, v_z, friction, friction_z, _, _, _, _ = respond(law, z, psi)
        residual = friction + impedance * v - incoming
        if not math.isfinite(residual):
            if math.isnan(incoming) or math.isnan(psi) or math.isnan(z):
                return z, 0
            residual = math.copysign(_OVERFLOWN, z)
        if residual > 0.0:
            high = z
        else:
            low = z
        step = -residual / (friction_z + impedance * v_z)
        if abs(residual) >= _OVERFLOWN:
            step = -math.copysign(_LARGEST_STEP, residual)
        if abs(step) <= _TOLERANCE * (1.0 + abs(z)):
            return z + step, iteration
        trial = z + min(_LARGEST_STEP, max(-_LARGEST_STEP, step))
        if iteration > _PATIENCE:  # widen the search until the root is bracketed, then halve the bracket
            trial = z - math.copysign(2.0 ** (iteration - _PATIENCE), residual) if math.isinf(high - low) else 0.5 * (low + high)
        if not low < trial < high:
            trial = 0.5 * (low + high)
            if not low < trial < high:
                # not where a user's law has no value on one side: the bracket has closed on the edge of that, not on a root
                has_values = math.isfinite(respond(law, low, psi)[2]) and math.isfinite(respond(law, high, psi)[2])
                return trial, iteration if has_values else 0
        z = trial
    return z, 0
