"""The ageing law with the regularised direct effect, which allows v <= 0:

    mu = a asinh( (v/2) exp((a_* + b psi)/a) ),   phi' = 1 - |v| phi,   v = 2 RATE_FLOOR sinh z.

Source: Rice, Lapusta, Ranjith (2001) in the overflow-safe form asinh(x e^c) = c + ln(x + sqrt(x^2 + e^-2c)). For v far above
(2) exp(-(a_* + b psi)/a) it equals the plain law (3) up to terms of relative size (that ratio)^2.
"""

import math
from typing import NamedTuple

RATE_FLOOR = 1e-20
_LARGEST_EXPONENT = 300.0


class AgeingRegularised(NamedTuple):
    """Reference friction a_star, direct effect a, evolution effect b."""

    a_star: float
    a: float
    b: float


def rate_of(law: AgeingRegularised, z: float) -> float:
    """v = 2 RATE_FLOOR sinh z."""
    return 2.0 * RATE_FLOOR * math.sinh(z)


def unknown_of(law: AgeingRegularised, v: float) -> float:
    """z = asinh(v / (2 RATE_FLOOR))."""
    return math.asinh(v / (2.0 * RATE_FLOOR))


def respond(law: AgeingRegularised, z: float, psi: float) -> tuple[float, float, float, float, float, float, float, float]:
    """F = a asinh((v/2) e^c) with c = (a_* + b psi)/a;  G = e^-psi - |v|."""
    v = 2.0 * RATE_FLOOR * math.sinh(z)
    v_z = 2.0 * RATE_FLOOR * math.cosh(z)
    c = (law.a_star + law.b * psi) / law.a
    half = 0.5 * abs(v)
    root = math.sqrt(half * half + math.exp(-2.0 * c))
    slope = v / (2.0 * root)
    # the logarithm would lose every digit of a rate near rest, the exponential overflows where friction is weak (a small)
    size = math.asinh(half * math.exp(c)) if c < _LARGEST_EXPONENT else c + math.log(half + root)
    friction = math.copysign(law.a * size, v)
    healing = math.exp(-psi)
    sign = math.copysign(1.0, v)
    return v, v_z, friction, law.a * 0.5 * v_z / root, law.b * slope, healing - abs(v), -sign * v_z, -healing


def steady_state(law: AgeingRegularised, v: float) -> float:
    """psi_ss = -ln |v|."""
    return -math.log(abs(v))
