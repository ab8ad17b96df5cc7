"""Friction over one step: the interface condition together with the state, by the implicit midpoint rule.

    F(z, psi) + Z v(z) = R,      psi - psi_old = (dt/2) (r G(z, psi) + nudge)

with the state psi at the whole time, psi_old half a step before, and dt in transits. Newton solves both equations together from
extrapolated values (usually two iterations). If that fails, psi is bracketed, and for each psi the first equation is solved by
`slipwave.friction.interface.solve_interface`, which cannot fail. None of this limits the step, however large a/v is. If the step
is so long that the pair has more than one solution (b dt r v/2 > (a + Z v)(1 + r dt/(2 phi)) for the ageing law), it is reported
as not converged.
"""

import math

from slipwave.compiled import njit
from slipwave.friction import Law, respond
from slipwave.friction.interface import solve_interface

_NEWTON_ITERATIONS = 8
_CONVERGED = 1e-7  # a Newton step this small leaves an error of half its square, 5e-15
_LARGEST_STEP = 2.0
_BRACKETINGS = 200


@njit
def solve_friction(
    law: Law, impedance: float, incoming: float, old: float, half: float, push: float, z: float, psi: float
) -> tuple[float, float, float, bool]:
    """(z, psi, v, converged) at the whole time, half a step after psi = `old`; `half` = r dt/2, `push` = nudge dt/2."""
    for _ in range(_NEWTON_ITERATIONS):
        v, v_z, friction, friction_z, friction_psi, rate, rate_z, rate_psi = respond(law, z, psi)
        balance = friction + impedance * v - incoming
        evolution = psi - old - half * rate - push
        slope = friction_z + impedance * v_z
        own = 1.0 - half * rate_psi
        determinant = slope * own + friction_psi * half * rate_z
        inverse = 1.0 / determinant
        z_step = (friction_psi * evolution - own * balance) * inverse
        psi_step = -(slope * evolution + half * rate_z * balance) * inverse
        size = abs(z_step) + abs(psi_step)
        if not (determinant > 0.0 and size < _LARGEST_STEP):
            break
        z += z_step
        psi += psi_step
        if size < _CONVERGED * (1.0 + abs(z)):
            return z, psi, v + v_z * z_step, True
    return _bracketed(law, impedance, incoming, old, half, push, z)


@njit
def _mismatch(
    law: Law, impedance: float, incoming: float, old: float, half: float, push: float, z: float, psi: float
) -> tuple[float, float, bool]:
    """(residual of the state equation, z, solved) at a trial psi, with z from the interface condition."""
    z, iterations = solve_interface(law, impedance, incoming, psi, z)
    return psi - old - half * respond(law, z, psi)[5] - push, z, iterations > 0


@njit
def _bracketed(
    law: Law, impedance: float, incoming: float, old: float, half: float, push: float, z: float
) -> tuple[float, float, float, bool]:
    """Bisection of the residual, which goes from -inf to +inf with psi; fails if its slope at the root is not positive."""
    if not math.isfinite(z):
        z = 0.0
    reach = 1.0
    low, high = old - reach, old + reach
    while reach < 1e3 and _mismatch(law, impedance, incoming, old, half, push, z, low)[0] > 0.0:
        reach *= 2.0
        low = old - reach
    while reach < 1e3 and _mismatch(law, impedance, incoming, old, half, push, z, high)[0] < 0.0:
        reach *= 2.0
        high = old + reach
    psi = old
    solved = True
    for _ in range(_BRACKETINGS):
        psi = 0.5 * (low + high)
        if not low < psi < high:
            break
        residual, z, solved = _mismatch(law, impedance, incoming, old, half, push, z, psi)
        if residual > 0.0:
            high = psi
        else:
            low = psi
    v, v_z, _, friction_z, friction_psi, _, rate_z, rate_psi = respond(law, z, psi)
    determinant = (friction_z + impedance * v_z) * (1.0 - half * rate_psi) + friction_psi * half * rate_z
    return z, psi, v, solved and determinant > 0.0 and reach < 1e3
