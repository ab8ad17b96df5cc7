"""Full waves at their orders against exact motions, the delay system and a plain program."""

import math

import numpy as np
import pytest
from shown import outcomes

import slipwave
from tests.plain_ode import plain_kelvin_voigt, right_hand_side, steady_start
from validation.compute.build import build
from validation.measure.manufactured import RATIO, error_of_motion, exact_motion, given_scene
from validation.studies.orders.given_motion import GRIDS, climbed, motion_verdicts

FAST = {("fd", "unlike"), ("sbp:4", "alike"), ("dg:2", "unlike")}


@pytest.mark.parametrize("unlike", [False, True])
def test_the_given_motion_solves_wave_equation_friction_and_ageing(unlike):
    """The slabs' own velocities from the drive by MODEL.md section 3, marched by hand: S = [mu - eps w](t - k) + 2 eps V/2."""
    scene, step = given_scene(unlike), 0.01
    times = np.arange(-500, 1200) * step  # steady sliding until the pulse
    motion = exact_motion(scene, times)
    z, psi, mu = motion.T
    own = []
    for slab, trips in ((scene.upper, 1), (scene.lower, RATIO if unlike else 1)):
        late, velocity = round(trips / step), np.full(times.size, 0.5)
        for n in range(late, times.size):
            launched = mu[n - late] - slab.epsilon * velocity[n - late]
            velocity[n] = (launched - mu[n]) / slab.epsilon + scene.drive.at(times[n] - 0.5 * trips)
        own.append(velocity)
    assert own[0] + own[1] == pytest.approx(np.exp(z), abs=1e-11)
    assert mu == pytest.approx(scene.law.a_star + scene.law.a * z + scene.law.b * psi, abs=1e-13)
    change = np.gradient(psi, step, edge_order=2)[1:-1]
    assert change == pytest.approx((scene.transit * (np.exp(-psi) - np.exp(z)))[1:-1], abs=2e-3)
    assert np.ptp(z) > 3.0


@pytest.mark.parametrize(
    ("model", "pair"),
    [
        pytest.param(model, pair, marks=[] if (model, pair) in FAST else pytest.mark.slow)
        for model in GRIDS
        for pair in ("alike", "unlike")
    ],
)
def test_every_full_wave_makes_it_at_its_order(model, pair):
    assert outcomes(motion_verdicts([climbed(model, pair)])) == "pass"


def test_exact_steps_follow_a_drive_that_is_not_linear():
    """With two terms of V in a step they would be wrong by 0.2."""
    assert error_of_motion(build("dg:7", given_scene(False), cells=6, time="exact")) < 1e-7


KNOWN = 70.732344990  # AUTO-07p, log10 r = -2.68


def test_its_steady_sliding_turns_neutral_at_the_onset_that_auto_finds():
    """At log10 r = -2.69954994745 a pair of eigenvalues is +-i 2 pi/49.66821032; the others belong to the ODE's damped wave."""
    scene = slipwave.read("paper", {"slab.log10_r": -2.69954994745})
    rates, at = right_hand_side(scene), np.array(steady_start(scene))
    before = -1e3  # transits: no nudge
    assert rates(before, at) == pytest.approx([0.0] * 4, abs=1e-13)
    columns = [np.subtract(rates(before, at + e), rates(before, at - e)) / 2e-6 for e in 1e-6 * np.eye(4)]
    roots = np.linalg.eigvals(np.array(columns).T)
    neutral = roots[np.argsort(np.abs(roots.real))[:2]]
    assert np.abs(neutral.real).max() < 5e-10
    assert np.abs(neutral.imag) == pytest.approx(2.0 * math.pi / 49.66821032, rel=1e-8)


def test_it_is_nudged_as_the_scene_says_and_finds_the_period():
    scene = slipwave.read("paper")
    rates, at = right_hand_side(scene), np.array(steady_start(scene))
    assert [rates(time, at)[3] for time in (6.0, 7.0)] == pytest.approx([0.5, 0.5 * math.exp(-1.0)])
    period, evaluations = plain_kelvin_voigt(slipwave.read("paper"), 2000.0, 1e-10)
    assert period == pytest.approx(KNOWN, rel=1e-7)  # 3e-8 was measured: the transient
    assert evaluations > 10_000
