import dataclasses
import math

import pytest
from shown import outcomes
from test_quick_studies import held

from reduced.impedance import reduction_of
from slipwave.observe.statistics import Estimate
from validation.studies import study_called
from validation.studies import which_model as measured
from validation.studies.one_cycle import at_r
from validation.studies.which_model import error_against_delay, omissions
from validation.study import Outcome
from validation.study.model_table import words_of
from validation.study.regimes import CycleFigures

STUDY = study_called("which-model")


def figures(period, drop, period_error=0.0, drop_error=0.0):
    return CycleFigures(Estimate(period, period_error), Estimate(drop, drop_error), Estimate(4000.0, 0.0))


def test_an_error_with_its_own_error():
    """A quotient of 1.1 whose parts are known to 3 and 4 thousandths is known to 5 thousandths of itself."""
    runs = {"delay": {-2.5: figures(100.0, 0.3, 0.4)}, "modal:8": {-2.5: figures(110.0, 0.3, 0.33)}}
    found = error_against_delay(runs, "modal:8", -2.5, "period")
    assert (found.value, found.error) == (pytest.approx(0.1, rel=1e-12), pytest.approx(1.1 * 0.005, rel=1e-12))
    assert error_against_delay(runs, "modal:8", -2.5, "drop") == Estimate(0.0, 0.0)


def test_a_model_that_found_no_orbit_has_no_error():
    runs = {"delay": {-2.6: figures(80.0, 0.2)}, "block8": {-2.6: None}}
    assert math.isnan(error_against_delay(runs, "block8", -2.6, "period").value)
    every = {model: {-2.6: figures(80.0, 0.2)} for model in ("delay", *measured.MODELS)}
    assert omissions(every) == ()
    assert omissions(every | {"block8": {-2.6: None}})[0].why == "`block8` at −2.6."


@pytest.mark.parametrize(
    ("log10_r", "period", "drop"), [(-2.6, 51.4018, 0.07281), (-2.5, 51.4016, 0.09266), (-2.3, 47.7803, 0.10818)]
)
def test_the_quasi_dynamic_model_sticks_and_slips_beyond_its_onset(log10_r, period, drop):
    found = measured.own_figures_of(measured.DAMPED, log10_r)
    assert (found.period.value, found.drop.value) == pytest.approx((period, drop), rel=1e-4)
    beside = at_r(measured.DAMPED, log10_r)
    assert (beside.period.value, beside.cycles) == (pytest.approx(found.period.value, rel=1e-9), 0)


@pytest.mark.studies
def test_the_table_has_every_model_at_every_r():
    """At log10 r = -2.65 the period is 79.3225 in the mean (lifted shooting); eight modes keep the torus."""
    result = held("which-model")
    (table,) = result.model_tables
    assert [row.model for row in table.rows] == list(STUDY.EVERY)
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


@pytest.mark.parametrize(
    ("steady", "period", "expected"),
    [
        (None, 51.4, "pass pass"),
        (None, 66.0, "pass fail"),
        (None, 36.0, "pass fail"),
        ((48.0, 0.1), 51.4, "fail pass"),
        (None, None, "fail fail"),
    ],
)
def test_where_the_quasi_dynamic_model_sticks_and_slips_is_judged(steady, period, expected):
    """Onset at -2.6532; 94 transits in the exact system."""
    orbits = {measured.DAMPED: {-2.66: steady and figures(*steady)}}
    means = {measured.DAMPED: {-2.5: period and figures(period, 0.1)}, "delay": {-2.5: figures(94.0, 0.3)}}
    assert outcomes(measured.damped_claims(orbits, means, figures(51.4, 0.1))).startswith(expected)


@pytest.mark.parametrize(("off", "outcome"), [(0.019, "pass"), (-0.019, "pass"), (0.021, "fail"), (-0.021, "fail")])
def test_means_may_differ_by_four_standard_errors(off, outcome):
    """Of 100 known to 0.3 and 0.4: 0.5 %."""
    other = {-2.5: figures(100.0, 0.3, 0.4, 0.01)}
    means = {"delay": {-2.5: figures(100.0, 0.3, 0.3, 0.01)}, "modal:4": other, "dg:7": other}
    means["modal:8"] = {-2.5: figures(100.0 * (1.0 + off), 0.3, 0.4 * (1.0 + off), 0.01)}
    assert next(measured.mean_claims(means, {"modal:4": figures(100.0, 0.3)})).outcome == outcome


@pytest.mark.parametrize(
    ("field", "off", "outcome"),
    [("frequencies", 1e-13, "pass"), ("frequencies", 1e-12, "fail"), ("residues", 4e-12, "pass"), ("residues", -2e-11, "fail")],
)
def test_a_fit_must_find_the_modes(monkeypatch, field, off, outcome):
    """One mode displaced: a fit of the impedance knows nothing of it."""
    true = reduction_of(measured.scene_at(-2.68), "fitted:4")
    values = tuple(value * (1.0 + off * (k == 2)) for k, value in enumerate(getattr(true, field)))
    monkeypatch.setattr(measured, "reduction_of", lambda *args: dataclasses.replace(true, **{field: values}))
    assert measured.fitted_modes("fitted:4").outcome == outcome


def test_no_mode_is_the_block(monkeypatch):
    blocks = iter(reduction_of(measured.scene_at(-2.68), name) for name in ("block8", "block12"))
    assert measured.no_modes().outcome is Outcome.PASS
    monkeypatch.setattr(measured, "reduction_of", lambda *_: next(blocks))
    assert measured.no_modes().outcome is Outcome.FAIL
