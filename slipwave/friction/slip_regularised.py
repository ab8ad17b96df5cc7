"""The slip law with the regularised direct effect: mu as in `regularised`,  phi' = -|v| phi ln(|v| phi)."""

import math
from typing import NamedTuple

from slipwave.friction.regularised import direct_effect


class SlipRegularised(NamedTuple):
    """Reference friction a_star, direct effect a, evolution effect b."""

    a_star: float
    a: float
    b: float


def respond(law: SlipRegularised, z: float, psi: float) -> tuple[float, float, float, float, float, float, float, float]:
    """G = -|v| (ln|v| + psi), and 0 at v = 0."""
    v, v_z, friction, friction_z, friction_psi = direct_effect(law.a_star, law.a, law.b, z, psi)
    speed = abs(v)
    distance = math.log(max(speed, 1e-300)) + psi
    slope = -math.copysign(v_z, v) * (1.0 + distance)
    return v, v_z, friction, friction_z, friction_psi, -speed * distance, slope, -speed
