"""The integrator marches what the impedance says: a small nudge grows or decays as the root of H + Z = 0 does, Z by hand."""

import math

import pytest
from one_port_scenes import EVERY
from scipy.optimize import brentq

from reduced.impedance import reduction_of
from reduced.ode.march import ReducedModel
from reduced.stability import characteristic, critical_round_trip, leading_roots, scaled
from slipwave.solve import follow
from tests.one_port_by_hand import friction_impedance, leading_root, pair_impedance
from validation.measure.growth import measured_root, nudged


def kelvin_voigt(scene, s):
    """Both slabs' (2 eps/(s r))(1 + x/8)/(1 + x/24), x = (s r)^2, in series (11)."""
    squares = [(slab, (s * slab.round_trip) ** 2) for slab in (scene.upper, scene.lower)]
    return 1.0 / sum(s * slab.round_trip / (2.0 * slab.epsilon) * (1.0 + x / 24.0) / (1.0 + x / 8.0) for slab, x in squares)


def quasidynamic_on_grips(scene, s):
    """Slabs and grips' springs in series, and the radiation damping of two half spaces; alike slabs."""
    slab = scene.upper
    yielding = slab.round_trip / (2.0 * slab.epsilon) + slab.round_trip / (slab.face.stiffness * slab.epsilon)
    return 0.5 / (yielding * s) + 0.5 * slab.epsilon


# the Z that is wanted: the model's own formula, or the exact one, which fits and modes approach at low frequency
CASES = [
    ("plain", "kelvin-voigt", kelvin_voigt, 1e-5),
    ("ratio sqrt 2", "modal:3", pair_impedance, 1e-5),
    ("ratio 2", "kelvin-voigt", kelvin_voigt, 1e-4),
    ("layered", "modal:4", pair_impedance, 2e-4),
    ("grip", "quasidynamic", quasidynamic_on_grips, 1e-5),
    ("grip", "fitted:3", pair_impedance, 1e-5),
    ("matched grip", "fitted:2", pair_impedance, 1e-5),
    ("standard linear", "fitted:3", pair_impedance, 1e-5),
    ("kelvin-voigt solid", "fitted:3", pair_impedance, 1e-5),
]


@pytest.mark.parametrize(("name", "model", "impedance", "allowed"), CASES)
def test_a_nudge_grows_as_the_root_says(name, model, impedance, allowed):
    """Measured: 3e-7 to 9e-7; 7e-6 and 1.3e-5 where ripples outlast the first 60 transits."""
    r_c, _ = critical_round_trip(EVERY[name], model)
    scene = nudged(scaled(EVERY[name], round_trip=1.01 * r_c / EVERY[name].transit), 1e-6)
    root = leading_root(scene, lambda s: impedance(scene, s)) * scene.transit
    assert measured_root(ReducedModel(scene, reduction_of(scene, model), tolerance=1e-10)) == pytest.approx(root, rel=allowed)
    assert leading_roots(characteristic(scene, model))[0] * scene.transit == pytest.approx(root, rel=2e-6)


def test_without_a_spring_the_growth_is_real():
    scene = nudged(EVERY["reflection"], 1e-9)

    def total(rate):
        s = rate / scene.transit
        return (friction_impedance(scene, s) + pair_impedance(scene, s)).real

    root = brentq(total, 1e-3, 0.2, xtol=1e-14)
    solver = ReducedModel(scene, reduction_of(scene, "fitted:3"), tolerance=1e-10)
    at = [follow(solver, until).psi - scene.steady_psi for until in (60.0, 90.0)]
    assert math.log(at[1] / at[0]) / 30.0 == pytest.approx(root, rel=3e-6)
