import math

import pytest
from one_port_scenes import EPSILON, EVERY, PAPER, paper

from reduced.stability import (
    boundary,
    characteristic,
    critical_round_trip,
    error_law,
    friction_slopes,
    unstable_count,
    with_parameter,
)
from slipwave.errors import SceneError

SLOPES = friction_slopes(PAPER, 100.0)


def test_boundary_of_gripped_slabs_parts_stable_from_unstable():
    scene = EVERY["matched grip"]
    (curve, *_) = boundary(scene, "delay", ("log10_grip_impedance", "log10_r"), ((-2.0, 4.0), (-4.0, -2.0)))
    for i in range(5, len(curve.first) - 5, 10):
        at = with_parameter(scene, "log10_grip_impedance", curve.first[i])
        counts = [unstable_count(characteristic(with_parameter(at, "log10_r", curve.second[i] + d))) for d in (-1e-3, 1e-3)]
        assert sorted(counts) == [0, 2]


MODELS = ["quasistatic", "quasidynamic", "block8", "block12", "kelvin-voigt", "modal:1", "modal:3"]


@pytest.mark.parametrize("model", MODELS)
def test_error_laws(model):
    """The measured error of the critical r tends to the law as theta = r omega_c -> 0, at the law's power."""
    law = error_law(model, SLOPES)
    ratios = []
    for epsilon in (EPSILON, 0.5 * EPSILON, 0.25 * EPSILON):
        exact, omega = critical_round_trip(paper(epsilon=epsilon))
        reduced, _ = critical_round_trip(paper(epsilon=epsilon), model)
        ratios.append((reduced / exact - 1.0) / law.at(exact * omega))
    assert ratios[0] == pytest.approx(1.0, abs=0.2 if model == "quasidynamic" else 0.02)
    assert abs(ratios[1] - 1.0) < 0.6 * abs(ratios[0] - 1.0) + 1e-4


def test_error_laws_known_coefficients():
    known = {"quasistatic": (1 / 12, 2), "block8": (-1 / 24, 2), "block12": (1 / 720, 4), "kelvin-voigt": (-1 / 480, 4)}
    for model, (coefficient, power) in known.items():
        law = error_law(model, SLOPES)
        assert (law.coefficient, law.power) == (pytest.approx(coefficient, rel=1e-12), power)
    assert error_law("modal:1", SLOPES).coefficient == pytest.approx(1 / 720 - 2 / (2 * math.pi) ** 4, rel=1e-10)
    with pytest.raises(SceneError):
        error_law("fd", SLOPES)
