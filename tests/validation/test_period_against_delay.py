"""The period over the delay: what is shown, the verdicts from both sides, and the law for thick slabs."""

import math

import pytest
from test_quick_studies import held

import slipwave
from slipwave.observe.statistics import Estimate
from validation.studies.period_against_delay import measured
from validation.studies.period_against_delay.law import period_of
from validation.studies.period_against_delay.measured import Periods
from validation.study.memo import Means


@pytest.fixture(scope="module")
def result():
    return held("period-against-delay")


def test_the_long_run_on_the_torus_has_its_known_mean(result):
    """79.3225 (lifted shooting), around the unstable orbit's 79.3126."""
    mean = next(row for row in result.tables[1].rows if row[:2] == ("delay", -2.65))
    assert abs(mean[2] - 79.3225) < 2.0 * mean[3] < 0.1


def periods(ode=70.0, delay=73.0, block=76.0, mean=None, log10_r=-2.68):
    orbits = {"kelvin-voigt": [ode], "delay": [delay], "block8": [block], "block12": [block + 1.0]}
    return Periods(log10_r, orbits, {"delay": Means(mean, mean, 50)} if mean else {})


@pytest.mark.parametrize(
    ("changed", "outcome"),
    [
        ({}, "pass"),
        ({"ode": 73.5}, "finding"),
        ({"block": 72.5}, "finding"),
        ({"mean": Estimate(74.0, 0.9)}, "pass"),
        ({"mean": Estimate(74.0, 1.1)}, "finding"),
        ({"mean": Estimate(71.0, 0.6)}, "finding"),
    ],
)
def test_p7_counts_orbits_and_two_errors_of_means(changed, outcome):
    assert measured.order([periods(), periods(**changed)]).outcome == outcome


@pytest.mark.parametrize(("share", "outcome"), [(0.98, "pass"), (0.97, "fail"), (1.03, "fail")])
def test_the_law_is_judged_where_slabs_are_thickest(share, outcome):
    ratios = {model: {-2.5: 0.9, 0.0: share} for model in ("block8", "block12")}
    assert measured.thick(ratios).outcome == outcome


def test_the_law_for_thick_slabs():
    """Over the slip of an event loading and friction do the same work; the heavier block is slower and has the shorter period."""
    thick = slipwave.read("paper", {"slab.log10_r": 0.0})
    period = period_of(thick, "block12")
    drop = 2.8e-5 * 100.0 * period
    fastest = 3.0**0.5 * drop / 2.8e-5
    fall = 0.0349 * math.log(2.8e-3 / 0.0489) + 0.0489 * math.log(period) + 0.014 * math.log(fastest)
    work = fall * (drop / 2.8e-5 - 0.5 * math.log(period * fastest))
    assert work == pytest.approx(0.5 * drop * drop / 2.8e-5, rel=1e-10)
    assert period == pytest.approx(223.1, abs=0.1)
    assert period_of(thick, "block8") < period
