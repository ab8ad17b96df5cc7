"""Critical thickness and normal stress of scenes in SI: by hand, and by reading the scene again with that thickness or stress."""

import math

import pytest

import slipwave
from reduced.stability import analyse
from reduced.stability.physical import in_si, thickened
from slipwave.scene import Scene
from tests.granite import GRANITE

MACHINE = GRANITE | {
    "slab": GRANITE["slab"] | {"thickness": 0.2, "face": {"kind": "machine", "stiffness": 1.6e9, "impedance": 2e6, "mass": 400.0}}
}
OTHER = {"density": 1190.0, "shear_modulus": 2e9, "thickness": 0.4}
UNLIKE = {key: value for key, value in GRANITE.items() if key != "slab"} | {"upper": GRANITE["slab"], "lower": OTHER}
VISCOUS = GRANITE | {"slab": GRANITE["slab"] | {"viscosity": {"kind": "kelvin-voigt", "time": 1e-6}}}


def leading(scene: Scene) -> float:
    """Real part of the leading root over its frequency."""
    root = analyse(scene).leading_roots[0]
    return root.real / abs(root.imag)


def test_granite_by_hand() -> None:
    """Quasi-static spring G/(2 h) of two slabs h thick: stable if it is above (b - a) sigma/L, so h_c = G L/(2 sigma (b - a)),
    and inertia changes that by less than 1e-7 here; sigma_c = G L/(2 h (b - a)). Roots of the spring-slider at h = 10 m:
    a s^2 + (a + k - b) s + k = 0 in units of V/L with k = G L/(2 h sigma) = 0.003: s = 0.1 +- i sqrt(0.3 - 0.01)."""
    scene = slipwave.read(GRANITE)
    found = in_si(scene, analyse(scene))
    assert found is not None
    assert found.thickness == pytest.approx(10.0, rel=1e-12)
    assert found.critical_thickness == pytest.approx(30e9 * 1e-5 / (2.0 * 5e6 * 0.005), rel=1e-6)
    assert found.critical_normal_stress == pytest.approx(30e9 * 1e-5 / (2.0 * 10.0 * 0.005), rel=1e-6)
    assert found.growth_time == pytest.approx(10.0 / 0.1, rel=1e-5)
    assert found.frequency == pytest.approx(math.sqrt(0.29) / (2.0 * math.pi * 10.0), rel=1e-5)


def test_a_stable_sample_would_slip_beyond_six_metres_or_150_megapascal() -> None:
    scene = slipwave.read(GRANITE, ["slab.thickness=0.2"])
    found = in_si(scene, analyse(scene))
    assert found is not None
    assert (found.critical_thickness, found.critical_normal_stress) == (
        pytest.approx(6.0, rel=1e-6),
        pytest.approx(150e6, rel=1e-6),
    )
    assert found.growth_time < 0.0
    assert found.frequency == 0.0


@pytest.mark.parametrize("tables", [GRANITE, MACHINE, UNLIKE, VISCOUS], ids=["granite", "machine", "unlike", "viscous"])
def test_the_scene_read_again_at_its_critical_values_is_neutral(tables: dict) -> None:
    scene = slipwave.read(tables)
    found = in_si(scene, analyse(scene))
    assert found is not None
    assert abs(leading(scene)) > 1e-3
    stressed = slipwave.read(tables, [f"interface.normal_stress={found.critical_normal_stress!r}"])
    assert abs(leading(stressed)) < 1e-8
    if math.isfinite(found.critical_thickness):
        factor = found.critical_thickness / found.thickness
        keys = ("upper", "lower") if "upper" in tables else ("slab",)
        thick = slipwave.read(tables, [f"{key}.thickness={tables[key]['thickness'] * factor!r}" for key in keys])
        assert abs(leading(thick)) < 1e-8


def test_a_thicker_slab_keeps_its_machine() -> None:
    """What the scene would be if it were read with that thickness: the machine is given per area, in SI."""
    thick = thickened(slipwave.read(MACHINE), 3.0).upper
    again = slipwave.read(MACHINE, [f"slab.thickness={0.6!r}"]).upper
    assert thick.round_trip == pytest.approx(again.round_trip, rel=1e-12)
    for name in ("stiffness", "impedance", "mass"):
        assert getattr(thick.face, name) == pytest.approx(getattr(again.face, name), rel=1e-12)


def test_no_units_no_thickness_and_no_weakening() -> None:
    paper = slipwave.read("paper")
    assert in_si(paper, analyse(paper)) is None
    bare = slipwave.read(GRANITE, {"slab": {"epsilon": 1.8e-6, "r": 6e-4}})
    found = in_si(bare, analyse(bare))
    assert found is not None
    assert math.isnan(found.thickness)
    assert math.isnan(found.critical_thickness)
    strengthening = slipwave.read(MACHINE, ["interface.b=0.005"])
    values = in_si(strengthening, analyse(strengthening))
    assert values is not None
    assert math.isnan(values.critical_thickness)
    assert math.isnan(values.critical_normal_stress)
