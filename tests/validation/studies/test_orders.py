"""Studies of orders, exact motions, branches and experiments: what they measure, outcomes beside their limits."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from shown import judged, outcomes

import slipwave
from fullwave.families import GALERKIN
from reduced.delay.alike import Delay
from validation.measure.grid_ladders import GENTLE, LADDERS, ROUGH, STEEP, in_space
from validation.measure.manufactured import RATIO, error_of_motion, given_scene
from validation.measure.orders import QUANTITIES, Climb, climb, delay_reference, errors, measure
from validation.measure.over_r import RANGE, branch_of, unaccounted
from validation.models.build import build
from validation.references.published import laboratory
from validation.report import Outcome
from validation.report.grid_verdicts import order_verdict
from validation.studies import bifurcation as claims
from validation.studies import orders
from validation.studies.bifurcation.doubling import doubled
from validation.studies.laboratory import _FITS, _RUNS, _cycle_without_tuning, _fitted_to, _program_verdicts, _rise_time
from validation.studies.snaking import sides


def test_an_order_ends_where_rounding_begins():
    errors = {cells: {"period": error} for cells, error in ((2, 1e-4), (4, 1e-7), (8, 1e-10), (16, 2e-13))}
    assert orders._orbit_order(errors, "period") == pytest.approx(np.log(1e6) / np.log(4.0))
    assert orders._orbit_order({cells: errors[cells] for cells in (2, 16)}, "period") == pytest.approx(np.log(5e8) / np.log(8.0))


@pytest.fixture(scope="module")
def exact():
    return measure(build("delay", GENTLE.scene, tolerance=1e-12), GENTLE)


def test_a_run_with_other_events_is_infinitely_far(exact):
    assert exact["period"].size == 10
    fewer = {name: values[1:] if name != "state" else values for name, values in exact.items()}
    assert (errors(fewer, exact)["period"], errors(fewer, exact)["state"]) == (np.inf, 0.0)


@pytest.mark.parametrize(("displaced", "changes", "red"), [(0.0, {}, 0), (1e-6, {"most": 60}, 1), (0.0, {"promised": 4.5}, 1)])
def test_a_scheme_short_of_its_order_is_red(exact, displaced, changes, red):
    """The reference displaced by 1e-6, as a friction clock that is off would: errors stop falling."""
    wrong = {name: values * (1 + displaced) for name, values in exact.items()}
    found = climb(replace(LADDERS["dg:2"], **changes), wrong, build)
    assert judged(order_verdict(found), red)
    assert red or found.fits["together"].order == pytest.approx(4.0, abs=0.02)


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
    monkeypatch.setattr(orders, "GRIDS", (*orders.GRIDS, own, replace(own, pattern="bare", ladder={})))
    assert orders._judged_models(quick=True) == (*orders._FEW, "volumes")
    assert set(orders._judged_models(quick=False)) == set(LADDERS)


def test_a_wrong_wave_speed_and_an_event_that_never_ends_are_red():
    time, depth, wave, rate = orders._recorded_event()
    assert outcomes(orders._event_verdicts((time, depth, wave, rate))) == "pass pass"
    assert outcomes(orders._event_verdicts((time, 1.001 * depth, wave, rate))) == "fail pass"
    assert outcomes(orders._event_verdicts((time, depth, wave, np.full_like(rate, 1e3)))) == "pass fail"


FAST = {("fd", "unlike"), ("sbp:4", "alike"), ("dg:2", "unlike")}


@pytest.mark.parametrize("unlike", [False, True])
def test_the_given_motion_solves_wave_equation_friction_and_ageing(unlike):
    """The slabs' own velocities from the drive by MODEL.md section 3, marched by hand: S = [mu - eps w](t - k) + 2 eps V/2."""
    scene, step = given_scene(unlike), 0.01
    times = np.arange(-500, 1200) * step  # steady sliding until the pulse
    motion = scene.drive.exact(scene, times)
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
        for model in orders.MOTION_GRIDS
        for pair in ("alike", "unlike")
    ],
)
def test_every_full_wave_makes_it_at_its_order(model, pair):
    assert outcomes(orders._motion_verdict(model, pair, orders._motion_errors(model, pair))) == "pass"


def test_exact_steps_follow_a_drive_that_is_not_linear():
    """With two terms of V in a step they would be wrong by 0.2."""
    assert error_of_motion("dg:7", given_scene(False), 6, time="exact") < 1e-7


def test_the_branch_of_the_studies_is_that_of_the_command():
    branch = branch_of("kelvin-voigt", -2.3, 61.0, 1e-6)
    found = slipwave.branch("paper", ("log10_r", *RANGE), model="kelvin-voigt", tol=1e-6, longest_period=61.0).summary
    ours = [("HB", branch.onset.parameter), *((one.kind, one.point.parameter) for one in branch.special)]
    assert [(one["type"], one["log10_r"]) for one in found["special"]] == ours
    assert [point["period"] for point in found["points"]] == [
        point.closed.cycle.period for point in branch.points if all(point is not one.point for one in branch.special)
    ]


def test_a_run_beside_a_special_point_shows_the_multiplier_that_passes():
    branch = branch_of("delay", -2.69, 60.0)
    before, beyond = sides(branch)
    assert ([one.kind for one in branch.special], before[0] < -2.69, beyond[0] < -2.69) == (["LP"], True, True)
    assert before[1].real > 1.0 > beyond[1].real
    assert [before[2], beyond[2]] == pytest.approx([before[1], beyond[1]], abs=1e-6)


def special(kind, log10_r, before=0, after=1, period=80.0):
    return SimpleNamespace(kind=kind, point=point(log10_r, after, period), unstable_before=before, unstable_after=after)


def point(log10_r, unstable, period=80.0):
    closed = SimpleNamespace(cycle=SimpleNamespace(period=period), flow=SimpleNamespace(size=49))
    return SimpleNamespace(parameter=log10_r, unstable=unstable, closed=closed)


def made(model, *found, points=()):
    return SimpleNamespace(
        model=model,
        onset=SimpleNamespace(parameter=-2.7),
        points=points or tuple(one.point for one in found),
        special=found,
        of_kind=lambda *kinds: [one for one in found if one.kind in kinds],
    )


def test_the_index_counts_what_no_point_explains():
    fold, torus = special("LP", -2.71, 1, 0), special("NS", -2.6, 0, 2)
    whole = (point(-2.7, 1), fold.point, point(-2.65, 0), torus.point, point(-2.5, 2))
    assert unaccounted(made("delay", fold, torus, points=whole)) == 0
    assert claims.index([made("delay", fold, torus, points=whole)]).outcome is Outcome.PASS
    missed = (*whole[:2], point(-2.65, 1), *whole[3:])
    assert unaccounted(made("delay", fold, torus, points=missed)) == 1
    assert claims.index([made("delay", fold, torus, points=missed)]).outcome is Outcome.FAIL
    wrong = special("PD", -2.6, 0, 2)
    assert unaccounted(made("delay", wrong, points=(point(-2.7, 0), wrong.point))) == 1


def test_coexisting_orbits_are_all_found():
    branch = branch_of("kelvin-voigt", -2.3, 61.0)
    periods = [orbit.cycle.period for orbit in branch.orbits_at(-2.7)]
    assert periods == pytest.approx([55.082257, 60.584973], abs=1e-5)
    assert branch.orbits_at(-2.69) == []
    shifted = replace(branch, onset=branch.onset._replace(parameter=branch.onset.parameter + 1e-8))
    assert outcomes(claims.published([branch, shifted])) == "pass fail"


def test_the_doubled_orbit():
    found = doubled()
    assert found.double.orbit.period.value == pytest.approx(158.1976822682, abs=1e-8)
    assert found.double.multipliers.stable is True
    assert found.single.multipliers.stable is False


def test_the_plain_block_repeats_a_printed_period_and_slides_where_it_should():
    """14 and 8 MPa: 9.70 s and 15.3 mm/s by the third fit; steady sliding by the second."""
    found = _cycle_without_tuning(_RUNS[6], _FITS[2][0])
    assert found
    assert (found["period"], found["peak"]) == (pytest.approx(9.70, rel=2e-3), pytest.approx(15.3, rel=0.03))
    assert 0.035 < found["drop"] < 0.041
    assert _cycle_without_tuning(_RUNS[1], _FITS[1][0]) is None


def test_the_rise_time_of_free_swinging_is_half_its_period():
    time = np.linspace(-1.0, 3.0, 4001)
    fall = np.where(time < 0.0, 1.0 + 1e-3 * time, np.where(time > 2.0, -1.0, np.cos(0.5 * math.pi * time)))
    assert _rise_time(time, fall) == pytest.approx(2.0, rel=2e-3)


@pytest.mark.parametrize("row", laboratory()["programs"]["rows"][2:], ids=["step", "hold"])
def test_friction_that_another_program_prints_is_ours_and_gives_its_parameters_back(row):
    apart, ratios = _fitted_to(row)
    assert 0.0 < apart < 1e-9  # nine digits are printed
    np.testing.assert_allclose(ratios, [1.0, 1.0, 1.0], atol=1e-6, rtol=0.0)
    friction = [value + 3e-9 * (k == 7) for k, value in enumerate(row["friction"])]
    wrong = _fitted_to({**row, "friction": friction})
    assert outcomes([*_program_verdicts(row, apart, ratios), *_program_verdicts(row, *wrong)]) == "pass pass fail pass"
    assert outcomes(_program_verdicts(row, apart, np.append(ratios[:2], 1.0 + 2e-5))) == "pass fail"
