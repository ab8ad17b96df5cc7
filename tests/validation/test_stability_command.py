from functools import cache

import pytest

import slipwave


@cache
def critical(scene, model):
    """r at which steady sliding is neutral."""
    return float(10.0 ** slipwave.stability(scene, model).summary["log10_r_c"])


@pytest.mark.parametrize("share", [1e-9, -1e-9, 0.0])
@pytest.mark.parametrize("scene", ["paper", "unlike", "grip", "viscous", "slip-law", "layered"])
@pytest.mark.parametrize("model", ["delay", "quasidynamic", "fitted:3"])
def test_a_root_on_the_axis_is_neutral_and_no_verdict(answer, scene, model, share):
    r_c = critical(scene, model)
    table = "upper" if scene.startswith("unlike") else "slab"
    ratio = 2.0 if table == "upper" else 1.0
    settings = [f"{table}.r={r_c * (1.0 + share):.17g}"] + (
        [f"lower.r={ratio * r_c * (1.0 + share):.17g}"] if ratio > 1.0 else []
    )
    words = [scene, "--model", model, *(word for setting in settings for word in ("--set", setting))]
    found = answer("stability", *words)
    assert abs(found["leading_roots"][0][0]) < 1e-9 * 1e3 * found["omega_c"]
    assert found["stable"] is None
    assert found["unstable_roots"] == 0
    assert ["neutral within rounding" in note for note in found["notes"]] == [True]


@pytest.mark.parametrize(("share", "stable"), [(1e-5, False), (-1e-5, True)])
def test_off_the_axis_there_is_a_verdict(answer, share, stable):
    r_c = 10.0 ** answer("stability", "paper")["log10_r_c"]
    found = answer("stability", "paper", "--set", f"slab.r={r_c * (1.0 + share):.17g}")
    assert found["stable"] is stable
    assert (found["unstable_roots"], found["notes"]) == (0 if stable else 2, [])


def test_a_ramp_says_which_velocity_is_analysed(answer, printed):
    ramp = "drive.velocity=[[0, 1000], [5, 1000], [10, 100]]"
    found = answer("stability", "paper", "--set", ramp)
    same = answer("stability", "paper", "--set", "drive.velocity=1000")
    assert found["velocity"] == same["velocity"] == 1000.0
    assert found["leading_roots"] == same["leading_roots"]
    assert ["V = 1000, the one at t = 0" in note for note in found["notes"]] == [True]
    assert same["notes"] == []
    assert "note: the drive changes: this is steady sliding at V = 1000" in printed("stability", "paper", "--set", ramp)


def test_figures_that_do_not_exist_have_a_reason(answer):
    """Quasi-dynamic slabs on a machine whose onset lies beyond every thickness, and friction that strengthens."""
    rock = {"density": 2700.0, "shear_modulus": "30 GPa", "thickness": 1.0}
    face = {"kind": "machine", "stiffness": 1e11, "impedance": 1e6, "mass": 400.0}
    units = {"normal_stress": 5e6, "memory_length": 1e-5, "reference_velocity": 1e-6}
    friction = {"law": "ageing", "a_star": 0.6, "a": 0.010, "b": 0.015}
    scene = {"interface": friction | units, "slab": rock | {"face": face}, "drive": {"velocity": 1e6}}
    found = slipwave.stability(scene, "quasidynamic").summary
    reach = "between 9.5e-07 and 1024 times the present one"
    assert (found["log10_r_c"], found["omega_c"], found["si"]["critical_thickness_m"]) == (None, None, None)
    assert found["epsilon_c"] > 0.0
    assert found["notes"] == [
        f"no critical r: steady sliding loses its stability at no r {reach}",
        f"no critical thickness: steady sliding loses its stability at none {reach}",
    ]
    found = answer("stability", "paper", "--set", "interface.b=0.01")
    assert (found["log10_r_c"], found["epsilon_c"]) == (None, None)
    assert found["notes"] == [
        "no critical values: friction does not weaken with the slip rate, so that steady sliding is always stable"
    ]
