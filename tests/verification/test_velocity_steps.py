"""Steps of the drive: every march ends a step at the jump and where it arrives.

One scene: stable sliding, a step up by ten, a hold and a slow restart, none at a multiple of the transit.
"""

import pytest

import slipwave
from slipwave.solve import follow
from validation.compute.build import prepare

STEPS = [[0, 100], [10.3, 100], [10.3, 1000], [14.0, 1000], [14.0, 0], [20.7, 0], [20.7, 50]]
QUIET = {"slab.log10_r": -3.2, "start.size": 0.0, "drive.velocity": STEPS}
LATE = [11.35, 15.7, 23.4]
"""After the step, in the hold, after the restart."""


def final(model, until, changes, **options):
    scene = slipwave.read("paper", QUIET | {"run.until": until} | changes)
    found = follow(prepare(model, scene, **options).solver, until, [])
    return found


@pytest.mark.parametrize("until", LATE)
def test_the_leapfrog_tends_to_the_delay_system(until):
    """It places a step to within one of its own steps, so that halving them halves the error: extrapolated, it is 1000 times
    nearer."""
    exact = final("delay", until, {})
    coarse, fine = (final("fd", until, {}, cells=cells) for cells in (400, 800))
    assert 2.0 * fine.ln_v - coarse.ln_v == pytest.approx(exact.ln_v, abs=5e-7)  # 4e-8 measured
    assert 2.0 * fine.psi - coarse.psi == pytest.approx(exact.psi, abs=5e-7)
