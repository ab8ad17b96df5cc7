"""The exact one-port against independent forms: closed formulas, the wave's own boundary conditions, other evaluations."""

import numpy as np
import pytest
from one_port_scenes import EVERY, LAYERS, LOSSLESS, ROUND_TRIP, paper, scene_of, slab

from reduced.impedance import Jet, check_passivity, impedance, pair_ratio
from slipwave.scene.slab import (
    GripFace,
    KelvinVoigtViscosity,
    MachineFace,
    ReflectingFace,
    StandardLinearViscosity,
)
from tests.one_port_by_hand import pair_impedance

S = np.array([0.01 + 0.1j, 0.3 + 1j, 2.2j, -0.2 + 3j, 5 + 40j, 1e3 + 1j]) / ROUND_TRIP


VARIED = [
    slab(),
    slab(layers=LAYERS),
    slab(face=GripFace(2.0, 3.0)),
    slab(face=GripFace(0.5, 0.3), layers=LAYERS),
    slab(face=MachineFace(2.0, 0.5, 0.4), layers=LAYERS),
    slab(face=MachineFace(0.0, 0.0, 0.7)),
    slab(face=ReflectingFace(0.5), layers=LAYERS),
    slab(face=ReflectingFace(-1.0)),
    slab(viscosity=StandardLinearViscosity(3.0 * ROUND_TRIP, 0.5)),
    slab(viscosity=KelvinVoigtViscosity(0.05 * ROUND_TRIP), face=GripFace(2.0, 3.0), layers=LAYERS),
]


@pytest.mark.parametrize("scene", [*EVERY.values(), *map(scene_of, VARIED)], ids=[*EVERY, *map(str, range(len(VARIED)))])
def test_chained_sections_solve_the_wave_equation_in_both_slabs_in_series(scene):
    assert impedance(scene, S[:-1]) == pytest.approx([pair_impedance(scene, s) for s in S[:-1]], rel=1e-11)


def test_nothing_overflows_far_to_the_right():
    far = np.array([1e4, 1e8 + 1e8j, 1e300]) / ROUND_TRIP
    for scene in (paper(), EVERY["grip"], EVERY["layered"], EVERY["standard linear"]):
        assert np.all(np.isfinite(impedance(scene, far)))
        assert impedance(scene, far[2:]) == pytest.approx(scene.impedance, rel=1e-6)


def admittance(scene, s):
    p, q = pair_ratio(scene, Jet.variable(s))
    return p / q


@pytest.mark.parametrize("name", EVERY)
def test_slope_is_the_derivative(name):
    step = 1e-5 / ROUND_TRIP
    central = (admittance(EVERY[name], S[:5] + step).value - admittance(EVERY[name], S[:5] - step).value) / (2 * step)
    assert admittance(EVERY[name], S[:5]).slope == pytest.approx(central, rel=1e-6)


@pytest.mark.parametrize("name", EVERY)
def test_every_scene_is_passive(name):
    found = check_passivity(EVERY[name])
    assert found.passive, found
    assert (abs(found.worst) < 1e-9) == (name in LOSSLESS)
