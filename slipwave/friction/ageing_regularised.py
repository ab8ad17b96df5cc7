"""The ageing law with the regularised direct effect: mu as in `regularised`,  phi' = 1 - |v| phi."""

import math
from typing import NamedTuple

from slipwave.friction.regularised import direct_effect


class AgeingRegularised(NamedTuple):
    """Reference friction a_star, direct effect a, evolution effect b."""

    a_star: float
    a: float
    b: float


def respond(law: AgeingRegularised, z: float, psi: float) -> tuple[float, float, float, float, float, float, float, float]:
    """G = e^-psi - |v|."""
    v, v_z, friction, friction_z, friction_psi = direct_effect(law.a_star, law.a, law.b, z, psi)
    healing = math.exp(-psi)
    return v, v_z, friction, friction_z, friction_psi, healing - abs(v), -math.copysign(v_z, v), -healing
