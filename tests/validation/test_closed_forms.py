"""The closed forms against each other and against the reference programs."""

import math

import pytest

import slipwave
from validation.references.onset import Onset
from validation.references.published import reference


def onset(velocity=100.0):
    return Onset(slipwave.read("paper").law, 2.8e-5, velocity)


def test_critical_values_at_the_papers_speed():
    known = reference()["hopf"]
    assert math.log10(onset().r_delay) == pytest.approx(known["delay"]["log10_r"], abs=2e-10)
    assert math.log10(onset().r_kelvin_voigt) == pytest.approx(known["kelvin-voigt"]["log10_r"], abs=2e-10)
    assert onset().omega_c * onset().r_delay == pytest.approx(known["delay"]["omega_per_transit"], rel=1e-8)


def test_quasidynamic_onset_is_a_root_of_its_characteristic_equation():
    point = onset()
    r, v = point.r_quasidynamic, point.velocity
    rate_slope, healing, steady_slope = point.law.a / v, v, (point.law.a - point.law.b) / v
    quadratic = [
        r * (rate_slope + 0.5 * point.epsilon),
        r * healing * steady_slope + point.epsilon + 0.5 * point.epsilon * r * healing,
        point.epsilon * healing,
    ]
    assert quadratic[1] == pytest.approx(0.0, abs=1e-12 * point.epsilon)
    assert r > point.r_delay
