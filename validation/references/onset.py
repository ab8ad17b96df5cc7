"""Onset of stick-slip of alike plain slabs from the paper's closed forms, as the studies quote it: no solver is involved.

Rates and times on the friction clock L/V*; V in V*. The formulas themselves are those of `reduced.closed_forms`.
"""

import math
from dataclasses import dataclass

from reduced import closed_forms
from reduced.stability.friction import FrictionSlopes
from slipwave.friction.ageing import Ageing


@dataclass(frozen=True)
class Onset:
    """Critical frequency and critical round trips for the ageing law at steady sliding with rate `velocity`."""

    law: Ageing
    epsilon: float
    velocity: float

    @property
    def slopes(self) -> FrictionSlopes:
        """F_v = a/V, G_phi = V, F_ss' = (a - b)/V of (16)."""
        return FrictionSlopes(self.law.a / self.velocity, self.velocity, (self.law.a - self.law.b) / self.velocity)

    @property
    def omega_c(self) -> float:
        """Critical frequency (20), (38)."""
        return closed_forms.critical_frequency(self.slopes)

    @property
    def r_quasistatic(self) -> float:
        """r_* (22)."""
        return closed_forms.quasistatic_r(self.slopes, self.epsilon)

    @property
    def r_delay(self) -> float:
        """Critical r of the delay system (39)."""
        return closed_forms.delay_r(self.slopes, self.epsilon)

    @property
    def r_kelvin_voigt(self) -> float:
        """Critical r of the Kelvin-Voigt system (27)."""
        return closed_forms.kelvin_voigt_r(self.slopes, self.epsilon)

    @property
    def r_quasidynamic(self) -> float:
        """Critical r with radiation damping."""
        return closed_forms.quasidynamic_r(self.slopes, self.epsilon)


FAST_PERIOD_KELVIN_VOIGT = math.pi / math.sqrt(6.0)
"""Period of the ripples of the Kelvin-Voigt system in the slow phase (43), in transits; exactly 1 in the delay system."""
