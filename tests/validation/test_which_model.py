"""The study of all models: its tables, verdicts from both sides, other scenes, periods over r and laws of the errors."""

import math

import numpy as np
import pytest
from shown import outcomes
from test_quick_studies import held

import slipwave
from slipwave.observe.statistics import Estimate
from validation.studies import which_model as study
from validation.studies.which_model import judged, laws, periods, scenes
from validation.studies.which_model.periods import Periods
from validation.study import Outcome
from validation.study.compared import EXACT_MODEL, critical_r
from validation.study.model_table import Compared, words_of
from validation.study.regimes import Regime


@pytest.mark.studies
def test_the_tables_have_every_model_at_every_r():
    """At log10 r = -2.65 the period is 79.3225 in the mean (lifted shooting); eight modes keep the torus."""
    result = held("which-model")
    table, elsewhere = result.model_tables
    assert [row.model for row in table.rows] == list(study.EVERY)
    assert [column.group for column in table.columns] == ["periodic"] * 3 + ["torus, irregular"] * 2
    assert [words_of(cell, "T") for cell in table.row("quasidynamic").cells][:3] == ["slides steadily"] * 3
    assert {cell.regime for cell in table.row("quasistatic").cells} == {"runs away"}
    assert table.row("quasidynamic").onset.value == pytest.approx(-2.6532125, abs=1e-7)
    assert (table.row("delay").advice, table.row("kelvin-voigt").advice) == ("use", "avoid")
    at = {row.model: row.cells[3] for row in table.rows}
    assert [at[model].regime for model in ("delay", "modal:8", "kelvin-voigt")] == ["torus", "torus", "periodic"]
    damped, mean = at["quasidynamic"].figures, at["delay"].figures["T"]
    assert (damped["T"].value, damped["Δμ"].value) == pytest.approx((48.371789354, 0.0221755339), rel=1e-8)
    assert result.numbers["quasidynamic T at -2.65"].value == damped["T"].value
    assert abs(mean.value - 79.3225) < 2.0 * mean.standard_error * mean.value < 0.1
    assert (at["kelvin-voigt"].figures["T"].value, at["kelvin-voigt"].right) == (pytest.approx(75.30034, abs=1e-5), False)
    tried = {row.model: [column.title for column, *_ in judged.cells_of(elsewhere, row.model)] for row in elsewhere.rows}
    assert (tried["modal:8"], tried["fitted:4"]) == (["unlike", "rock"] * 2, ["grip"] * 2)
    assert {row.model for row in elsewhere.rows if row.advice == "avoid"} >= {"kelvin-voigt", "block12", "quasistatic"}


@pytest.mark.parametrize("name", ["unlike", "grip", "rock"])
def test_the_settings_of_a_place_make_its_scene(name):
    """Both slabs scaled together, 1.1 times the onset; the column names the options that repeat it."""
    column, scene = scenes.place(name, 1.1)
    first, *options = [word for word in column.settings.split() if word != "--set"]
    again = slipwave.read(first, options)
    for slab, other in zip(again.slabs, scene.slabs, strict=True):
        assert (slab.round_trip, slab.epsilon) == pytest.approx((other.round_trip, other.epsilon), rel=1e-5)
    assert again.start == scene.start
    assert scene.transit == pytest.approx(1.1 * critical_r(EXACT_MODEL, again), rel=1e-4)
    assert 10.0**column.log10_r == pytest.approx(scene.transit)


def test_bias_and_scatter_of_errors():
    errors = [Compared(70.0, off, bar) for off, bar in ((-0.03, 0.003), (-0.05, 0.004), (-0.04, 0.0))]
    assert scenes.bias_and_scatter(errors) == pytest.approx((-0.04, 0.01, math.sqrt(25e-6 / 3.0)))
    assert all(map(math.isnan, scenes.bias_and_scatter([])))
    assert scenes.bias_in_words(-0.0394, 0.0051) == "−3.9 ± 0.5 %"
    assert scenes.bias_in_words(-0.37, math.nan) == "−37.0 %"


def figures(period, drop=0.3, error=0.0):
    return {"T": Estimate(period, error), "Δμ": Estimate(drop, 0.0), "v_{max}": Estimate(4000.0, 0.0)}


def a_table(regimes, places=(-2.68, -2.5)):
    return study._the_table({model: dict(zip(places, found, strict=True)) for model, found in regimes.items()}, {})


@pytest.mark.parametrize(("off", "outcome"), [(0.019, "pass"), (-0.019, "pass"), (0.021, "fail"), (-0.021, "fail")])
def test_means_may_differ_by_four_standard_errors(off, outcome):
    """Of 100 known to 0.3 and 0.4: 0.5 %."""
    exact = Regime("irregular", figures(100.0, error=0.3) | {"Δμ": Estimate(0.3, 0.01)}, 90)
    other = Regime("irregular", figures(100.0 * (1.0 + off), error=0.4 * (1.0 + off)) | {"Δμ": Estimate(0.3, 0.01)}, 90)
    repeats = Regime("periodic", figures(70.0))
    table = a_table({"delay": [repeats, exact], "dg:7": [repeats, exact], "modal:8": [repeats, other]})
    assert outcomes(judged.mean_verdicts(table)) == outcome


@pytest.mark.parametrize(("off", "outcome"), [(8e-9, "pass"), (1e-8, "fail"), (-1e-8, "fail")])
def test_a_run_may_differ_from_its_orbit_by_its_own_error(off, outcome):
    """Four of its errors of 1e-9, and 5e-9 for the tolerance of the run."""
    ran = figures(100.0 * (1.0 + off), error=1e-7)
    assert outcomes(judged.run_verdict({"block8": {-2.68: Regime("periodic", figures(100.0), 0, ran)}})) == outcome


@pytest.mark.parametrize(("off", "outcome"), [(1.9, "pass"), (-2.1, "fail")])
def test_a_wave_may_differ_by_what_its_coarser_grid_leads_to(off, outcome):
    """Of order 8: cells of 2/3 leave (2/3)^8, and twice that is allowed."""
    exact = Regime("periodic", figures(100.0))
    step = 1e-3 * (2.0 / 3.0) ** 8
    fine, coarse = (Regime("periodic", figures(100.0 * (1.0 + share), 0.3 * (1.0 + share))) for share in (off * step, 1e-3))
    table = a_table({"delay": [exact] * 2, "dg:7": [fine] * 2})
    found = judged.wave_verdicts(table, lambda column: coarse, 3, 0.0)
    assert outcomes(found) == f"{outcome} {outcome}"


def at_one_r(ode=70.0, delay=73.0, block=76.0, mean=None):
    """Periods at one r; of the delay system also a mean."""
    values = {"kelvin-voigt": ode, "delay": delay, "block8": block, "block12": block + 1.0}
    found = {model: {-2.68: Periods([], Estimate(value, 0.0), 0, None)} for model, value in values.items()}
    return found | ({"delay": {-2.68: Periods([], mean, 50, None)}} if mean else {})


@pytest.mark.parametrize(
    ("changes", "outcome"),
    [
        ({}, "pass"),
        ({"ode": 73.5}, "finding"),
        ({"block": 72.5}, "finding"),
        ({"mean": Estimate(74.0, 0.9)}, "pass"),
        ({"mean": Estimate(74.0, 1.1)}, "finding"),
        ({"mean": Estimate(71.0, 0.6)}, "finding"),
    ],
)
def test_p7_counts_orbits_and_means_within_two_of_their_errors(changes, outcome):
    assert outcomes(next(periods.period_verdicts(at_one_r(**changes)))) == outcome


@pytest.fixture(scope="module")
def onsets():
    return laws.measure_onsets(slipwave.read("paper"))


def test_onset_errors_fall_at_the_laws_power(onsets):
    for model, one in onsets.items():
        small = abs(one.error) > 1e-11  # below, the error of r_c itself is rounding
        index = int(small.nonzero()[0][-1])
        if model != "quasidynamic":
            assert one.ratio(index) == pytest.approx(1.0, abs=0.01)
    assert {verdict.outcome for verdict in laws.law_verdicts(onsets, ())} == {Outcome.PASS}


@pytest.mark.parametrize("model", laws.MODELS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_how_far_an_error_may_be_from_its_law(onsets, model, sign):
    """By a next term, which falls as theta^2, or theta for the quasi-dynamic law; not by a factor that is one per cent off."""
    one = onsets[model]
    law = np.array([one.law.at(float(theta)) for theta in one.theta])
    term = 0.1 * (one.theta / one.theta[0]) ** (1 if model == "quasidynamic" else 2)
    wrong = [next(laws.law_verdicts({model: one._replace(error=law * (1.0 + sign * off))}, ())).outcome for off in (term, 0.01)]
    assert wrong == [Outcome.PASS, Outcome.FAIL]


def test_the_cycles_error_does_not_fall():
    measured = [laws.measure_cycle(slipwave.read("paper"), scale) for scale in (1.0, 0.5)]
    assert [one.error() for one in measured] == pytest.approx([-0.0318, -0.0292], abs=2e-4)
    assert [one.outcome for one in laws.law_verdicts({}, measured)] == [Outcome.FINDING]


@pytest.mark.parametrize(("last", "outcome"), [(2.4e-3, "pass"), (2.6e-3, "finding"), (2e-2, "finding")])
def test_an_error_that_falls_with_theta_must_more_than_halve_beside_it(last, outcome):
    pairs = ((0.2, -1e-2), (0.1, last))
    cycles = [laws.CycleErrors(1.0, theta, 7.0, {"kelvin-voigt": Compared(70.0, error, 0.0)}) for theta, error in pairs]
    assert outcomes(laws.law_verdicts({}, cycles)) == outcome
