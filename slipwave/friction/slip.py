"""Ruina's slip law: mu = a_* + a ln v + b ln phi,  phi' = -v phi ln(v phi).  Unknowns z = ln v, psi = ln phi."""

import math
from typing import NamedTuple


class Slip(NamedTuple):
    """Reference friction a_star, direct effect a, evolution effect b."""

    a_star: float
    a: float
    b: float


def respond(law: Slip, z: float, psi: float) -> tuple[float, float, float, float, float, float, float, float]:
    """F = a_* + a z + b psi,  G = -e^z (z + psi)."""
    v = math.exp(z)
    distance = z + psi
    return v, v, law.a_star + law.a * z + law.b * psi, law.a, law.b, -v * distance, -v * (1.0 + distance), -v


def steady_state(law: Slip, v: float) -> float:
    """psi_ss = -ln v  (phi_ss = 1/v)."""
    return -math.log(v)
