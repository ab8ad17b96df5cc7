"""The closed forms against each other and against the reference programs."""

import math

import pytest

import slipwave
from validation.references.onset import onset_of
from validation.references.published import reference

LAW, EPSILON, V = slipwave.read("paper").law, 2.8e-5, 100.0
ONSET = onset_of(LAW, EPSILON, V)


def test_critical_values_at_the_papers_speed():
    known = reference()["hopf"]
    assert math.log10(ONSET.r_delay) == pytest.approx(known["delay"]["log10_r"], abs=2e-10)
    assert math.log10(ONSET.r_kelvin_voigt) == pytest.approx(known["kelvin-voigt"]["log10_r"], abs=2e-10)
    assert ONSET.omega_c * ONSET.r_delay == pytest.approx(known["delay"]["omega_per_transit"], rel=1e-8)


def test_quasidynamic_onset_is_a_root_of_its_characteristic_equation():
    r = ONSET.r_quasidynamic
    steady_slope = (LAW.a - LAW.b) / V
    middle = r * V * steady_slope + EPSILON + 0.5 * EPSILON * r * V
    assert middle == pytest.approx(0.0, abs=1e-12 * EPSILON)
    assert r > ONSET.r_delay
