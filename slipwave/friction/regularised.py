"""The regularised direct effect, which allows v <= 0. The laws that use it differ only in the evolution of the state:

    mu = a asinh( (v/2) exp((a_* + b psi)/a) ),   v = 2 RATE_FLOOR sinh z.

Source: Rice, Lapusta, Ranjith (2001) in the overflow-safe form asinh(x e^c) = c + ln(x + sqrt(x^2 + e^-2c)). For v far above
2 exp(-(a_* + b psi)/a) it equals the plain law (3) up to terms of relative size (that ratio)^2.
"""

import math

from slipwave.compiled import njit
from slipwave.friction.law import Law

RATE_FLOOR = 1e-20
_LARGEST_EXPONENT = 300.0


def sinh_rate(law: Law, z: float) -> float:
    """v = 2 RATE_FLOOR sinh z."""
    return 2.0 * RATE_FLOOR * math.sinh(z)


def sinh_unknown(law: Law, v: float) -> float:
    """z = asinh(v / (2 RATE_FLOOR))."""
    return math.asinh(v / (2.0 * RATE_FLOOR))


@njit
def direct_effect(a_star: float, a: float, b: float, z: float, psi: float) -> tuple[float, float, float, float, float]:
    """(v, v_z, F, F_z, F_psi) with F = a asinh((v/2) e^c), c = (a_* + b psi)/a."""
    v = 2.0 * RATE_FLOOR * math.sinh(z)
    v_z = 2.0 * RATE_FLOOR * math.cosh(z)
    c = (a_star + b * psi) / a
    half = 0.5 * abs(v)
    root = math.sqrt(half * half + math.exp(-2.0 * c))
    # near rest the logarithm would lose every digit of the rate; for weak friction (small a) the exponential overflows
    size = math.asinh(half * math.exp(c)) if c < _LARGEST_EXPONENT else c + math.log(half + root)
    return v, v_z, math.copysign(a * size, v), a * 0.5 * v_z / root, b * v / (2.0 * root)
