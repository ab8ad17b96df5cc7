"""The study of orders: what it shows in the quick report, and that a scheme short of its order fails its verdict."""

import dataclasses

import numpy as np
import pytest

from validation.measure.grid_ladders import GENTLE, LADDERS
from validation.measure.orders import QUANTITIES, climb, errors, measure
from validation.registry.build import build
from validation.studies import grid_convergence as study
from validation.study import Outcome


@pytest.fixture(scope="module")
def exact():
    return measure(build("delay", GENTLE.scene, tolerance=1e-12), GENTLE)


def test_two_delay_runs_differ_by_less_than_the_floor(exact):
    other = measure(build("delay", GENTLE.scene, tolerance=1e-13), GENTLE)
    assert max(errors(other, exact).values()) < GENTLE.floor
    assert exact["period"].size == 10


def test_a_ladder_against_the_delay_system(exact):
    climbed = climb(LADDERS["dg:2"], exact, build)
    assert study._order_verdict(climbed).outcome is Outcome.PASS
    assert climbed.fit_together().order == pytest.approx(4.0, abs=0.02)
    assert climbed.errors.keys() == QUANTITIES.keys()


def test_a_scheme_short_of_its_order_is_red(exact):
    """The reference displaced by 1e-6, as a friction clock that is off would: errors stop falling."""
    wrong = {name: values * (1 + 1e-6) for name, values in exact.items()}
    found = climb(dataclasses.replace(LADDERS["dg:2"], most=60), wrong, build)
    verdict = study._order_verdict(found)
    assert verdict.outcome is Outcome.FAIL
    assert "short in" in verdict.remark
    promised = dataclasses.replace(LADDERS["dg:2"], promised=4.5)
    right = climb(promised, exact, build)
    assert study._order_verdict(right).outcome is Outcome.FAIL


def test_a_run_with_other_cycles_has_no_finite_error(exact):
    fewer = {name: values[1:] if name != "state" else values for name, values in exact.items()}
    off = errors(fewer, exact)
    assert np.isinf(off["period"])
    assert off["state"] == 0.0
