"""The study of orders: what it shows in the quick report, and that a scheme short of its order fails its verdict."""

import dataclasses

import numpy as np
import pytest

from reduced.delay.alike import Delay
from validation.measure.grid_ladders import GENTLE, LADDERS, ROUGH, STEEP, in_space
from validation.measure.orders import QUANTITIES, climb, errors, measure
from validation.registry.build import build
from validation.run import timing
from validation.studies import grid_convergence as study
from validation.studies.grid_convergence.in_time import COURANT, REQUESTS, Marches, marches_of, time_table, time_verdicts
from validation.studies.grid_convergence.marches import reference, without_error_in_time
from validation.study import Outcome


@pytest.fixture(scope="module")
def exact():
    return measure(build("delay", GENTLE.scene, tolerance=1e-12), GENTLE)


def test_two_delay_runs_differ_by_less_than_the_floor(exact):
    other = measure(build("delay", GENTLE.scene, tolerance=1e-13), GENTLE)
    assert max(errors(other, exact).values()) < GENTLE.floor
    assert exact["period"].size == 10


def test_a_run_that_is_remembered_reads_no_clock(monkeypatch):
    """Otherwise run times by a clock that counts its readings depend on what the process ran before."""
    monkeypatch.setattr(timing, "_spent", lambda: pytest.fail("read"))
    assert measure(build("fd", GENTLE.scene, cells=24), GENTLE)["period"].size


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


@pytest.mark.parametrize("course", [GENTLE, ROUGH, STEEP], ids=["gentle", "rough", "steep"])
def test_the_reference_of_errors_in_space_is_right_to_1e_12(course):
    """Against steps half as long and other nodes; measured: at most 1e-13."""
    other = measure(Delay(course.scene, nodes=9, steps=96, tolerance=1e-13), course)
    assert max(errors(reference(course), other).values()) < 1e-12
    assert in_space(dataclasses.replace(LADDERS["dg:7"], course=course)).course.floor >= 5e-12


def test_high_orders_are_read_on_the_steepest_scene():
    steep = {model for model in LADDERS if in_space(LADDERS[model]).course.scene is STEEP.scene}
    assert steep == {"fem:6", "fem:7", "dg:6", "dg:7"}
    kept = {model for model in LADDERS if in_space(LADDERS[model]).course.scene is LADDERS[model].course.scene}
    assert kept == set(LADDERS) - steep


@pytest.mark.parametrize(
    ("model", "march"), [("dg:2", "exact"), ("sbp:4", "exact"), ("sbp:2", "explicit"), ("dg:1", "explicit"), ("fd", None)]
)
def test_which_march_has_no_error_in_time(model, march):
    settings = without_error_in_time(model, GENTLE.scene, 24, cfl=None).settings
    assert settings.get("time") == march
    assert march != "exact" or settings["resolution"] == 1e-13


def test_elements_of_degree_3_show_order_6_without_error_in_time():
    """With explicit steps the fitted order is 8, that of the steps."""
    climbed = climb(in_space(LADDERS["fem:3"]), reference(GENTLE), without_error_in_time)
    assert climbed.fit_together().order == pytest.approx(6.0, abs=0.3)
    assert max(found[-1] for found in climbed.errors.values()) < 2e-11


def test_both_marches_of_one_grid_are_witnesses_of_each_other():
    """On the same grid errors are those of time alone, a thousandth of that in space at the shortest steps."""
    found = marches_of("dg:7")
    assert found.declared == 8
    assert found.order.order == pytest.approx(9.0, abs=1.0)
    assert found.apart < 5e-12
    assert found.exact[0].max() > 1e-6
    assert found.exact[-1].max() < 3e-11


def synthetic(order=8.0, apart=1e-13, share=0.5, beyond=0.0):
    """Marches with errors of that order and agreement, which are a share of the requested ones and something more."""
    explicit = 1e-8 * np.array(COURANT)[:, None] ** order * np.ones(5)
    explicit[-1] = apart
    return Marches("dg:7", explicit, share * np.array(REQUESTS)[:, None] * np.ones(5) + apart + beyond)


@pytest.mark.parametrize(
    ("changes", "red"),
    [
        ({}, 0),
        ({"order": 7.0}, 1),
        ({"order": 9.5}, 0),
        ({"apart": 4e-12}, 0),
        ({"apart": 6e-12}, 1),
        ({"share": 1.0, "beyond": 2e-11}, 0),
        ({"share": 1.0, "beyond": 4e-11}, 1),
        ({"share": 1.01}, 1),
        ({"share": np.nan}, 1),
    ],
)
def test_marches_are_judged_on_both_sides(changes, red):
    verdicts = time_verdicts([synthetic(**changes)])
    assert [verdict.outcome for verdict in verdicts].count(Outcome.FAIL) == red
    assert len(verdicts) == 3


def test_the_table_of_marches_shows_the_worst_quantity():
    one = synthetic()
    one.explicit[2, 3] = 1e-3
    rows = time_table([one]).rows
    assert len(rows) == len(COURANT) + len(REQUESTS)
    assert rows[2] == ("explicit", COURANT[2], 1e-3)
    assert rows[-1][:2] == ("exact", REQUESTS[-1])
    assert rows[-1][2] == pytest.approx(0.5 * REQUESTS[-1] + 1e-13)
