"""Margins of means over cycles that depend on each other, against signals whose mean is known."""

from dataclasses import asdict

import numpy as np
import pytest
from scipy.stats import t

from slipwave.observe.events import Events
from slipwave.observe.statistics import BATCHES, FEWEST, _quantile, margin_of_mean, median_of, summarise

RUNS = 400


def autoregressive(memory, count):
    """Rows with mean 0 and correlation memory^k between values k apart."""
    noise = np.random.default_rng(11).standard_normal((RUNS, count + 100))
    rows = noise.copy()
    for k in range(1, count + 100):
        rows[:, k] += memory * rows[:, k - 1]
    return rows[:, 100:]


@pytest.mark.parametrize("freedom", [3.0, 3.7, 5.0, 20.5, 1e3, 1e5])
def test_quantiles_are_those_of_students_distribution(freedom):
    assert _quantile(freedom) == pytest.approx(t.ppf(0.975, freedom), rel=1e-9)


def covered(rows):
    """The share of rows whose mean differs from 0 by no more than its margin."""
    return float(np.mean([abs(row.mean()) <= margin_of_mean(row) for row in rows]))


@pytest.mark.parametrize("memory", [-0.7, 0.0, 0.5])
@pytest.mark.parametrize("count", [64, 256])
def test_the_true_mean_is_within_the_margin_in_95_of_100_runs(memory, count):
    assert 0.93 <= covered(autoregressive(memory, count)) <= 0.995


@pytest.mark.parametrize("memory", [0.9, 0.95])
def test_a_run_that_is_a_few_times_as_long_as_its_memory(memory):
    """Of 100 values; 87 of 100 with a memory of 0.95 without the margin by a fading memory."""
    assert covered(autoregressive(memory, 100)) >= 0.93


def test_few_cycles_that_resemble_each_other():
    """Of 24 values with memory 0.5, 95 of 100 means lie within the margin; 92 by batches alone, and without the corrections of
    what a short run takes from its autocorrelations."""
    assert covered(autoregressive(0.5, 24)) >= 0.935


def test_by_hand():
    """Batches of two with means 1, 2, ..., 6, in an order without memory: their deviation is sqrt(3.5). Neighbours
    alternate, so that the autocorrelations of one pair of lags say nothing."""
    values = np.repeat([1.0, 6.0, 3.0, 5.0, 4.0, 2.0], 2) + np.tile([10.0, -10.0], BATCHES)
    assert margin_of_mean(values) == pytest.approx(2.570581836 * np.sqrt(3.5) / np.sqrt(6.0), rel=1e-9)
    assert np.isnan(margin_of_mean(values[: FEWEST - 1]))


def test_autocorrelations_by_hand():
    """Of 0, 0, 1, 1, ... covariances times 64 are 16, 1, -14, ...: with one pair of lags, a window of 3 in 16, the variance is
    (2 17 - 16)/64 over 1 - 3/16, known as that of 16/3 values."""
    variance = 18.0 / 64.0 / (1.0 - 3.0 / 16.0)
    expected = t.ppf(0.975, 16.0 / 3.0) * np.sqrt(variance / 16.0)
    assert margin_of_mean(np.tile([0.0, 0.0, 1.0, 1.0], 4)) == pytest.approx(expected, rel=1e-9)


def test_only_cycles_that_never_repeat_have_margins():
    column = np.linspace(1.0, 2.0, 16)
    events = Events(*[column] * 6)
    assert all(np.isnan(margin) for margin in asdict(summarise(events).margins).values())
    assert asdict(summarise(events, repeat=False).margins) == dict.fromkeys(
        ("period", "stress_drop", "elastic_stress_drop"), margin_of_mean(column)
    ) | {"v_max_median": 2.0 * median_of(column).error}
