"""The two studies of convergence: what they measure, outcomes on both sides of every limit, answers, tables, figures."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from shown import judged, outcomes, quick, too_roomy

from fullwave.families import GALERKIN
from reduced.delay.alike import Delay
from slipwave.observe.statistics import Estimate
from validation.compute.build import build
from validation.measure import stopwatch
from validation.measure.grid_ladders import GENTLE, LADDERS, ROUGH, STEEP, in_space
from validation.measure.grids.in_space import delay_reference, without_error_in_time
from validation.measure.orders import QUANTITIES, Climb, climb, errors, measure
from validation.studies import grid_convergence
from validation.studies.grid_convergence import in_time, orbits, shared
from validation.study import Outcome
from validation.study.grid_verdicts import order_verdict


def test_an_order_ends_where_rounding_begins():
    """The finest error above the floor counts; the second grid in any case."""
    family = [orbits.GridOrbit("dg:7", cells, error, error) for cells, error in ((2, 1e-4), (4, 1e-7), (8, 1e-10), (16, 2e-13))]
    assert orbits.orbit_order(family, "period") == pytest.approx(np.log(1e6) / np.log(4.0))
    assert orbits.orbit_order([family[0], family[3]], "period") == pytest.approx(np.log(5e8) / np.log(8.0))


WAVE, DELAY = (orbits._WAVE, orbits._WAVE_CELLS), ("delay", None)


@pytest.mark.parametrize(
    ("model", "figure", "outcome"),
    [(WAVE, "", "pass"), *((model, figure, "fail") for model in (WAVE, DELAY) for figure in ("period", "stress_drop"))],
)
def test_means_of_a_displaced_model_are_red(model, figure, outcome, monkeypatch):
    """400 irregular cycles with a spread of 1 % for each model; one figure of one model is displaced by 2 % in turn."""
    draw = {WAVE: np.random.default_rng(1).standard_normal, DELAY: np.random.default_rng(2).standard_normal}

    def cycles(name, scene, until, cells):
        drawn = {key: value * (1.0 + 0.01 * draw[name, cells](400)) for key, value in (("period", 80.0), ("stress_drop", 0.2))}
        return SimpleNamespace(**drawn | ({figure: 1.02 * drawn[figure]} if (name, cells) == model and figure else {}))

    monkeypatch.setattr(orbits, "late_cycles", cycles)
    (found,) = orbits.as_r_grows((), (-2.5,))
    assert (found.cycles, outcomes(orbits.growth_verdicts([found]))) == (400, outcome)


@pytest.fixture(scope="module")
def exact():
    return measure(build("delay", GENTLE.scene, tolerance=1e-12), GENTLE)


def test_two_delay_runs_differ_by_less_than_the_floor(exact):
    other = measure(build("delay", GENTLE.scene, tolerance=1e-13), GENTLE)
    assert max(errors(other, exact).values()) < GENTLE.floor
    assert exact["period"].size == 10
    fewer = {name: values[1:] if name != "state" else values for name, values in exact.items()}
    assert (errors(fewer, exact)["period"], errors(fewer, exact)["state"]) == (np.inf, 0.0)


def test_a_run_that_is_remembered_reads_no_clock(monkeypatch):
    """Otherwise run times by a clock that counts its readings depend on what the process ran before."""
    monkeypatch.setattr(stopwatch, "processor_seconds", lambda: pytest.fail("read"))
    assert measure(build("fd", GENTLE.scene, cells=24), GENTLE)["period"].size


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


def test_high_orders_are_read_on_the_steepest_scene():
    for model, ladder in LADDERS.items():
        steep = model in {"fem:6", "fem:7", "dg:6", "dg:7"}
        assert in_space(ladder).run.scene is (STEEP if steep else ladder.run).scene


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


def climbed(model="sbp:4", order=4.0):
    ladder = replace(LADDERS[model], finest=1.0)
    cells = np.array(ladder.levels(), dtype=float)
    return Climb(ladder, cells, np.ones(cells.size), dict.fromkeys(QUANTITIES, (4 * cells / cells[0]) ** (-order)))


def test_a_ladder_without_an_order_is_named_and_the_others_keep_their_rows():
    right, lost = climbed(), "no order: 0 usable levels; an order needs 4"
    none = replace(
        right, ladder=replace(right.ladder, model="fv"), errors=dict.fromkeys(QUANTITIES, np.full(right.cells.size, np.inf))
    )
    verdict = order_verdict(none)
    assert (verdict.outcome, verdict.ours, verdict.remark) == (Outcome.FAIL, lost, "`fv`")
    rows = grid_convergence.orders_table([none, right], [replace(GALERKIN, pattern="volumes:P", ladder={})]).rows
    assert [(row[0], row[-1]) for row in rows] == [
        ("fv", lost),
        ("sbp:4", "4.00\u00a0±\u00a00.01"),
        ("volumes:7", "not judged: declares no ladder"),
    ]


def test_every_family_with_a_ladder_is_judged_by_a_quick_report(monkeypatch):
    own = replace(GALERKIN, pattern="volumes", numbers=(), default=None, ladder={0: GALERKIN.ladder[1]})
    monkeypatch.setattr(grid_convergence, "GRIDS", (*grid_convergence.GRIDS, own, replace(own, pattern="bare", ladder={})))
    assert grid_convergence.judged_models(quick=True) == (*grid_convergence._QUICK, "volumes")
    assert set(grid_convergence.judged_models(quick=False)) == set(LADDERS)


def test_which_code_is_common_is_read_from_the_imports():
    march = {"fullwave.lines.march", "fullwave.lines.kernel"}
    assert march <= set(shared("sbp", "dg"))
    assert not march & set(shared("fd", "dg"))
    assert shared("delay", "fem") == ()


def beside(off, error=0.0, cycles=0):
    """Periods 80 and drops 0.2, the wave's period off by a share, both periods known to an error."""
    wave = (Estimate(80.0 * (1.0 + off), error), Estimate(0.2, 1e-3))
    return orbits.OnBoth(-2.5, wave, (Estimate(80.0, error), Estimate(0.2, 1e-3)), cycles, orbits._ERRORS if cycles else 5e-10)


@pytest.mark.parametrize(
    ("outcome", "case"),
    [
        ("pass", (4.5e-10,)),
        ("fail", (-5.5e-10,)),
        *(("fail", (off, 0.1, 50)) for off in (0.0, -0.0072)),
        ("pass", (0.0069, 0.1, 50)),
    ],
)
def test_orbits_and_means_of_the_full_wave_are_held_against_the_delay_systems(outcome, case):
    """Four standard errors of 0.1 sqrt(2) are 0.0071 of 80; one without any difference is a run beside itself."""
    assert outcomes(orbits.growth_verdicts([beside(*case)])) == outcome


@pytest.mark.slow
@pytest.mark.parametrize("name", ["leapfrog-convergence", "grid-convergence"])
def test_a_quick_run_holds_and_counterfeits_turn_it_red(name):
    verdicts = quick(name).verdicts
    assert {verdict.outcome for verdict in verdicts} == {Outcome.PASS}
    assert too_roomy([verdict for verdict in verdicts if "order" not in verdict.claim]) == []
