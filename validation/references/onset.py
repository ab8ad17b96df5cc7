"""Onset of stick-slip of alike plain slabs from the paper's closed forms, for the studies, without a solver.

Rates and times on the friction clock L/V*; V in V*. The formulas themselves are those of `reduced.closed_forms`.
"""

import math

from reduced import closed_forms
from slipwave.friction.ageing import Ageing
from slipwave.friction.law import FrictionSlopes

FAST_PERIOD_KELVIN_VOIGT = math.pi / math.sqrt(6.0)
"""Period of the ripples of the Kelvin-Voigt system in the slow phase (43), in transits; exactly 1 in the delay system."""


def onset_of(law: Ageing, epsilon: float, velocity: float) -> dict[str, float]:
    """The critical frequency "omega_c" (20), (38) of the ageing law at steady sliding with rate `velocity`, and by model the
    critical round trips: r_* (22), (39), (27). From F_v = a/V, G_phi = V, F_ss' = (a - b)/V of (16)."""
    slopes = FrictionSlopes(law.a / velocity, velocity, (law.a - law.b) / velocity)
    return {
        "omega_c": slopes.omega_c,
        "quasistatic": closed_forms.quasistatic_r(slopes, epsilon),
        "delay": closed_forms.delay_r(slopes, epsilon),
        "kelvin-voigt": closed_forms.kelvin_voigt_r(slopes, epsilon),
    }
