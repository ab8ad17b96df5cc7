"""The state effect cut off at high slip rates, with either evolution of the state:

    mu = a_* + a ln v + b ln(phi + 1/v_c) = (a_* - b ln v_c) + a ln v + b ln(1 + phi v_c).

Source: Okubo (1989); in SI, up to the constant, mu_* + a ln(V/V*) + b ln(theta V_c/L + 1). Contacts younger than L/V_c are all
equally weak, so that steady friction weakens with the rate as the plain laws do where v is far below v_c, and strengthens above:

    d mu_ss/d ln v = a - b v_c/(v_c + v),   0 at v = v_c (b - a)/a, where mu_ss has its minimum.

By the choice of the constant, the plain laws with the same a_* are the limit v_c -> infinity; at steady sliding the difference is
at most b v/v_c.
"""

import math
from typing import NamedTuple

from slipwave.compiled import njit
from slipwave.friction.law import Response


class AgeingCutoff(NamedTuple):
    """As the plain law, with the slip rate above which the state effect is cut off (V*)."""

    a_star: float
    a: float
    b: float
    cutoff_velocity: float


class SlipCutoff(AgeingCutoff):
    """The same parameters."""


@njit
def state_effect(b: float, cutoff: float, psi: float) -> tuple[float, float]:
    """b ln(phi + 1/v_c) and its derivative in psi, for phi of any size."""
    excess = psi + math.log(cutoff)  # ln(phi v_c)
    small = math.exp(-abs(excess))
    share = (1.0 if excess > 0.0 else small) / (1.0 + small)
    return b * (max(psi, -math.log(cutoff)) + math.log1p(small)), b * share


def respond_ageing_cutoff(law: AgeingCutoff, z: float, psi: float) -> Response:
    """G = e^-psi - e^z."""
    v, healing = math.exp(z), math.exp(-psi)
    strength, slope = state_effect(law.b, law.cutoff_velocity, psi)
    return v, v, law.a_star + law.a * z + strength, law.a, slope, healing - v, -v, -healing


def respond_slip_cutoff(law: SlipCutoff, z: float, psi: float) -> Response:
    """G = -e^z (z + psi)."""
    v, distance = math.exp(z), z + psi
    strength, slope = state_effect(law.b, law.cutoff_velocity, psi)
    return v, v, law.a_star + law.a * z + strength, law.a, slope, -v * distance, -v * (1.0 + distance), -v
