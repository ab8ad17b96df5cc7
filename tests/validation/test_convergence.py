"""Fitted orders on errors whose order is known."""

import numpy as np
import pytest

from validation.measure.order_fit import fit_dense, fit_order, shortfall

CELLS = np.array([16, 32, 64, 128, 256])


@pytest.mark.parametrize("order", [1.0, 2.0, 4.8])
def test_exact_power(order):
    result = fit_order(CELLS, 3.0 * CELLS**-order)
    assert result.order == pytest.approx(order, abs=1e-9)
    assert result.constant == pytest.approx(3.0, rel=1e-9)
    assert result.half_width < 1e-9
    assert result.finest == pytest.approx(order)
    assert not shortfall(result, order)
    assert shortfall(result, order + 0.2)


def test_interval_covers_the_truth_about_as_often_as_it_says():
    random = np.random.default_rng(1)
    noisy = [fit_order(CELLS, CELLS**-2.0 * np.exp(0.02 * random.standard_normal(5))) for _ in range(400)]
    full = [one for one in noisy if one.used == slice(0, 5)]
    covered = np.mean([abs(one.order - 2.0) < one.half_width for one in full])
    assert 0.90 < covered < 0.99


def test_coarse_levels_that_do_not_follow_yet_are_left_out():
    errors = CELLS**-2.0
    errors[0] *= 0.3
    result = fit_order(CELLS, errors)
    assert result.used == slice(1, 5)
    assert result.order == pytest.approx(2.0)


def test_levels_at_rounding_are_left_out():
    """Below 100 machine epsilons, 2.2e-14, and not before."""
    errors = np.array([1e-10, 1e-11, 1e-12, 1e-13, 3e-15])
    assert fit_order(10.0 ** np.arange(1, 6), errors).used == slice(0, 4)
    assert fit_order(10.0 ** np.arange(1, 6), np.maximum(errors, 3e-14)).used.stop == 5
    assert fit_order(10.0 ** np.arange(1, 6), 1e3 * errors, scale=1e3).used == slice(0, 4)
    with pytest.raises(ValueError, match="2 usable levels"):
        fit_order(CELLS, np.array([1e-3, 1e-4, 0.0, 1e-9, 1e-9]))


def test_a_dense_ladder_of_an_exact_power_has_its_order_at_the_finest_pair_too():
    found = fit_dense(np.arange(20, 40), 3.0 * np.arange(20, 40) ** -4.0)
    assert (found.order, found.finest) == pytest.approx((4.0, 4.0), abs=1e-9)
