"""The study `bias`: places of its atlas, the rule that stored fits make; counterfeit figures turn it red (`shown.quick`)."""

import math

import numpy as np
import pytest
import xarray
from shown import quick

from slipwave.scene.slab import RigidFace
from validation.studies.bias.atlas import ALLOWED, Atlas
from validation.studies.bias.drawn import draw_atlas
from validation.studies.bias.measured import (
    MACHINES,
    MODELS,
    QUANTITIES,
    SWINGS,
    AtlasPoint,
    atlas_points,
    kappa_of,
    scene_of_point,
    stand_in,
)
from validation.study import Outcome


@pytest.mark.parametrize("mass", MACHINES)
def test_a_place_has_its_swing_its_stiffness_and_its_mass(mass: float | None) -> None:
    """The slowest swing: K - m w^2 = rho c w tan(w h/c); without a machine w h/c = pi/2."""
    scene = scene_of_point(AtlasPoint(0.3, 5.0, mass))
    slab = (scene.tables or {})["slab"]
    speed, rate = math.sqrt(slab["shear_modulus"] / slab["density"]), 2.0 * math.pi / 0.3
    angle = rate * slab["thickness"] / speed
    if mass is None:
        assert isinstance(scene.upper.face, RigidFace)
        assert angle == pytest.approx(0.5 * math.pi)
    else:
        face = slab["face"]
        assert face["mass"] == pytest.approx(mass * slab["density"] * slab["thickness"])
        left = face["stiffness"] - face["mass"] * rate**2
        assert left == pytest.approx(slab["density"] * speed * rate * math.tan(angle))
        assert face["stiffness"] * slab["thickness"] == pytest.approx(slab["shear_modulus"])
    alone = stand_in(scene)
    assert (kappa_of(scene), kappa_of(alone), alone.impedance) == pytest.approx((5.0, 5.0, scene.impedance))


def made(error: float, half: float) -> Atlas:
    """Fits whose errors of a, b and L are `error` times the swing; the heavier machine's are half as large, and that of the last
    place with it is not there."""
    columns, every = {}, atlas_points()
    for model in MODELS:
        for quantity in QUANTITIES:
            values = np.array([error * place.swing * (0.5 if place.mass == MACHINES[2] else 1.0) for place in every])
            values[-1] = math.nan
            columns |= {
                f"{model} error {quantity}": ("scene", -values),
                f"{model} half {quantity}": ("scene", 0.0 * values + half),
            }
    return Atlas(xarray.Dataset(columns))


def test_the_rule_lies_where_the_largest_error_is_one_per_cent() -> None:
    atlas = made(0.2, 0.03)
    limits = atlas.limits("quasidynamic")
    np.testing.assert_allclose(limits, np.array([[0.05], [0.05], [0.1]]) * np.ones_like(limits))
    assert atlas.rule("block8") == pytest.approx(ALLOWED / 0.2)
    assert made(20.0, 1.0).rule("block8") == SWINGS[0]
    assert atlas.excluded("block8").any(axis=2).tolist()[0] == (0.2 * SWINGS > 0.03).tolist()
    assert atlas.fits == len(MODELS) * (len(atlas_points()) - 1)
    assert np.isinf(atlas.worst("block8", False)[-1, -1, -1])


def test_the_figure_shows_the_worst_error_of_each_machine() -> None:
    panels = draw_atlas(made(0.2, 0.03)).axes
    assert len(panels) == len(MODELS) + 1
    np.testing.assert_allclose(panels[0].get_lines()[0].get_ydata(), np.clip(20.0 * SWINGS, 0.01, 1000.0))


@pytest.mark.slow
def test_waves_left_out_bias_a_quasi_dynamic_fit_most() -> None:
    result = quick("bias")
    assert [verdict.claim for verdict in result.verdicts if verdict.outcome is not Outcome.PASS] == []
    limits = {name.removesuffix(" swing with 1 %"): number.value for name, number in result.numbers.items()}
    assert limits["quasidynamic"] < limits["quasistatic"]
    assert [row[0] for row in result.tables[2].rows] == ["delay", *(name for name in limits if name != "one mass")]
