"""The plain program that the Kelvin-Voigt system is raced against: its equations and its period, compared with other programs."""

import math

import numpy as np
import pytest

import slipwave
from validation.references.lsoda import PlainRun, plain_kelvin_voigt, right_hand_side, steady_state
from validation.studies import cost_and_error
from validation.study import Outcome
from validation.timing import Setting, TimedRun

KNOWN = 70.732344990  # AUTO-07p, log10 r = -2.68


def test_its_steady_sliding_turns_neutral_at_the_onset_that_auto_finds():
    """At log10 r = -2.69954994745 a pair of eigenvalues is +-i 2 pi/49.66821032; the others belong to the ODE's damped wave."""
    scene = slipwave.read("paper", {"slab.log10_r": -2.69954994745})
    rates, at = right_hand_side(scene), np.array(steady_state(scene))
    before = -1e3  # transits: no nudge
    assert rates(before, at) == pytest.approx([0.0] * 4, abs=1e-13)
    columns = [np.subtract(rates(before, at + e), rates(before, at - e)) / 2e-6 for e in 1e-6 * np.eye(4)]
    roots = np.linalg.eigvals(np.array(columns).T)
    neutral = roots[np.argsort(np.abs(roots.real))[:2]]
    assert np.abs(neutral.real).max() < 5e-10
    assert np.abs(neutral.imag) == pytest.approx(2.0 * math.pi / 49.66821032, rel=1e-8)


def test_it_is_nudged_as_the_scene_says_and_finds_the_period():
    scene = slipwave.read("paper")
    rates, at = right_hand_side(scene), np.array(steady_state(scene))
    assert [rates(time, at)[3] for time in (6.0, 7.0)] == pytest.approx([0.5, 0.5 * math.exp(-1.0)])
    run = plain_kelvin_voigt(slipwave.read("paper"), 2000.0, 1e-10)
    assert run.period == pytest.approx(KNOWN, rel=1e-7)  # 3e-8 was measured: the transient
    assert run.evaluations > 10_000


def rival(off, tolerance=1e-10):
    return PlainRun(tolerance, KNOWN * (1.0 + off), 3.0, 1)


def ours(off, tolerance=1e-11):
    return TimedRun(Setting("kelvin-voigt", tolerance=tolerance), 0.02, KNOWN * (1.0 + off), off, math.nan)


def test_both_runs_of_the_race_are_judged_at_their_least_tolerance():
    assert cost_and_error._agreement([rival(4.5e-8), rival(1e-3, 1e-8)]).outcome is Outcome.PASS
    assert cost_and_error._agreement([rival(-1.5e-7), rival(0.0, 1e-8)]).outcome is Outcome.FAIL
    assert cost_and_error._right([ours(0.9 * cost_and_error._OUR_ERROR), ours(1e-3, 1e-3)]).outcome is Outcome.PASS
    assert cost_and_error._right([ours(-3.0 * cost_and_error._OUR_ERROR), ours(0.0, 1e-3)]).outcome is Outcome.FAIL


@pytest.mark.parametrize(("quick", "grids", "elements"), [(True, 4, 2), (False, 5, 4)])
def test_every_model_runs_at_every_setting_once(quick, grids, elements):
    settings = [(setting.model, setting.words) for setting in cost_and_error._settings(quick)]
    assert len(set(settings)) == len(settings) == 5 + 2 * grids + 2 * elements + 6 * 5
    assert ("fd", "64 cells, CFL 0.5") in settings
    assert ("delay", "tolerance 10^{-11}") in settings
    assert ("modal:8", "tolerance 10^{-3}") in settings
