"""The exact one-port against independent forms: closed formulas, the wave's own boundary conditions, other evaluations."""

import numpy as np
import pytest
from one_port_scenes import EPSILON, EVERY, LAYERS, LOSSLESS, ROUND_TRIP, paper, slab

from reduced.impedance import Jet, check_passivity, impedance, pair_ratio, slab_ratio
from slipwave.scene.slab import (
    GripFace,
    KelvinVoigtViscosity,
    Layer,
    MachineFace,
    ReflectingFace,
    RigidFace,
    Slab,
    StandardLinearViscosity,
)
from tests.one_port_by_hand import modulus, pair_impedance

S = np.array([0.01 + 0.1j, 0.3 + 1j, 2.2j, -0.2 + 3j, 5 + 40j, 1e3 + 1j]) / ROUND_TRIP


def one_slab(slab, s):
    p, q = slab_ratio(slab, Jet.variable(s))
    return q.value / p.value


def by_boundary_conditions(slab, s):
    """Z of a slab from the Helmholtz equation: u = A e^kx + B e^-kx in every layer, matched in displacement and stress, solved as
    one linear system. Depth x is measured in one-way travel time, so G u_x = (impedance g) u_x and k = s/sqrt(g)."""
    g = modulus(slab, s)
    k, n = s / np.sqrt(g), len(slab.layers)
    edges = np.concatenate([[0.0], np.cumsum([0.5 * slab.round_trip * layer.fraction for layer in slab.layers])])
    stress = [slab.epsilon * layer.impedance * g * k for layer in slab.layers]
    matrix, right = np.zeros((2 * n, 2 * n), complex), np.zeros(2 * n, complex)

    def wave(layer, x, sign):
        row = np.zeros(2 * n, complex)
        row[2 * layer], row[2 * layer + 1] = np.exp(k * (x - edges[layer])), sign * np.exp(-k * (x - edges[layer]))
        return row

    matrix[0], right[0] = wave(0, 0.0, 1), 1.0 / s  # unit velocity at the interface
    for i in range(n - 1):
        matrix[2 * i + 1] = wave(i, edges[i + 1], 1) - wave(i + 1, edges[i + 1], 1)
        matrix[2 * i + 2] = stress[i] * wave(i, edges[i + 1], -1) - stress[i + 1] * wave(i + 1, edges[i + 1], -1)
    pull, velocity = stress[-1] * wave(n - 1, edges[-1], -1), s * wave(n - 1, edges[-1], 1)
    match slab.face:
        case RigidFace():
            matrix[-1] = velocity
        case GripFace(stiffness, damper):
            matrix[-1] = pull + (damper * slab.epsilon + stiffness * slab.epsilon / (slab.round_trip * s)) * velocity
        case MachineFace(stiffness, damper, mass):
            per_velocity = damper + stiffness / (slab.round_trip * s) + mass * slab.round_trip * s
            matrix[-1] = pull + slab.epsilon * per_velocity * velocity
        case ReflectingFace(coefficient):
            top = slab.epsilon * slab.layers[-1].impedance
            matrix[-1] = (1 - coefficient) * pull + (1 + coefficient) * top * velocity
    x = np.linalg.solve(matrix, right)
    return -stress[0] * (x[0] - x[1])


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


@pytest.mark.parametrize("slab", VARIED)
def test_chained_sections_solve_the_wave_equation(slab):
    for s in S[:-1]:
        assert one_slab(slab, s) == pytest.approx(by_boundary_conditions(slab, s), rel=1e-11)


@pytest.mark.parametrize("name", EVERY)
def test_both_slabs_are_in_series_in_every_scene(name):
    assert impedance(EVERY[name], S[:-1]) == pytest.approx([pair_impedance(EVERY[name], s) for s in S[:-1]], rel=1e-11)


def test_viscous_loss_per_cycle_at_the_relaxation_frequency():
    """At omega = 1/time the memory stress of a Zener solid lags by 45 degrees: g = (1 + (1 + i)/4)/1.5 for ratio 1/2; a
    Kelvin-Voigt solid has g = 1 + i there. Z of a thin slab is G/(H s)."""
    thin = 1e-6
    for time, viscosity, g in (
        (2.0, StandardLinearViscosity(2.0, 0.5), (1.25 + 0.25j) / 1.5),
        (2.0, KelvinVoigtViscosity(2.0), 1.0 + 1.0j),
    ):
        s = 1j / time
        found = one_slab(Slab(EPSILON, thin, viscosity=viscosity), s)
        assert found * s * thin / (2.0 * EPSILON) == pytest.approx(g, rel=1e-11)


def test_plain_pair_is_half_a_coth():
    assert impedance(paper(), S) == pytest.approx(0.5 * EPSILON / np.tanh(0.5 * S * ROUND_TRIP), rel=1e-13)


def test_nothing_overflows_far_to_the_right():
    far = np.array([1e4, 1e8 + 1e8j, 1e300]) / ROUND_TRIP
    for scene in (paper(), EVERY["grip"], EVERY["layered"], EVERY["standard linear"]):
        assert np.all(np.isfinite(impedance(scene, far)))
        assert impedance(scene, far[2:]) == pytest.approx(scene.impedance, rel=1e-6)


def test_faces_tend_to_each_other():
    rigid = one_slab(slab(), S)
    assert one_slab(slab(face=GripFace(1.0, 1e9)), S) == pytest.approx(rigid, rel=1e-7)
    assert one_slab(slab(face=ReflectingFace(1.0)), S) == pytest.approx(rigid, rel=1e-13)
    assert one_slab(slab(face=ReflectingFace(0.0)), S) == pytest.approx(np.full(S.shape, EPSILON + 0j), rel=1e-13)
    soft = slab(viscosity=StandardLinearViscosity(1e-12 * ROUND_TRIP, 0.5))
    relaxed = Slab(EPSILON / np.sqrt(1.5), ROUND_TRIP * np.sqrt(1.5))
    assert one_slab(soft, S[:3]) == pytest.approx(one_slab(relaxed, S[:3]), rel=1e-9)


def test_a_slab_cut_into_equal_layers_is_the_same_slab():
    cut = slab(layers=(Layer(0.2, 1.0), Layer(0.5, 1.0), Layer(0.3, 1.0)))
    assert one_slab(cut, S) == pytest.approx(one_slab(slab(), S), rel=1e-12)


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
