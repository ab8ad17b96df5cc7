"""The paper's closed forms for steady sliding of alike plain slabs with the ageing law: nothing here is computed by a solver.

All rates and times on the friction clock L/V* unless told otherwise; V in V*.
"""

import math
from dataclasses import dataclass

from scene.friction.ageing import Ageing


@dataclass(frozen=True)
class Onset:
    """Onset of stick-slip: critical frequency omega_c (20, 38), quasi-static critical r_* (22)."""

    law: Ageing
    epsilon: float
    velocity: float

    @property
    def omega_c(self) -> float:
        """V sqrt((b - a)/a), the same in the delay system and in every lossless reduction (20, 38)."""
        return self.velocity * math.sqrt((self.law.b - self.law.a) / self.law.a)

    @property
    def r_quasistatic(self) -> float:
        """r_* = epsilon/(b - a) (22)."""
        return self.epsilon / (self.law.b - self.law.a)

    @property
    def r_delay(self) -> float:
        """(2/omega_c) atan(r_* omega_c/2) (39)."""
        return 2.0 / self.omega_c * math.atan(0.5 * self.r_quasistatic * self.omega_c)

    @property
    def r_kelvin_voigt(self) -> float:
        """The middle root of the cubic (21) in closed form (27)."""
        ratio = self.r_quasistatic * self.omega_c
        theta = math.atan(math.sqrt((1.0 + 8.0 / ratio**2) ** 3 - 1.0))
        return self.r_quasistatic * (1.0 + 2.0 * math.sin(theta / 3.0 - math.pi / 6.0) / math.cbrt(math.cos(theta)))

    @property
    def r_quasidynamic(self) -> float:
        """epsilon/(b - a - epsilon V/2): the rule of section 2.2 with Z = epsilon/s + epsilon/2; radiation damping stabilises."""
        return self.epsilon / (self.law.b - self.law.a - 0.5 * self.epsilon * self.velocity)

    def cubic(self, r: float) -> float:
        """Left side of (21), scaled by r_*^-3: zero at the Kelvin-Voigt system's critical r."""
        x, k = r / self.r_quasistatic, 24.0 / (self.omega_c * self.r_quasistatic) ** 2
        return x**3 - 3.0 * x**2 - k * x + k

    def delay_quotient(self, r: float) -> complex:
        """Q(i omega_c) of (37) over |A|: zero at the delay system's critical r."""
        v, s = self.velocity, 1j * self.omega_c
        rate_slope, healing, steady_slope = self.law.a / v, v, (self.law.a - self.law.b) / v
        half = 0.5 * self.epsilon
        a = (rate_slope + half) * s + healing * (steady_slope + half)
        c = -(rate_slope - half) * s - healing * (steady_slope - half)
        delayed = complex(math.cos(self.omega_c * r), -math.sin(self.omega_c * r))
        return (a + c * delayed) / abs(a)


FAST_PERIOD_KELVIN_VOIGT = math.pi / math.sqrt(6.0)
"""Period of the ripples of the Kelvin-Voigt system in the slow phase (43), in transits; exactly 1 in the delay system."""
