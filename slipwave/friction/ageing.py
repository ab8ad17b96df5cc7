"""Dieterich's ageing law (3, 16): mu = a_* + a ln v + b ln phi,  phi' = 1 - v phi.  Unknowns z = ln v, psi = ln phi."""

import math
from typing import NamedTuple


class Ageing(NamedTuple):
    """Parameters of (16): reference friction a_star, direct effect a, evolution effect b."""

    a_star: float
    a: float
    b: float


def respond(law: Ageing, z: float, psi: float) -> tuple[float, float, float, float, float, float, float, float]:
    """F = a_* + a z + b psi,  G = e^-psi - e^z  (psi' = phi'/phi)."""
    v = math.exp(z)
    healing = math.exp(-psi)
    return v, v, law.a_star + law.a * z + law.b * psi, law.a, law.b, healing - v, -v, -healing


def steady_state(law: Ageing, v: float) -> float:
    """psi_ss = -ln v  (phi_ss = 1/v)."""
    return -math.log(v)
