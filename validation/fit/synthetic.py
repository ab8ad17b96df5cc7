"""Synthetic velocity steps of known parameters, for studies of fits."""

import numpy as np

from slipwave.input import read
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.fit.forward import Forward
from validation.fit.parameters import Schedule, free_parameters
from validation.fit.problem import FrictionProblem, problem_of
from validation.fit.records import Experiment, travelled

TRUTH = {"interface.a": 0.01, "interface.b": 0.015, "interface.memory_length": 1e-5}
STIFFNESS = "slab.shear_modulus"
NOISE = 1e-4

FAST = 1e-5
"""The faster velocity (m/s): slip by L takes one second."""

STEP = Schedule((0.0, 0.5, 0.5), (1e-6, 1e-6, FAST))

_STRESS, _THICKNESS = 5e6, 0.05  # Pa, m
_TIMES = (0.4, 5.0)  # s
_SAMPLES = 200


def stepped_scene(share: float, kappa: float) -> Scene:
    """Slabs whose transit is `share` of the time of slip by L at the faster velocity, and whose stiffness is `kappa` times the
    critical one of a quasi-static spring, (b - a) sigma/L. Only these two numbers matter; the slabs' material follows from
    them."""
    a, b, length = TRUTH.values()
    modulus = 2.0 * _THICKNESS * kappa * (b - a) * _STRESS / length
    density = modulus * (share * length / FAST / (2.0 * _THICKNESS)) ** 2
    return read(
        {
            "name": f"step-{share:.4g}-{kappa:.4g}",
            "interface": {"law": "ageing", "a_star": 0.6, "a": a, "b": b}
            | {"normal_stress": _STRESS, "memory_length": length, "reference_velocity": 1e-6},
            "slab": {"density": density, "shear_modulus": modulus, "thickness": _THICKNESS},
            "drive": {"velocity": 1.0},
        }
    )


def stepped_record(friction: Array | None = None) -> Experiment:
    """A record of the velocity step: `friction`, or zeros."""
    times = np.linspace(*_TIMES, _SAMPLES)
    values = np.zeros(_SAMPLES) if friction is None else friction
    return Experiment("steps", times, values, travelled(STEP, times), STEP, (), 1.0 / NOISE)


def problem_for(scene: Scene, model: str, record: Experiment, *more: str) -> FrictionProblem:
    """The fit of a, b, L and `more` keys by `model` to one record."""
    return problem_of(scene, free_parameters(scene, [*TRUTH, *more]), [], [record], model, 1e-8)


def truth_of(problem: FrictionProblem) -> Array:
    """The scene's own values, as least squares varies them."""
    return np.array([one.inner(one.start) for one in problem.free])


def true_friction(problem: FrictionProblem) -> Array:
    """Friction of the problem's own model at the true values."""
    made: Forward = problem.models[0]
    return made.friction(truth_of(problem))
