"""Ruina's slip law: mu = a_* + a ln v + b ln phi,  phi' = -v phi ln(v phi).  Unknowns z = ln v, psi = ln phi."""

import math
from typing import NamedTuple

from slipwave.friction.law import Response
from slipwave.friction.regularised import direct_effect


class Slip(NamedTuple):
    """Reference friction a_star, direct effect a, evolution effect b."""

    a_star: float
    a: float
    b: float


def respond_slip(law: Slip, z: float, psi: float) -> Response:
    """F = a_* + a z + b psi,  G = -e^z (z + psi)."""
    v = math.exp(z)
    distance = z + psi
    return v, v, law.a_star + law.a * z + law.b * psi, law.a, law.b, -v * distance, -v * (1.0 + distance), -v


class SlipRegularised(Slip):
    """As the plain law, with the direct effect of `regularised`."""


def respond_slip_regularised(law: SlipRegularised, z: float, psi: float) -> Response:
    """G = -|v| (ln|v| + psi), and 0 at v = 0."""
    v, v_z, friction, friction_z, friction_psi = direct_effect(law.a_star, law.a, law.b, z, psi)
    speed = abs(v)
    distance = math.log(max(speed, 1e-300)) + psi
    slope = -math.copysign(v_z, v) * (1.0 + distance)
    return v, v_z, friction, friction_z, friction_psi, -speed * distance, slope, -speed
