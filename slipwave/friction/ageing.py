"""Dieterich's ageing law (3, 16): mu = a_* + a ln v + b ln phi,  phi' = 1 - v phi.  Unknowns z = ln v, psi = ln phi."""

import math
from typing import NamedTuple

from slipwave.friction.law import Response
from slipwave.friction.regularised import direct_effect


class Ageing(NamedTuple):
    """Parameters of (16): reference friction a_star, direct effect a, evolution effect b."""

    a_star: float
    a: float
    b: float


def respond_ageing(law: Ageing, z: float, psi: float) -> Response:
    """F = a_* + a z + b psi,  G = e^-psi - e^z  (psi' = phi'/phi)."""
    v = math.exp(z)
    healing = math.exp(-psi)
    return v, v, law.a_star + law.a * z + law.b * psi, law.a, law.b, healing - v, -v, -healing


class AgeingRegularised(Ageing):
    """As the plain law, with the direct effect of `regularised`."""


def respond_ageing_regularised(law: AgeingRegularised, z: float, psi: float) -> Response:
    """G = e^-psi - |v|."""
    v, v_z, friction, friction_z, friction_psi = direct_effect(law.a_star, law.a, law.b, z, psi)
    healing = math.exp(-psi)
    return v, v_z, friction, friction_z, friction_psi, healing - abs(v), -math.copysign(v_z, v), -healing
