"""Critical thickness and normal stress of scenes in SI: by hand, and by reading the scene again with that thickness or stress."""

import math

import numpy as np
import pytest

import slipwave
from reduced.stability import analyse, characteristic, scaled, spectrum, unstable_count
from reduced.stability.analyse import stability_in_si, thickened
from tests.granite import GRANITE

MACHINE = GRANITE | {
    "slab": GRANITE["slab"] | {"thickness": 0.2, "face": {"kind": "machine", "stiffness": 1.6e9, "impedance": 2e6, "mass": 400.0}}
}
OTHER = {"density": 1190.0, "shear_modulus": 2e9, "thickness": 0.4}
UNLIKE = {key: value for key, value in GRANITE.items() if key != "slab"} | {"upper": GRANITE["slab"], "lower": OTHER}
VISCOUS = GRANITE | {"slab": GRANITE["slab"] | {"viscosity": {"kind": "kelvin-voigt", "time": 1e-6}}}


def leading(scene):
    """Real part of the leading root over its frequency."""
    root = analyse(scene).leading_roots[0]
    return root.real / abs(root.imag)


def test_granite_by_hand():
    """Quasi-static spring G/(2 h) of two slabs h thick: stable if it is above (b - a) sigma/L, so h_c = G L/(2 sigma (b - a)),
    and inertia changes that by less than 1e-7 here; sigma_c = G L/(2 h (b - a)). Roots of the spring-slider at h = 10 m:
    a s^2 + (a + k - b) s + k = 0 in units of V/L with k = G L/(2 h sigma) = 0.003: s = 0.1 +- i sqrt(0.3 - 0.01)."""
    scene = slipwave.read(GRANITE)
    found = stability_in_si(scene, analyse(scene))
    assert found.thickness == pytest.approx(10.0, rel=1e-12)
    assert found.critical_thickness == pytest.approx(30e9 * 1e-5 / (2.0 * 5e6 * 0.005), rel=1e-6)
    assert found.critical_normal_stress == pytest.approx(30e9 * 1e-5 / (2.0 * 10.0 * 0.005), rel=1e-6)
    assert found.growth_time == pytest.approx(10.0 / 0.1, rel=1e-5)
    assert math.isnan(found.decay_time)
    assert found.frequency == pytest.approx(math.sqrt(0.29) / (2.0 * math.pi * 10.0), rel=1e-5)


@pytest.mark.parametrize("tables", [GRANITE, MACHINE, UNLIKE, VISCOUS], ids=["granite", "machine", "unlike", "viscous"])
def test_the_scene_read_again_at_its_critical_values_is_neutral(tables):
    scene = slipwave.read(tables)
    found = stability_in_si(scene, analyse(scene))
    assert abs(leading(scene)) > 1e-3
    stressed = slipwave.read(tables, [f"interface.normal_stress={found.critical_normal_stress!r}"])
    assert abs(leading(stressed)) < 1e-8
    if math.isfinite(found.critical_thickness):
        factor = found.critical_thickness / found.thickness
        keys = ("upper", "lower") if "upper" in tables else ("slab",)
        thick = slipwave.read(tables, [f"{key}.thickness={tables[key]['thickness'] * factor!r}" for key in keys])
        assert abs(leading(thick)) < 1e-8


def test_a_thicker_slab_keeps_its_machine():
    """What the scene would be if it were read with that thickness: the machine is given per area, in SI."""
    thick = thickened(slipwave.read(MACHINE), 3.0).upper
    again = slipwave.read(MACHINE, [f"slab.thickness={0.6!r}"]).upper
    assert thick.round_trip == pytest.approx(again.round_trip, rel=1e-12)
    for name in ("stiffness", "impedance", "mass"):
        assert getattr(thick.face, name) == pytest.approx(getattr(again.face, name), rel=1e-12)


def test_no_units_no_thickness_and_no_weakening():
    paper = slipwave.read("paper")
    assert stability_in_si(paper, analyse(paper)) is None
    bare = slipwave.read(GRANITE, {"slab": {"epsilon": 1.8e-6, "r": 6e-4}})
    found = stability_in_si(bare, analyse(bare))
    assert math.isnan(found.thickness)
    assert math.isnan(found.critical_thickness)
    strengthening = slipwave.read(MACHINE, ["interface.b=0.005"])
    values = stability_in_si(strengthening, analyse(strengthening))
    assert math.isnan(values.critical_thickness)
    assert math.isnan(values.critical_normal_stress)


FAST = GRANITE | {
    "slab": {
        "density": 2700.0,
        "shear_modulus": 30e9,
        "thickness": 1.0,
        "face": {"kind": "machine", "stiffness": 1e11, "impedance": 1e6, "mass": 400.0},
    },
}


def fast(velocity, thickness=1.0):
    return slipwave.read(FAST, [f"drive.velocity='{velocity!r} m/s'", f"slab.thickness={thickness!r}"])


@pytest.mark.parametrize(
    ("velocity", "model", "thickness", "stress"),
    [
        (10.0, "delay", 6.363672418, 5011556.958),
        pytest.param(10.0, "fitted:4", 6.364458, 20437217.7, marks=pytest.mark.slow),
        (0.01, "quasistatic", 5.7, 5e6 * 60.0 / 13.0),
        (1.0, "quasidynamic", None, 923076923.0),
    ],
)
def test_fast_sliding_on_a_machine_loses_stability_where_roots_begin_to_grow(velocity, model, thickness, stress):
    """Quasi-static: of both slabs 1/k = 2 (h/G + 1/k_machine) = 2 (h/30e9 + 1e-11) is L/((b - a) sigma); other values measured.
    Quasi-dynamic slabs of any thickness are stable there."""
    scene = fast(velocity)
    values = stability_in_si(scene, analyse(scene, model))
    assert values.missing == ()
    assert values.critical_normal_stress == pytest.approx(stress, rel=1e-6)
    if thickness is None:
        assert math.isnan(values.critical_thickness)
    else:
        assert values.critical_thickness == pytest.approx(thickness, rel=1e-6)
    for side in (0.999, 1.001):
        changed = [scaled(scene, epsilon=5e6 / (values.critical_normal_stress * side))]
        changed += [thickened(scene, values.critical_thickness * side)] if thickness else []
        assert [unstable_count(characteristic(one, model)) > 0 for one in changed] == [side > 1.0] * len(changed)


def test_a_growing_pair_beside_hundreds_of_slow_decaying_ones_is_unstable():
    """Fast roots decay at 0.0023 there, a slow pair grows at 0.793: none is neutral."""
    scene = fast(10.0, 8.0)
    assert spectrum(scene).stable is False
    found = analyse(scene)
    assert (found.stable, found.unstable_roots) == (False, 2)
    assert found.leading_roots[0] == pytest.approx(0.7928570494 + 6308.306341j, rel=1e-8)
    assert found.leading_roots[2].real == pytest.approx(-0.002303594, rel=1e-5)
    values = stability_in_si(scene, found)
    assert values.critical_normal_stress == pytest.approx(3223113.77, rel=1e-6)
    assert values.growth_time == pytest.approx(10.0 / 0.7928570494, rel=1e-8)


def test_all_roots_decay_within_a_transit():
    """Quasi-static at 1 m/s: two roots, -0.9e6 +- 1.2e6 i, decay 54 times in a transit."""
    found = analyse(fast(1.0), "quasistatic")
    k = 1.0 / (2.0 * (1.0 / 30e9 + 1e-11)) * 1e-5 / 5e6 * 1e6
    a, gap, rate = 0.01, 0.005, 1e6
    roots = np.roots([a / rate, (k / rate - gap), k])
    assert found.stable is True
    assert found.leading_roots[0] == pytest.approx(roots[np.argmax(roots.imag)], rel=1e-9)
