"""Full waves at their orders against exact motions and the delay system."""

import numpy as np
import pytest
from shown import outcomes

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
    assert error_of_motion("dg:7", given_scene(False), 6, time="exact") < 1e-7
