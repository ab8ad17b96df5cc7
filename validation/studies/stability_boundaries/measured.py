"""What the study of stability boundaries measures: critical r over V."""

from typing import NamedTuple

import numpy as np

from reduced import closed_forms
from reduced.stability import critical_round_trip, friction_slopes, scaled
from slipwave.observe.pieces import Array
from slipwave.scene import Scene

TRACED = {"delay": closed_forms.delay_epsilon, "kelvin-voigt": closed_forms.kelvin_voigt_epsilon}
"""Models whose boundary is traced, with its closed form."""


class Curves(NamedTuple):
    """Critical r over V (Fig 2): computed from impedance, and closed forms; `gap` the largest relative difference of the two."""

    velocity: Array
    delay: Array
    kelvin_voigt: Array
    gap: float

    @property
    def error(self) -> Array:
        """Relative error of the Kelvin-Voigt system's critical r, (27) against (39)."""
        return self.kelvin_voigt / self.delay - 1.0


def critical_over_velocity(paper: Scene, velocities: Array) -> Curves:
    """r_c(V) of the delay and the Kelvin-Voigt system from their impedance, compared with (39) and (27)."""
    computed: dict[str, list[float]] = {"delay": [], "kelvin-voigt": []}
    gap = 0.0
    for velocity in velocities:
        driven, slopes = scaled(paper, velocity=float(velocity)), friction_slopes(paper.law, float(velocity))
        for model, closed in (("delay", closed_forms.delay_r), ("kelvin-voigt", closed_forms.kelvin_voigt_r)):
            r_c, _ = critical_round_trip(driven, model)
            gap = max(gap, abs(r_c / closed(slopes, paper.upper.epsilon) - 1.0))
            computed[model].append(r_c)
    return Curves(velocities, np.array(computed["delay"]), np.array(computed["kelvin-voigt"]), gap)
