"""The study of stability boundaries on values of our own: outcomes on both sides of every limit, answers, figures."""

from types import SimpleNamespace

import numpy as np
import pytest

import slipwave
from reduced import closed_forms
from reduced.stability import Boundary, friction_slopes
from validation.studies import stability_boundaries as study
from validation.studies.stability_boundaries import critical_curves, impedances, planes, spectra
from validation.studies.stability_boundaries import measured as verdicts
from validation.studies.stability_boundaries.measured import Curves
from validation.study import Outcome

PAPER = slipwave.read("paper")
SLOPES = friction_slopes(PAPER.law, PAPER.velocity)
V = np.array([1.0, 100.0, 1e3, 1e4])


def curves(slow=3.2e-3, fast=0.077, gap=1e-15):
    delay = np.array([1.0, 2.0, 3.0, 4.0])
    return Curves(V, delay, delay * (1.0 - np.array([1e-7, 5e-7, slow, fast])), gap)


@pytest.mark.parametrize(("gap", "outcome"), [(1.8e-14, Outcome.PASS), (6e-14, Outcome.FAIL)])
def test_closed_forms_hold_to_rounding(gap, outcome):
    assert list(verdicts.closed_form_verdicts(PAPER, curves(gap=gap)))[-1].outcome is outcome


@pytest.mark.parametrize("name", ["cubic", "quartic", "root"])
@pytest.mark.parametrize(("gap", "outcome"), [(1.8e-14, Outcome.PASS), (6e-14, Outcome.FAIL)])
def test_each_closed_form_is_judged_alone(monkeypatch, name, gap, outcome):
    monkeypatch.setattr(verdicts, "_gaps", lambda *args: {"cubic": 0.0, "quartic": 0.0, "root": 0.0, name: gap})
    found = verdicts.closed_form_verdicts(PAPER, curves())
    assert [v.outcome for v in found].count(outcome) == (4 if outcome is Outcome.PASS else 1)


def test_gaps_are_relative_distances_from_the_roots(monkeypatch):
    """With r off by 1e-6: as far is the root of the cubic in r, and the quartic's nearest root tells how far i omega_c is."""
    off = closed_forms.kelvin_voigt_r(SLOPES, PAPER.upper.epsilon) * (1.0 + 1e-6)
    roots = np.roots(closed_forms.kelvin_voigt_quartic(SLOPES, PAPER.upper.epsilon, off))
    monkeypatch.setattr(closed_forms, "kelvin_voigt_r", lambda *args: off)
    gaps = verdicts._gaps(PAPER, SLOPES, PAPER.upper.epsilon, PAPER.velocity)
    cubic, quartic, root = gaps.values()
    assert cubic == pytest.approx(1e-6, rel=1e-4)
    assert quartic == pytest.approx(np.abs(roots / (1j * SLOPES.omega_c) - 1.0).min(), rel=1e-4)
    assert root < 2e-14  # of another equation


@pytest.mark.parametrize(
    ("slow", "fast", "outcomes"),
    [(0.9e-2, 0.033, "pass pass"), (3e-2, 0.077, "finding pass"), (3e-3, 0.03, "pass finding"), (3e-3, 0.33, "pass finding")],
)
def test_one_reading_of_fig_2(slow, fast, outcomes):
    assert [v.outcome for v in verdicts.fig_2(curves(slow, fast))] == outcomes.split()


def traced(factor=1.0, first=1.0008, branches=2):
    """The closed forms' branches, multiplied by `factor`; the ODE's second one begins at `first` times its asymptote."""
    low = np.log10(np.geomspace(1e-3, 8e-3, 9))
    beyond = np.log10(first * np.sqrt(24.0) / SLOPES.omega_c * np.geomspace(1.0, 1.2, 9))
    found = {}
    for model, closed in verdicts.TRACED.items():
        curve = [Boundary(("r", "e"), r, np.log10(factor * np.abs([closed(SLOPES, 10**x) for x in r])), r) for r in (low, beyond)]
        found[model] = curve[:branches]
    return found


@pytest.fixture
def parted(monkeypatch):
    monkeypatch.setattr(verdicts, "_beside", lambda *args: (0, 2))


@pytest.mark.parametrize(
    ("changes", "outcomes"),
    [
        ({}, "pass pass"),
        ({"factor": 1.0 + 3.6e-10}, "pass pass"),
        ({"factor": 1.0 - 1.2e-9}, "fail pass"),
        ({"first": 1.0019}, "pass pass"),
        ({"first": 1.006}, "pass finding"),
    ],
)
def test_traced_boundaries_lie_on_the_closed_forms(parted, monkeypatch, changes, outcomes):
    monkeypatch.setitem(verdicts.TRACED, "delay", verdicts.TRACED["kelvin-voigt"])  # its second branch lies elsewhere
    assert [v.outcome for v in verdicts.fig_3(traced(**changes), SLOPES, PAPER)] == outcomes.split()


def test_thin_slabs_have_the_quasi_static_boundary(monkeypatch):
    assert verdicts.thin_slabs(SLOPES).outcome == "pass"
    monkeypatch.setitem(verdicts.TRACED, "delay", lambda slopes, r: 1.001 * verdicts.TRACED["kelvin-voigt"](slopes, r))
    assert verdicts.thin_slabs(SLOPES).outcome == "fail"


def test_a_branch_that_parts_nothing_is_told(monkeypatch):
    monkeypatch.setitem(verdicts.TRACED, "delay", verdicts.TRACED["kelvin-voigt"])
    monkeypatch.setattr(verdicts, "_beside", lambda *args: (2, 2))
    assert [v.outcome for v in verdicts.fig_3(traced(), SLOPES, PAPER)] == ["pass", "finding"]
    assert "across every branch: no" in list(verdicts.fig_3(traced(), SLOPES, PAPER))[1].remark


POLE = max(np.roots([1 / 1920, 0.0, 1 / 24, 0.0, 1.0]), key=lambda root: root.real + root.imag)


@pytest.mark.parametrize(
    ("pole", "growing", "passive", "outcome"),
    [
        (POLE, 2, False, "pass"),
        (POLE * (1.0 + 1e-13), 2, False, "fail"),
        (-POLE.conjugate(), 2, False, "fail"),
        (POLE, 0, False, "fail"),
        (POLE, 2, True, "fail"),
    ],
)
def test_the_next_truncation(monkeypatch, pole, growing, passive, outcome):
    monkeypatch.setattr(verdicts, "taylor_poles", lambda: (pole, pole.conjugate()))
    monkeypatch.setattr(verdicts, "analyse", lambda *args: SimpleNamespace(unstable_roots=growing))
    monkeypatch.setattr(verdicts, "check_passivity", lambda *args: SimpleNamespace(passive=passive))
    assert verdicts.taylor(PAPER).outcome == outcome


def test_the_answer_tells_the_errors():
    onsets = {"delay": (2e-3, 1.0), "kelvin-voigt": (2e-3 * (1 - 4e-7), 1.0)}
    told = study._answer(curves(), onsets)
    assert told.endswith("by 4 · 10^{−7} at V = 100, by 3.2 · 10^{−3} at V = 10^{3} and by 8 % at V = 10^{4}.")
    assert study._answer(curves(fast=0.5), onsets).endswith("by 50 % at V = 10^{4}.")


def test_fig_2_shows_both_curves_and_their_difference():
    shown = curves()
    left, right = critical_curves(V, shown.delay, shown.kelvin_voigt).axes
    assert [axes.get_xlabel() for axes in (left, right)] == ["$V/V^*$"] * 2
    assert [axes.get_ylabel() for axes in (left, right)] == ["$r_c$", "relative error of $r_c$"]
    assert [np.array_equal(line.get_ydata(), y) for line, y in zip(left.get_lines(), shown[1:3], strict=True)] == [True, True]
    assert np.allclose(right.get_lines()[0].get_ydata(), [1e-7, 5e-7, 3.2e-3, 0.077])


def test_fig_3_shows_lines_and_marks():
    found = {"delay": traced()["kelvin-voigt"], "kelvin-voigt": traced()["kelvin-voigt"]}
    axes = planes(found, SLOPES, PAPER).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("$r$", r"$\epsilon$")
    r, epsilon = axes.get_lines()[0].get_data()
    assert epsilon[100] == pytest.approx(closed_forms.delay_epsilon(SLOPES, r[100]))
    assert np.array_equal(axes.get_lines()[1].get_xdata(), 10 ** found["delay"][0].first[::3])


def test_roots_are_drawn_on_the_transit_clock():
    roots = (complex(3.0, 50.0), complex(-1.0, 300.0))
    found = {model: SimpleNamespace(leading_roots=roots, essential_abscissa=-2.0) for model in study._SPECTRA}
    axes = spectra(found, 2e-3).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("Re $s$ (per transit)", "Im $s$ (per transit)")
    assert np.allclose(axes.get_lines()[0].get_xdata(), [6e-3, -2e-3])
    assert np.allclose(axes.get_lines()[0].get_ydata(), [0.1, 0.6])


def test_impedances_are_drawn_over_epsilon_and_per_transit():
    """The block of mass rho h/12: Z/eps = (1 + s^2/12)/s on s = 0.2 + i omega."""
    size, error, phase = impedances(PAPER).axes
    assert [axes.get_ylabel() for axes in (size, error, phase)] == [
        r"$|Z|/\epsilon$",
        r"$|Z/Z_{\rm exact}-1|$",
        "phase of $Z$ (degrees)",
    ]
    assert {axes.get_xlabel() for axes in (error, phase)} == {r"$\omega$ (radians per transit)"}
    assert (size.get_ylim(), error.get_ylim()) == ((0.02, 30.0), (1e-8, 20.0))
    exact, _, _, block = size.get_lines()[:4]
    s = 0.2 + 1j * exact.get_xdata()
    assert exact.get_ydata() == pytest.approx(np.abs(0.5 / np.tanh(0.5 * s)), rel=1e-9)
    assert block.get_ydata() == pytest.approx(np.abs((1.0 + s**2 / 12.0) / s), rel=1e-9)
    assert phase.get_lines()[0].get_ydata() == pytest.approx(np.degrees(np.angle(0.5 / np.tanh(0.5 * s))), rel=1e-9)
    assert len(error.get_lines()) == 7


def test_a_wrong_closed_form_turns_a_light_red(monkeypatch):
    paper = slipwave.read("paper")
    measured = verdicts.critical_over_velocity(paper, np.array([1.0, 1e4]))
    right = closed_forms.kelvin_voigt_r
    monkeypatch.setattr(closed_forms, "kelvin_voigt_r", lambda slopes, epsilon: 1.000001 * right(slopes, epsilon))
    outcomes = [verdict.outcome for verdict in verdicts.closed_form_verdicts(paper, measured)]
    assert outcomes.count(Outcome.FAIL) == 2
