"""The study of orders: what it measures, and outcomes on both sides of its limits."""

from dataclasses import replace

import numpy as np
import pytest
from shown import judged, outcomes

from fullwave.families import GALERKIN
from reduced.delay.alike import Delay
from validation.measure.grid_ladders import GENTLE, LADDERS, ROUGH, STEEP, in_space
from validation.measure.grids.in_space import delay_reference
from validation.measure.orders import QUANTITIES, Climb, climb, errors, measure
from validation.models.build import build
from validation.report import Outcome
from validation.report.grid_verdicts import order_verdict
from validation.studies.orders import in_space as study
from validation.studies.orders import own_orbits, slip_event


def test_an_order_ends_where_rounding_begins():
    """The finest error above the floor counts; the second grid in any case."""
    errors = ((2, 1e-4), (4, 1e-7), (8, 1e-10), (16, 2e-13))
    orbits = [own_orbits.GridOrbit("dg:7", -2.68, cells, dict.fromkeys(own_orbits.QUANTITIES, error)) for cells, error in errors]
    assert own_orbits.orbit_order(orbits, "period") == pytest.approx(np.log(1e6) / np.log(4.0))
    assert own_orbits.orbit_order([orbits[0], orbits[3]], "period") == pytest.approx(np.log(5e8) / np.log(8.0))


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


def test_a_ladder_without_an_order_is_red_and_says_why():
    cells = np.array(LADDERS["sbp:4"].levels(), dtype=float)
    verdict = order_verdict(Climb(LADDERS["sbp:4"], cells, dict.fromkeys(QUANTITIES, np.full(cells.size, np.inf))))
    told = (verdict.outcome, verdict.ours, verdict.remark)
    assert told == (Outcome.FAIL, "no order: 0 usable levels; an order needs 4", "`sbp:4`")


def test_every_family_with_a_ladder_is_judged_by_a_quick_report(monkeypatch):
    own = replace(GALERKIN, pattern="volumes", numbers=(), default=None, ladder={0: GALERKIN.ladder[1]})
    monkeypatch.setattr(study, "GRIDS", (*study.GRIDS, own, replace(own, pattern="bare", ladder={})))
    assert study.judged_models(quick=True) == (*study._QUICK, "volumes")
    assert set(study.judged_models(quick=False)) == set(LADDERS)


def test_a_wrong_wave_speed_and_an_event_that_never_ends_are_red():
    event = slip_event.recorded_event()
    upper = event.upper
    assert outcomes(slip_event.event_verdicts(event)) == "pass pass"
    assert outcomes(slip_event.event_verdicts(replace(event, upper=replace(upper, depth=1.001 * upper.depth)))) == "fail pass"
    endless = replace(upper, velocity=np.full_like(upper.velocity, 1e3))
    assert outcomes(slip_event.event_verdicts(replace(event, upper=endless))).endswith("fail")
