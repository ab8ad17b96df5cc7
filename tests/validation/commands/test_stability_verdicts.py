"""`slipwave stability` and the study of the onset: neutral roots, and figures that do not exist."""

from functools import cache

import pytest

import slipwave
from tests.granite import GRANITE


@cache
def critical(scene, model):
    """r at which steady sliding is neutral."""
    return float(10.0 ** slipwave.stability(scene, model).summary["log10_r_c"])


@pytest.mark.parametrize("share", [1e-9, -1e-9, 0.0])
@pytest.mark.parametrize("scene", ["paper", "unlike", "grip", "viscous", "slip-law", "layered"])
@pytest.mark.parametrize("model", ["delay", "quasidynamic", "fitted:3"])
def test_a_root_on_the_axis_is_neutral_and_no_verdict(scene, model, share):
    r = critical(scene, model) * (1.0 + share)
    found = slipwave.stability(scene, model, **{"upper.r": r, "lower.r": 2.0 * r} if scene == "unlike" else {"slab.r": r}).summary
    assert abs(found["leading_roots"][0][0]) < 1e-9 * 1e3 * found["omega_c"]
    assert found["stable"] is None
    assert found["unstable_roots"] == 0
    assert ["neutral within rounding" in note for note in found["notes"]] == [True]


def test_figures_that_do_not_exist_have_a_reason(answer):
    """Quasi-dynamic slabs on a machine whose onset lies beyond every thickness, and friction that strengthens."""
    face = {"kind": "machine", "stiffness": 1e11, "impedance": 1e6, "mass": 400.0}
    changes = {"slab.thickness": 1.0, "slab.face": face, "drive.velocity": 1e6}
    found = slipwave.stability(GRANITE, "quasidynamic", **changes).summary
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
        f"infinitely many roots accumulate at Re s = {found['essential_abscissa']:.6g} V*/L, right of all that are listed: "
        "no finite list holds those that decay most slowly",
        "no critical values: friction does not weaken with the slip rate, so that steady sliding is always stable",
    ]
