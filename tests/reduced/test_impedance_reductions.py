"""Reductions as impedances: against the exact one-port, against their own closed forms, and passive."""

import math

import numpy as np
import pytest
from one_port_scenes import EPSILON, EVERY, LOSSLESS, LOSSY, ROUND_TRIP, paper

from reduced.impedance import check_passivity, impedance, poles_and_residues, taylor_poles
from reduced.impedance.reduce import reduction_of, spring_and_mass
from slipwave.errors import SceneError
from tests.one_port_by_hand import pair_impedance

T = np.array([0.01 + 0.3j, 0.2 + 1j, 2.0j, 3 + 9j])
CLOSED = {
    "quasistatic": lambda s: 1 / s,
    "quasidynamic": lambda s: 1 / s + 0.5,
    "block12": lambda s: (1 + s**2 / 12) / s,
    "block8": lambda s: (1 + s**2 / 8) / s,
    "kelvin-voigt": lambda s: (1 + s**2 / 8) / (1 + s**2 / 24) / s,
    "taylor": lambda s: (1 + s**2 / 8 + s**4 / 384) / (1 + s**2 / 24 + s**4 / 1920) / s,
    "modal:2": lambda s: (
        1 / s
        + sum(2 * s / (s**2 + (2 * np.pi * k) ** 2) for k in (1, 2))
        + s * (1 / 12 - sum(2 / (2 * np.pi * k) ** 2 for k in (1, 2)))
    ),
}


@pytest.mark.parametrize("model", CLOSED)
def test_closed_forms_of_the_alike_pair(model):
    assert impedance(paper(), T / ROUND_TRIP, model) == pytest.approx(EPSILON * CLOSED[model](T), rel=1e-13)


@pytest.mark.parametrize("name", LOSSLESS)
def test_modal_converges_to_the_exact_pair(name):
    s = np.array([0.05j, 0.3 + 0.5j, 1.1j, 0.5 + 3j]) / ROUND_TRIP
    exact = impedance(LOSSLESS[name], s)
    errors = [np.max(np.abs(impedance(LOSSLESS[name], s, f"modal:{n}") / exact - 1)) for n in (4, 16, 64)]
    assert errors[0] < 0.05
    assert errors[1] < errors[0] / 8
    assert errors[2] < min(errors[1] / 8, 3e-4)


@pytest.mark.parametrize("name", LOSSLESS)
@pytest.mark.parametrize("model", ["block12", "modal:0", "modal:3", "modal:20"])
def test_spring_and_mass_survive_truncation(name, model):
    """Z = spring/s + mass s at low frequency: exact in every modal reduction and in block12."""
    scene = LOSSLESS[name]
    reduced = reduction_of(scene, model)
    total = reduced.mass + sum(c / w**2 for c, w in zip(reduced.residues, reduced.frequencies, strict=True))
    spring, mass = spring_and_mass(scene)
    omega = 1e-2
    low = impedance(scene, 1j * omega / scene.transit).imag / scene.upper.epsilon
    assert (reduced.spring, total) == pytest.approx((spring, mass), rel=1e-12)
    assert -spring / omega + mass * omega == pytest.approx(low, rel=1e-9)


@pytest.mark.parametrize("name", ["ratio 2", "ratio sqrt 2", "same time"])
def test_closed_forms_of_unlike_slabs_in_series(name):
    """With k_i = 2 eps_i/r_i a slab's stiffness and K that of both: kelvin-voigt takes both slabs' own (11) in series, the others
    K/s and both slabs' radiation, or the mass K^2 sum(r_i^2/(N k_i)), which is seen at low frequency."""
    scene = LOSSLESS[name]
    epsilon, r = np.array([(slab.epsilon, slab.round_trip) for slab in (scene.upper, scene.lower)]).T
    s, k = T / scene.transit, 2 * epsilon / r
    stiffness, x = 1 / np.sum(1 / k), np.multiply.outer(s, r)
    wanted = {
        "kelvin-voigt": 1 / np.sum(x / (2 * epsilon) * (1 + x**2 / 24) / (1 + x**2 / 8), axis=1),
        "quasidynamic": stiffness / s + 1 / np.sum(1 / epsilon),
    }
    wanted |= {f"block{n}": stiffness / s + stiffness**2 * np.sum(r**2 / (n * k)) * s for n in (8, 12)}
    for model, values in wanted.items():
        assert impedance(scene, s, model) == pytest.approx(values, rel=1e-12), model


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize(
    "model", ["quasidynamic", "block12", "block8", "kelvin-voigt", "modal:5", "fitted:1", "fitted:3", "fitted:8"]
)
def test_every_reduction_that_is_offered_is_passive(name, model):
    offered = name in LOSSLESS or model.startswith("fitted") or (model == "quasidynamic" and name != "reflection")
    if model in ("block8", "kelvin-voigt") and name == "layered":
        offered = False
    if offered:
        found = check_passivity(EVERY[name], model)
        assert found.passive, found
    else:
        with pytest.raises(SceneError, match="fitted:N"):
            check_passivity(EVERY[name], model)


@pytest.mark.parametrize("count", [1, 3, 8])
def test_a_fit_has_as_many_oscillators_as_its_name_says(count):
    """Where the slabs ring: heavier losses turn two real poles into one oscillator more."""
    assert sum(frequency > 0.0 for frequency in reduction_of(LOSSY["grip"], f"fitted:{count}").frequencies) == count


def test_the_next_taylor_truncation_has_unstable_poles():
    assert sorted(taylor_poles().real > 1.0) == [False, False, False, True, True]
    found = check_passivity(paper(), "taylor")
    assert not found.passive
    assert len(found.unstable_poles) == 2


def test_residues_rebuild_the_impedance():
    reduced = reduction_of(LOSSY["grip"], "fitted:3")
    poles, residues = poles_and_residues(reduced)
    z = reduced.mass * T + reduced.damping + (residues / (T[:, None] - poles)).sum(axis=1)
    assert EPSILON * z == pytest.approx(impedance(LOSSY["grip"], T / ROUND_TRIP, "fitted:3"), rel=1e-11)


def test_a_spring_where_there_is_none_is_refused():
    with pytest.raises(SceneError, match="cannot do an outer face without a spring"):
        reduction_of(LOSSY["reflection"], "quasistatic")
    assert math.isclose(reduction_of(EVERY["standard linear"], "quasistatic").spring, 1 / 1.5)


@pytest.mark.parametrize("name", LOSSY)
@pytest.mark.parametrize(("count", "allowed"), [(1, 2e-2), (4, 1e-3), (9, 3e-5)])
def test_fits_below_half_the_first_mode_against_impedances_by_hand(name, count, allowed):
    """Relative to |Z| + epsilon; measured: 1.5e-3, 1.1e-4, 2.3e-6. The spring is the quasi-static one."""
    scene = LOSSY[name]
    longest = max(scene.upper.round_trip, scene.lower.round_trip)
    s = 1j * np.geomspace(0.02, np.pi, 300) / longest
    exact = np.array([pair_impedance(scene, point) for point in s])
    error = np.abs(impedance(scene, s, f"fitted:{count}") - exact) / (EPSILON + np.abs(exact))
    assert error.max() < allowed
    slow = 1e-4j / longest
    assert impedance(scene, slow, f"fitted:{count}") == pytest.approx(pair_impedance(scene, slow), rel=2e-5)


@pytest.mark.parametrize(("share", "refused"), [(0.045, False), (-0.045, False), (0.056, True), (-0.056, True)])
def test_a_fit_that_is_too_far_off_is_refused_with_place_and_size(monkeypatch, share, refused):
    """A good fit is spoiled by a share of its impedance: at 0.02 radians per transit |Z| is 33 epsilon, 33/34 of it count."""
    from reduced.impedance import fit

    def spoiled(model, epsilon, transit, s):
        p, q = ratio(model, epsilon, transit, s)
        return p, q * (1.0 + share)

    ratio = fit.reduction_ratio
    monkeypatch.setattr(fit, "reduction_ratio", spoiled)
    scene = LOSSY["standard linear"]
    fit.fit_scene.cache_clear()
    if refused:
        with pytest.raises(
            SceneError, match=r"'fitted:3': the best passive fit is 5\.4 % off at 0\.02 radians .* try a larger N"
        ):
            fit.fit_scene(scene, "fitted:3", 3, 2.0 / 3.0)
    else:
        assert fit.fit_scene(scene, "fitted:3", 3, 2.0 / 3.0).spring == 2.0 / 3.0
    fit.fit_scene.cache_clear()
