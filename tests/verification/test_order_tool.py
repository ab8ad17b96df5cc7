"""The order assertion must be able to fail."""

from dataclasses import replace

import numpy as np
import pytest
from order import assert_order

from validation.measure.grid_ladders import LADDERS
from validation.measure.order_fit import fit_dense, fit_order
from validation.measure.orders import QUANTITIES, Climb

STEPS = 0.1 * 0.5 ** np.arange(6)


def test_interval_is_the_textbook_one():
    errors = STEPS**2 * np.exp([0.05, -0.05, 0.05, -0.05, 0.05, -0.05])
    x, y = np.log(STEPS), np.log(errors)
    centred = x - x.mean()
    slope = centred @ y / (centred @ centred)
    rest = y - y.mean() - slope * centred
    deviation = np.sqrt(rest @ rest / 4 / (centred @ centred))
    result = fit_order(1 / STEPS, errors)
    assert (result.used, result.order) == (slice(0, 6), pytest.approx(slope))
    assert result.half_width == pytest.approx(2.7764451 * deviation, rel=1e-6)  # Student t(0.975, 4)


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


CELLS = np.array([2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 17, 20, 24], dtype=float)


def test_dense_ladder_drops_what_bends_and_what_rounds():
    bent = CELLS**-4.0 * (1 + 40 / CELLS**2)
    found = fit_dense(CELLS, bent, floor=1e-5)
    assert found.used == slice(5, 11)  # six levels left of those above the floor
    assert found.order == pytest.approx(4.0, abs=0.6)
    straight = fit_dense(CELLS, 3 * CELLS**-4.0, start=2)
    assert (straight.order, straight.finest_error) == pytest.approx((4.0, 3 * CELLS[-1] ** -4.0), rel=1e-9)
    assert straight.half_width < 1e-9
    with pytest.raises(ValueError, match="3 usable"):
        fit_dense(CELLS, CELLS**-4.0, floor=1.01 * CELLS[3] ** -4.0)


def test_interval_of_a_dense_ladder_covers_the_truth():
    random = np.random.default_rng(2)
    found = [fit_dense(CELLS, CELLS**-6.0 * np.exp(0.5 * random.standard_normal(CELLS.size))) for _ in range(300)]
    covered = np.mean([abs(one.order - 6.0) < one.half_width for one in found])
    assert 0.85 < covered < 0.99  # a few windows are shortened by chance


def climbed(model, order, scatter=0.0):
    ladder, random = LADDERS[model], np.random.default_rng(3)
    cells = np.array(ladder.levels(), dtype=float)
    errors = {
        name: (8 * cells / cells[0]) ** -order * np.exp(scatter * random.standard_normal(cells.size)) for name in QUANTITIES
    }
    return Climb(ladder, cells, errors)


@pytest.mark.parametrize("right", [("dg:3", 4.0), ("dg:3", 6.3, 0.3), ("sbp:4", 3.95), ("fd", 2.02)], ids=str)
@pytest.mark.parametrize("wrong", [("dg:3", 3.8), ("dg:5", 5.0), ("sbp:4", 3.8), ("fd", 1.9), ("fd", 2.1)], ids=str)
def test_a_ladder_of_the_right_order_holds_and_of_the_wrong_one_not(right, wrong):
    assert [one for one in climbed(*right).shortfall() if "finest" not in one] == []
    assert sum("promised" in one for one in climbed(*wrong).shortfall()) == 6


@pytest.mark.parametrize(("bend", "wrong"), [(0.0, 0.0), (20.0, 0.0), (-20.0, 0.0), (0.0, 0.01), (20.0, 0.01)])
def test_an_order_approached_from_below_holds_and_a_wrong_limit_does_not(bend, wrong):
    """Errors of order 1 whose local orders rise to it (bend > 0) or fall, and of a scheme whose limit is off by `wrong`."""
    ladder = replace(LADDERS["dg:1"], declared=1.0, promised=1.0, finest=1.0)
    cells = np.geomspace(64.0, 256.0, 9).round()
    one = Climb(ladder, cells, dict.fromkeys(QUANTITIES, 20.0 / cells * np.exp(-bend / cells) + wrong))
    assert (one.shortfall() == []) is (wrong == 0.0)
    if (bend, wrong) == (20.0, 0.0):
        assert (one.fits["state"].order, one.fits["state"].limit) == (pytest.approx(0.87, abs=0.01), pytest.approx(1.0, abs=1e-6))


@pytest.mark.parametrize(
    ("order", "limit", "width", "leads"),
    [(0.9, 0.97, 0.05, True), (0.9, 0.94, 0.05, False), (0.9, 0.97, 0.2, False), (0.4, 0.97, 0.05, False)],
)
def test_where_local_orders_lead(order, limit, width, leads):
    assert replace(fit_order(1 / STEPS, STEPS), order=order, limit=limit, limit_half_width=width).leads_to(1.0) is leads


@pytest.mark.parametrize("name", QUANTITIES)
def test_a_single_output_of_order_6_is_no_order_8(name):
    """Scattered as much as the few grids of high orders do, so that its own interval reaches 8."""
    one = climbed("dg:7", 8.0)
    scatter = np.where(np.arange(one.cells.size) % 2, 1.0, 3.0)
    one.errors[name] = one.errors[name][0] * (one.cells / one.cells[0]) ** -6.0 * scatter
    found = one.fits[name]
    assert found.order == pytest.approx(6.0, abs=0.1)
    assert found.order + 1.5 * found.half_width > 8.0
    assert name in [complaint.split(":")[0] for complaint in one.shortfall()]


DOUBLED = np.array([16, 32, 64, 128, 256])


def test_coarse_levels_that_do_not_follow_yet_are_left_out():
    errors = DOUBLED**-2.0
    errors[0] *= 0.3
    result = fit_order(DOUBLED, errors)
    assert (result.used, result.order) == (slice(1, 5), pytest.approx(2.0))


def test_levels_at_rounding_are_left_out():
    """Below 100 machine epsilons, 2.2e-14, and not before."""
    errors = np.array([1e-10, 1e-11, 1e-12, 1e-13, 3e-15])
    assert fit_order(10.0 ** np.arange(1, 6), errors).used == slice(0, 4)
    assert fit_order(10.0 ** np.arange(1, 6), np.maximum(errors, 3e-14)).used.stop == 5
    assert fit_order(10.0 ** np.arange(1, 6), 1e3 * errors, scale=1e3).used == slice(0, 4)
    with pytest.raises(ValueError, match="2 usable levels"):
        fit_order(DOUBLED, np.array([1e-3, 1e-4, 0.0, 1e-9, 1e-9]))
