"""Steps of the drive: every march ends a step at the jump and where it arrives.

One scene: stable sliding, a step up by ten, a hold and a slow restart, none at a multiple of the transit.
"""

import numpy as np
import pytest

import slipwave
from slipwave.solve import follow
from validation.registry.build import prepare

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


AFTERWARDS = [k + 0.25 for k in range(40, 60)]


@pytest.mark.parametrize(("model", "cells", "order"), [("dg:3", 8, 7 / 8), ("dg:7", 4, 15 / 16), ("fd", 32, 2.0)])
def test_a_step_lowers_the_order_of_a_grid_to_one_but_that_of_the_leapfrog(model, cells, order):
    """On the paper's stick-slip, where the step falls on the end of a step of every march. The order is that after a start with a
    jump (test_jump_order.py). Measured: 0.87, 0.92, 2.1."""
    scene = slipwave.read("paper", {"drive.velocity": [[0, 100], [20, 100], [20, 130]]})

    def states(model, **options):
        solver = prepare(model, scene, **options).solver
        return [follow(solver, moment).psi for moment in AFTERWARDS]

    exact = np.array(states("delay", tolerance=1e-11))
    coarse, fine = (np.sqrt(np.mean((states(model, cells=n) - exact) ** 2)) for n in (cells, 2 * cells))
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.15)
