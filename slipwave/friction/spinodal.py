"""A regularised spinodal law: steady friction rises, falls and rises again with the slip rate, and is smooth through v = 0.

    mu = a asinh( (v/2) e^((a_* + b ln(phi + 1/v_c))/a) ),   phi' = 1 - s phi,   s = sqrt(v^2 + v_s^2),   v = 2 RATE_FLOOR sinh z.

After Putelat, Dawes and Champneys (2017, Proc. R. Soc. A 473, 20160606), who drive a plate by a law of this kind. The text of
their paper was not at hand, only its abstract: this is NOT their formula with their constants. It is the regularised ageing law
with two more rates; its steady friction is spinodal, with a maximum and a minimum over ln v and weakening between them. The
direct effect is that of `regularised`, odd in v, and the state effect that of `cutoff`. At rest contacts age to L/v_s at most.
Where the direct effect is logarithmic,

    d mu_ss/d ln v = a - b (v/s)^2 v_c/(v_c + s),

so that for v_s << v_c steady friction has a maximum, the static friction, at v_s sqrt(a/(b - a)), a minimum at v_c (b - a)/a, and
weakens between them as the plain law does. For v_s -> 0 and v_c -> infinity it is the regularised ageing law.
"""

import math
from typing import NamedTuple

from slipwave.friction.cutoff import state_effect
from slipwave.friction.law import Response
from slipwave.friction.regularised import direct_effect


class Spinodal(NamedTuple):
    """As the plain law, with the slip rate v_s below which ageing saturates and v_c above which the state effect is cut off
    (V*)."""

    a_star: float
    a: float
    b: float
    saturation_velocity: float
    cutoff_velocity: float


def respond_spinodal(law: Spinodal, z: float, psi: float) -> Response:
    """G = e^-psi - s."""
    strength, slope = state_effect(law.b, law.cutoff_velocity, psi)
    v, v_z, friction, friction_z, by_strength = direct_effect(law.a_star, law.a, 1.0, z, strength)
    healing, speed = math.exp(-psi), math.hypot(v, law.saturation_velocity)
    return v, v_z, friction, friction_z, by_strength * slope, healing - speed, -v * v_z / speed, -healing


def steady_spinodal(law: Spinodal, v: float) -> float:
    """psi_ss = -ln s."""
    return -math.log(math.hypot(v, law.saturation_velocity))
