"""The order assertion must be able to fail."""

import numpy as np
import pytest
from order import assert_order

from validation.convergence import extrapolated, fit, shortfall

STEPS = 0.1 * 0.5 ** np.arange(6)


@pytest.mark.parametrize("order", [1, 2, 4, 7])
def test_exact_power_passes(order):
    result = assert_order(3 * STEPS**order, STEPS, order, tolerance=1e-6)
    assert result.r_squared == pytest.approx(1.0)


def test_interval_is_the_textbook_one():
    errors = STEPS**2 * np.exp([0.05, -0.05, 0.05, -0.05, 0.05, -0.05])
    x, y = np.log(STEPS), np.log(errors)
    centred = x - x.mean()
    slope = centred @ y / (centred @ centred)
    rest = y - y.mean() - slope * centred
    deviation = np.sqrt(rest @ rest / 4 / (centred @ centred))
    result = fit(1 / STEPS, errors)
    assert result.used == slice(0, 6)
    assert result.order == pytest.approx(slope)
    assert result.half_width == pytest.approx(2.7764451 * deviation, rel=1e-6)  # Student t(0.975, 4)


def test_verdicts():
    clean = fit(1 / STEPS, STEPS**2)
    assert shortfall(clean, 2) == ""
    assert "declared 3" in shortfall(clean, 3)
    assert "declared 1" in shortfall(clean, 1)
    assert shortfall(clean, 1, at_least=True) == ""


@pytest.mark.parametrize(
    ("errors", "message"),
    [
        (STEPS**1.8, "declared 2"),
        (STEPS**2 * np.array([1, 30, 1, 30, 1, 30]), "too wide"),
        (STEPS**2, "not below"),
        (STEPS[:3] ** 2, "four levels"),
    ],
)
def test_a_wrong_order_size_or_noise_is_caught(errors, message):
    with pytest.raises(AssertionError, match=message):
        assert_order(errors, STEPS[: errors.size], 2, absolute=1e-9)


def test_extrapolation():
    assert extrapolated(5 + 0.1**2, 5 + 0.05**2, 2) == pytest.approx(5.0, abs=1e-14)
