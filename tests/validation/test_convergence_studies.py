"""The two studies of convergence: their references, orders and marches; counterfeits turn them red."""

from dataclasses import replace

import numpy as np
import pytest
from shown import judged, quick, too_roomy

from reduced.delay.alike import Delay
from validation.compute.build import build
from validation.measure.grid_ladders import GENTLE, LADDERS, ROUGH, STEEP, in_space
from validation.measure.grids.in_space import delay_reference, without_error_in_time
from validation.measure.orders import climb, errors, measure
from validation.studies.grid_convergence import in_time
from validation.study import Outcome
from validation.study.grid_verdicts import order_verdict


@pytest.fixture(scope="module")
def exact():
    return measure(build("delay", GENTLE.scene, tolerance=1e-12), GENTLE)


def test_two_delay_runs_differ_by_less_than_the_floor(exact):
    other = measure(build("delay", GENTLE.scene, tolerance=1e-13), GENTLE)
    assert max(errors(other, exact).values()) < GENTLE.floor
    assert exact["period"].size == 10
    fewer = {name: values[1:] if name != "state" else values for name, values in exact.items()}
    assert (errors(fewer, exact)["period"], errors(fewer, exact)["state"]) == (np.inf, 0.0)


@pytest.mark.parametrize(("displaced", "changes", "red"), [(0.0, {}, 0), (1e-6, {"most": 60}, 1), (0.0, {"promised": 4.5}, 1)])
def test_a_scheme_short_of_its_order_is_red(exact, displaced, changes, red):
    """The reference displaced by 1e-6, as a friction clock that is off would: errors stop falling."""
    wrong = {name: values * (1 + displaced) for name, values in exact.items()}
    found = climb(replace(LADDERS["dg:2"], **changes), wrong, build)
    assert judged(order_verdict(found), red)
    assert red or found.fit_together().order == pytest.approx(4.0, abs=0.02)


@pytest.mark.parametrize("run", [GENTLE, ROUGH, STEEP], ids=["gentle", "rough", "steep"])
def test_the_reference_of_errors_in_space_is_right_to_1e_12(run):
    """Against steps half as long and other nodes; measured: at most 1e-13."""
    other = measure(Delay(run.scene, nodes=9, steps=96, tolerance=1e-13), run)
    assert max(errors(delay_reference(run), other).values()) < 1e-12
    assert in_space(replace(LADDERS["dg:7"], run=run)).run.floor >= 5e-12


def test_elements_of_degree_3_show_order_6_without_error_in_time():
    """With explicit steps the fitted order is 8, that of the steps."""
    climbed = climb(in_space(LADDERS["fem:3"]), delay_reference(GENTLE), without_error_in_time)
    assert climbed.fit_together().order == pytest.approx(6.0, abs=0.3)
    assert max(found[-1] for found in climbed.errors.values()) < 2e-11


def test_both_marches_of_one_grid_are_witnesses_of_each_other():
    """On the same grid errors are those of time alone, a thousandth of that in space at the shortest steps."""
    found = in_time.marches_of("dg:7")
    assert found.order.order == pytest.approx(9.0, abs=1.0)
    assert found.apart < 5e-12
    assert found.exact[0].max() > 1e-6
    assert found.exact[-1].max() < 3e-11


@pytest.mark.slow
@pytest.mark.parametrize("name", ["leapfrog-convergence", "grid-convergence"])
def test_a_quick_run_holds_and_counterfeits_turn_it_red(name):
    verdicts = quick(name).verdicts
    assert {verdict.outcome for verdict in verdicts} == {Outcome.PASS}
    assert too_roomy([verdict for verdict in verdicts if "order" not in verdict.claim]) == []
