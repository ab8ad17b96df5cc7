"""`slipwave stability` and the study of the onset: neutral roots, closed forms, both sides of every limit."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from shown import outcomes

import slipwave
from reduced import closed_forms
from reduced.stability import Boundary, friction_slopes
from tests.granite import GRANITE
from validation.studies import onset
from validation.study import Outcome

PAPER = slipwave.read("paper")
SLOPES = friction_slopes(PAPER.law, PAPER.velocity)


def test_gaps_are_relative_distances_from_the_roots(monkeypatch):
    """With r off by 1e-6: as far is the root of the cubic in r, and the quartic's nearest root tells how far i omega_c is."""
    off = closed_forms.kelvin_voigt_r(SLOPES, PAPER.upper.epsilon) * (1.0 + 1e-6)
    roots = np.roots(closed_forms.kelvin_voigt_quartic(SLOPES, PAPER.upper.epsilon, off))
    monkeypatch.setattr(closed_forms, "kelvin_voigt_r", lambda *args: off)
    cubic, quartic, root = onset.gaps_at(PAPER, PAPER.velocity).values()
    assert cubic == pytest.approx(1e-6, rel=1e-4)
    assert quartic == pytest.approx(np.abs(roots / (1j * SLOPES.omega_c) - 1.0).min(), rel=1e-4)
    assert root < 2e-14  # of another equation


def traced(factor=1.0, first=1.0008):
    """The closed forms' branches, multiplied by `factor`; the ODE's second one begins at `first` times its asymptote."""
    low = np.log10(np.geomspace(1e-3, 8e-3, 9))
    beyond = np.log10(first * np.sqrt(24.0) / SLOPES.omega_c * np.geomspace(1.0, 1.2, 9))
    return {
        model: [Boundary(("r", "e"), r, np.log10(factor * np.abs([closed(SLOPES, 10**x) for x in r])), r) for r in (low, beyond)]
        for model, (_, closed) in onset.FORMS.items()
    }


@pytest.mark.parametrize(
    ("changes", "apart", "outcome"),
    [
        ({"factor": 1.0 + 3.6e-10}, (0, 2), "pass pass"),
        ({"factor": 1.0 - 1.2e-9}, (0, 2), "fail pass"),
        ({"first": 1.0019}, (0, 2), "pass pass"),
        ({"first": 1.006}, (0, 2), "pass finding"),
        ({}, (2, 2), "pass finding"),
    ],
)
def test_traced_boundaries_lie_on_the_closed_forms_and_part_what_they_bound(monkeypatch, changes, apart, outcome):
    monkeypatch.setitem(onset.FORMS, "delay", onset.FORMS["kelvin-voigt"])  # its second branch lies elsewhere
    monkeypatch.setattr(onset, "counts_across", lambda *args: apart)
    assert outcomes(onset.fig_3(traced(**changes), SLOPES, PAPER)) == outcome


def test_thin_slabs_have_the_quasi_static_boundary(monkeypatch):
    assert onset.thin_slabs(SLOPES).outcome is Outcome.PASS
    monkeypatch.setitem(onset.FORMS, "delay", (None, lambda slopes, r: 1.001 * closed_forms.kelvin_voigt_epsilon(slopes, r)))
    assert onset.thin_slabs(SLOPES).outcome is Outcome.FAIL


POLE = max(np.roots([1 / 1920, 0.0, 1 / 24, 0.0, 1.0]), key=lambda root: root.real + root.imag)


@pytest.mark.parametrize(
    ("pole", "growing", "passive", "outcome"),
    [
        (POLE, 2, False, "pass"),
        (POLE * (1.0 + 1e-13), 2, False, "fail"),
        (POLE, 0, False, "fail"),
        (POLE, 2, True, "fail"),
    ],
)
def test_the_next_truncation(monkeypatch, pole, growing, passive, outcome):
    monkeypatch.setattr(onset, "taylor_poles", lambda: (pole, pole.conjugate()))
    monkeypatch.setattr(onset, "analyse", lambda *args: SimpleNamespace(unstable_roots=growing))
    monkeypatch.setattr(onset, "check_passivity", lambda *args: SimpleNamespace(passive=passive))
    assert onset.taylor(PAPER).outcome == outcome


def test_the_answer_says_where_the_errors_are():
    """1 % at V = 100, 2 % at 10^3, 8 % at 10^4."""
    told = onset.answer(np.array([1e2, 1e3, 1e4]), np.array([0.01, 0.02, 0.08]))
    assert told.endswith("by 1 · 10^{−2} at V = 100, by 2.0 · 10^{−2} at V = 10^{3} and by 8 % at V = 10^{4}.")


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
