"""What the study of stability boundaries measures: critical r over V, and the error laws of the reductions."""

from typing import NamedTuple

import numpy as np

from reduced import closed_forms
from reduced.stability import critical_round_trip, error_law, friction_slopes, scaled
from scene.observe.pieces import Array
from scene.scene import Scene

MODELS = ("quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:1", "modal:2", "modal:8")
"""The reductions whose error law is measured."""


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


class Law(NamedTuple):
    """Relative error of a model's critical r at the paper's epsilon and at a quarter of it, and what the law predicts."""

    measured: tuple[float, float]
    predicted: tuple[float, float]
    power: int


def error_laws(paper: Scene) -> dict[str, Law]:
    """Every model's law, measured at the paper's epsilon and at a quarter of it."""
    slopes = friction_slopes(paper.law, paper.velocity)
    softer = [paper, scaled(paper, epsilon=0.25)]
    exact = [critical_round_trip(what) for what in softer]
    result = {}
    for model in MODELS:
        law = error_law(model, slopes)
        measured = [critical_round_trip(what, model)[0] / r - 1.0 for what, (r, _) in zip(softer, exact, strict=True)]
        predicted = [law.at(r * omega) for r, omega in exact]
        result[model] = Law((measured[0], measured[1]), (predicted[0], predicted[1]), law.power)
    return result
