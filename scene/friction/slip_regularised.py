"""The slip law with the regularised direct effect, which allows v <= 0:

    mu = a asinh( (v/2) exp((a_* + b psi)/a) ),   phi' = -|v| phi ln(|v| phi),   v = 2 RATE_FLOOR sinh z.

Source: Rice, Lapusta, Ranjith (2001) in the overflow-safe form asinh(x e^c) = c + ln(x + sqrt(x^2 + e^-2c)).
"""

import math
from typing import NamedTuple

RATE_FLOOR = 1e-20
_LARGEST_EXPONENT = 300.0


class SlipRegularised(NamedTuple):
    """Reference friction a_star, direct effect a, evolution effect b."""

    a_star: float
    a: float
    b: float


def rate_of(law: SlipRegularised, z: float) -> float:
    """v = 2 RATE_FLOOR sinh z."""
    return 2.0 * RATE_FLOOR * math.sinh(z)


def unknown_of(law: SlipRegularised, v: float) -> float:
    """z = asinh(v / (2 RATE_FLOOR))."""
    return math.asinh(v / (2.0 * RATE_FLOOR))


def respond(law: SlipRegularised, z: float, psi: float) -> tuple[float, float, float, float, float, float, float, float]:
    """F = a asinh((v/2) e^c) with c = (a_* + b psi)/a;  G = -|v| (ln|v| + psi), and 0 at v = 0."""
    v = 2.0 * RATE_FLOOR * math.sinh(z)
    v_z = 2.0 * RATE_FLOOR * math.cosh(z)
    c = (law.a_star + law.b * psi) / law.a
    speed = abs(v)
    root = math.sqrt(0.25 * v * v + math.exp(-2.0 * c))
    # the logarithm would lose every digit of a rate near rest, the exponential overflows where friction is weak (a small)
    size = math.asinh(0.5 * speed * math.exp(c)) if c < _LARGEST_EXPONENT else c + math.log(0.5 * speed + root)
    friction = math.copysign(law.a * size, v)
    distance = math.log(max(speed, 1e-300)) + psi
    sign = math.copysign(1.0, v)
    return (
        v,
        v_z,
        friction,
        law.a * 0.5 * v_z / root,
        law.b * v / (2.0 * root),
        -speed * distance,
        -sign * v_z * (1.0 + distance),
        -speed,
    )


def steady_state(law: SlipRegularised, v: float) -> float:
    """psi_ss = -ln |v|."""
    return -math.log(abs(v))
