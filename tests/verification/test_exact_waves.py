"""Every method-of-lines family against exact waves: interface, outer faces, layers, standing waves, viscous slabs."""

from functools import partial

import numpy as np
import pytest
import scipy.linalg
from exact_waves import EPSILON, LOCKED, SLAB, fields, pulse, rate_scene, reflection_error, send, squared, step_to, tiling

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, ReflectingFace, StandardLinearViscosity

FAMILIES = {
    "dg:7": partial(DiscontinuousGalerkin, number=7, cells=16, time="explicit"),
    "dg:3": partial(DiscontinuousGalerkin, number=3, cells=64, time="explicit"),
    "fem:5": partial(FiniteElement, number=5, cells=32, time="explicit"),
    "fem:2 consistent": partial(FiniteElement, number=2, cells=128, mass="consistent", time="explicit"),
    "sbp:6": partial(SummationByParts, number=6, cells=192, time="explicit"),
    "sbp:4": partial(SummationByParts, number=4, cells=256, time="explicit"),
}
EVERY = pytest.mark.parametrize("family", FAMILIES)
VISCOSITIES = [KelvinVoigtViscosity(0.003 * SLAB.round_trip), StandardLinearViscosity(0.3 * SLAB.round_trip, 0.5)]
LAMINATED = tuple(name for name in FAMILIES if "consistent" not in name)


@EVERY
def test_pulse_reflected_by_nonlinear_friction(family):
    """What comes back from F = a ln v is known pointwise; a = 0.01 = Z V, so it is partly swallowed and much distorted."""
    error = reflection_error(FAMILIES[family], 0.01, 0.3)
    assert error < 3e-5


@EVERY
@pytest.mark.parametrize("reflection", [1.0, 0.5, 0.0, -1.0])
def test_pulse_at_the_outer_face(family, reflection):
    """It comes back as -R times itself; a matched face (R = 0) swallows it whole."""
    solver = tiling(FAMILIES[family], rate_scene(LOCKED, {"face": ReflectingFace(reflection)}), 0.5)
    send(solver, pulse, +1)
    step_to(solver, 0.5)
    x, w, s, norm = fields(solver)
    error = np.sqrt(squared(norm, w + reflection * pulse(x), s + reflection * pulse(x)))
    assert error < 2e-4


@EVERY
def test_matched_grip_swallows_a_pulse_but_keeps_the_load(family):
    """Z_g = eps with a soft spring: what little comes back is the spring's, of relative size K over the pulse's frequency."""
    solver = tiling(FAMILIES[family], rate_scene(LOCKED, {"face": GripFace(1e-4, 1.0)}), 0.5)
    send(solver, pulse, +1)
    step_to(solver, 0.5)
    _, w, s, norm = fields(solver)
    assert np.sqrt(squared(norm, w, s)) < 2e-4


@EVERY
def test_echo_of_a_layer(family):
    """Behind the jump of impedance by k: (1 - k)/(1 + k) of the velocity comes back, 2/(1 + k) goes on, with k-fold stress."""
    ratio = 3.0
    layered = {"layers": (Layer(0.5, 1.0), Layer(0.5, ratio))}
    solver = tiling(FAMILIES[family], rate_scene(LOCKED, layered), 0.23)
    send(solver, lambda x: pulse(x, 0.125, 0.02) * (x <= 0.25), +1)
    step_to(solver, 0.23)  # the pulse's middle would be at 0.355: echo at 0.145
    x, w, s, norm = fields(solver)
    echo, passed = (1.0 - ratio) / (1.0 + ratio) * pulse(x, 0.145, 0.02), 2.0 / (1.0 + ratio) * pulse(x, 0.355, 0.02)
    near = x < 0.25
    exact_w, exact_s = np.where(near, echo, passed), np.where(near, echo, -passed)
    assert np.sqrt(squared(norm, w - exact_w, s - exact_s)) < 1e-3


@EVERY
def test_pulse_passes_into_an_unlike_slab(family):
    """An interface whose slip rate no wave changes is a weld: reflection and transmission are those of a layer."""
    ratio = 3.0
    unlike = {"epsilon": ratio * EPSILON, "round_trip": 2.0 * SLAB.round_trip}
    solver = tiling(FAMILIES[family], rate_scene(LOCKED, {}, unlike), 0.5)
    send(solver, lambda x: pulse(x, 0.25, 0.04), -1)
    step_to(solver, 0.5)
    for slab, share in ((0, (1.0 - ratio) / (1.0 + ratio)), (1, -2.0 / (1.0 + ratio))):
        x, w, s, norm = fields(solver, slab)
        exact = share * pulse(x, 0.25, 0.04)
        error = np.sqrt(squared(norm, w - exact, s + exact))
        assert error < 2e-4


@pytest.mark.parametrize("family", LAMINATED)
@pytest.mark.parametrize("viscosity", VISCOSITIES)
def test_viscous_standing_wave_decays_as_the_dispersion_relation_says(family, viscosity):
    """Mode sin(k x) of a slab locked at one end and rigid at the other: amplitudes of w, s (and the memory stress) obey an ODE
    whose eigenvalues are the roots of s^2 + k^2 G(s)/G = 0: decay rate and phase speed."""
    waves, time = 2, 1.0
    k = 2.0 * np.pi * waves
    solver = tiling(FAMILIES[family], rate_scene(LOCKED, {"viscosity": viscosity}), time)
    solver.impose(0, lambda x: 0.5 + np.sin(k * x), lambda x: 0.0 * x)
    step_to(solver, time)
    if isinstance(viscosity, KelvinVoigtViscosity):
        tau = viscosity.time / SLAB.round_trip
        modal = np.array([[-tau * k * k, -k], [k, 0.0]])
        roots = np.roots([1.0, tau * k * k, k * k])
    else:
        rate, fraction = SLAB.round_trip / viscosity.time, viscosity.ratio / (1.0 + viscosity.ratio)
        modal = np.array([[0.0, -k, 0.0], [k, 0.0, -rate], [fraction * k, 0.0, -rate]])
        roots = np.roots([1.0, rate, k * k, k * k * rate * (1.0 - fraction)])
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(modal)), np.sort_complex(roots), rtol=1e-10)
    amplitude = scipy.linalg.expm(modal * time)[:, 0]
    x, w, s, norm = fields(solver)
    assert 0.05 < np.abs(amplitude[:2]).max() < 0.9
    error = np.sqrt(squared(norm, w - amplitude[0] * np.sin(k * x), s - amplitude[1] * np.cos(k * x)))
    assert error < 2e-5
