"""Onset of stick-slip of alike plain slabs from the paper's closed forms, for the studies, without a solver.

Rates and times on the friction clock L/V*; V in V*. The formulas themselves are those of `reduced.closed_forms`.
"""

import math
from typing import NamedTuple

from reduced import closed_forms
from slipwave.friction.ageing import Ageing
from slipwave.friction.law import FrictionSlopes

FAST_PERIOD_KELVIN_VOIGT = math.pi / math.sqrt(6.0)
"""Period of the ripples of the Kelvin-Voigt system in the slow phase (43), in transits; exactly 1 in the delay system."""


class CriticalValues(NamedTuple):
    """Critical frequency (20), (38), and critical round trips: r_* (22), of the delay system (39), of the Kelvin-Voigt system
    (27), and with radiation damping."""

    omega_c: float
    r_quasistatic: float
    r_delay: float
    r_kelvin_voigt: float
    r_quasidynamic: float


def onset_of(law: Ageing, epsilon: float, velocity: float) -> CriticalValues:
    """Critical values of the ageing law at steady sliding with rate `velocity`, from F_v = a/V, G_phi = V, F_ss' = (a - b)/V of
    (16)."""
    slopes = FrictionSlopes(law.a / velocity, velocity, (law.a - law.b) / velocity)
    forms = (closed_forms.quasistatic_r, closed_forms.delay_r, closed_forms.kelvin_voigt_r, closed_forms.quasidynamic_r)
    return CriticalValues(slopes.omega_c, *(form(slopes, epsilon) for form in forms))
