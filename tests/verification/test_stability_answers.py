"""Answers on steady sliding: MODEL.md's impedance by hand, and count, roots and critical values of random scenes."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import slipwave
from reduced.parameters import scaled
from tests.one_port_by_hand import friction_impedance, pair_impedance

PLAIN = ["paper", "paper-2.3", "paper-si", "rock", "slip-law", "unlike", "unlike-irrational"]
SCENES = [*PLAIN, "grip", "layered", "machine", "reflection", "viscous"]


def smallest(scene, omega):
    """|H + Z|/|H| at the frequencies `omega`."""
    values = [
        (friction_impedance(scene, 1j * w) + pair_impedance(scene, 1j * w)) / friction_impedance(scene, 1j * w) for w in omega
    ]
    return np.abs(values)


@pytest.mark.parametrize("name", SCENES)
def test_critical_values_of_the_gallery_are_the_first_zeros_of_the_impedance_by_hand(name):
    """H + Z vanishes at i omega of the critical r and epsilon, and at no smaller r and no larger epsilon."""
    scene = slipwave.read(name)
    found = slipwave.stability(name).summary
    fine = scene.velocity * np.sqrt((scene.law.b - scene.law.a) / scene.law.a) * np.linspace(0.5, 1.05, 441)
    if found["log10_r_c"] is not None:
        at = scaled(scene, round_trip=10.0 ** found["log10_r_c"] / scene.transit)
        assert smallest(at, [found["omega_c"]])[0] < 1e-9
        for share in (0.5, 0.8, 0.95, 0.99):
            assert smallest(scaled(at, round_trip=share), fine).min() > 0.3 * (1.0 - share)
    else:
        assert name == "reflection"
    at = scaled(scene, epsilon=found["epsilon_c"] / scene.upper.epsilon)
    low = np.geomspace(1e-9, 1.0, 2001) * fine[-1]
    closest = low[np.argmin(smallest(at, low))]
    within = (0.99 * closest, 1.01 * closest)
    assert minimize_scalar(lambda w: smallest(at, [w])[0], bounds=within, method="bounded", options={"xatol": 1e-12}).fun < 1e-7
    for share in (1.01, 1.1, 2.0, 10.0, 1e3):
        assert smallest(scaled(at, epsilon=share), np.concatenate([fine, low])).min() > 0.3 * (1.0 - 1.0 / share)
