"""Errors of means against sequences whose variance is known."""

import numpy as np
import pytest

from validation.measure.correlated import mean_of


def sequence(memory, count, seed):
    """x_n = memory x_(n - 1) + a normal number, about 5."""
    drawn = np.random.default_rng(seed).normal(size=count)
    values = np.empty(count)
    values[0] = drawn[0] / np.sqrt(1.0 - memory**2)
    for n in range(1, count):
        values[n] = memory * values[n - 1] + drawn[n]
    return 5.0 + values


@pytest.mark.parametrize("memory", [0.0, 0.8, -0.5])
def test_twice_the_error_of_a_mean_of_dependent_values_is_a_margin_of_95_in_100(memory):
    """Means are spread by 1/((1 - memory) sqrt(n)). That of independent values would be wrong by a factor of 3 at 0.8."""
    found = [mean_of(sequence(memory, 4000, seed)) for seed in range(40)]
    known = 1.0 / ((1.0 - memory) * np.sqrt(4000.0))
    assert 1.0 * known < np.mean([one.error for one in found]) < 1.4 * known
    assert np.sqrt(np.mean([(one.value - 5.0) ** 2 for one in found])) == pytest.approx(known, rel=0.3)


def test_the_error_holds_the_mean_of_a_sequence_that_alternates():
    """Autocorrelations alone hold that of 83 in 100 short ones: pairs of lags cancel."""
    found = [mean_of(sequence(-0.8, 60, seed)) for seed in range(200)]
    assert np.mean([abs(one.value - 5.0) <= 2.0 * one.error for one in found]) >= 0.95


@pytest.mark.parametrize(("values", "mean"), [(np.tile([3.0, 1.0], 12), 2.0), (np.full(9, 2.5), 2.5)])
def test_a_sequence_that_repeats_has_no_error(values, mean):
    found = mean_of(values)
    assert found.value == pytest.approx(mean, abs=1e-14)
    assert found.error < 1e-7
