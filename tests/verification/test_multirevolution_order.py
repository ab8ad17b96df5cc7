"""The order of the multirevolution method, on a map whose iterates are known by doing all of them."""

from itertools import pairwise

import numpy as np
import pytest
from order import assert_order

from reduced.delay.multirevolution import Past, sum_rules
from reduced.delay.stroboscopic_kernel import sum_of_new, turns, weights_of_sum

RATE, LAST, ORDER = 1e-4, 30_000, 6
LENGTHS = {6: np.array([600, 500, 400, 300, 200]), 8: np.array([625, 500, 400, 320, 300])}
"""By order: that of alike slabs' leaps, and that of leaps over blocks."""


def change(state):
    """What one transit does to two states: logistic growth, and a decay that it drives."""
    return RATE * np.array([state[0] * (1.0 - state[0]), state[0] ** 2 - 0.5 * state[1]])


def every_transit():
    states = [np.array([0.2, 1.0])]
    for _ in range(LAST):
        states.append(states[-1] + change(states[-1]))
    return states


EVERY = every_transit()


def known(number):
    """The latest transits, of these numbers, as the march knows them."""
    order = len(number)
    return Past(order, np.array(number, dtype=float), np.array([change(EVERY[n]) for n in number]), np.zeros((order, 1)))


def leapt(length, order):
    """The state at LAST by leaps of equal `length` from known transits."""
    number = np.arange(LAST % length, LAST + 1, length)
    past, state = known(number[:order]), EVERY[number[order - 1]]
    for now, target in pairwise(number[order - 1 :].tolist()):
        state = state + past.change[-1] + past.total(now + 1.0, target)
        past = past.then(target, change(state), np.zeros(1))
    return state


def estimate(length, order):
    """Of a leap from the middle; it is the difference between both sums."""
    middle = LAST // 2
    past = known(middle + length * np.arange(1 - order, 1))
    longer = past.then(middle + length, change(EVERY[middle + length]), np.zeros(1))
    first, target = middle + 1.0, middle + length
    found = past.error(first, target, longer.change[-1])
    assert found == pytest.approx(longer.total(first, target) - past.total(first, target), abs=1e-15)
    return np.abs(found).max()


@pytest.mark.parametrize("order", LENGTHS)
def test_leaps_have_the_declared_order(order):
    lengths = LENGTHS[order]
    errors = [np.abs(leapt(length, order) - EVERY[LAST]).max() for length in lengths]
    assert_order(errors, lengths, order, tolerance=0.4, absolute=1e-10)


@pytest.mark.parametrize("order", LENGTHS)
def test_the_estimated_error_of_a_leap_is_one_order_smaller(order):
    lengths = LENGTHS[order]
    errors = [estimate(length, order) for length in lengths]
    assert_order(errors, lengths, order + 1, tolerance=0.4, absolute=1e-10)


@pytest.mark.parametrize("last", [62.0, 63.0, 64.0, 150.0])
def test_sums_are_exact_for_polynomials(last):
    """Transits at unequal distances, as the control of the error makes them; sums of one, two, three and many terms."""
    past = Past(ORDER, np.empty(0), np.empty((0, 1)), np.empty((0, 1)))
    for n in (7.0, 11.0, 12.0, 20.0, 44.0, 60.0):
        past = past.then(n, np.array([(n / 50.0) ** 5 - n]), np.zeros(1))
    ahead = np.arange(61.0, last)
    assert abs(past.total(61.0, last)[0] / np.sum((ahead / 50.0) ** 5 - ahead) - 1.0) < 1e-10


def test_peaks_between_two_transits_are_found():
    """Two of four quantities turn at 51.3 and 44.8, one turned before 44, one rises all the time; twice the same counts once."""
    past = Past(ORDER, np.empty(0), np.empty((0, 1)), np.empty((0, 5)))
    for n in (7.0, 11.0, 12.0, 20.0, 44.0, 60.0):
        past = past.then(
            n, np.zeros(1), np.array([-((n - 51.3) ** 2), -((n - 44.8) ** 2), -((n - 30.0) ** 2), n, 2 * n - n**2 / 102.6])
        )
    assert (past.peaks(44.0, 60.0), past.peaks(59.0, 60.0)) == ([45.0, 51.0], [])
    assert past._replace(highest=-past.highest).peaks(44.0, 60.0) == []


@pytest.mark.parametrize("distance", [1, 2, 3, 40])
def test_compiled_leaps_are_those_in_plain_numpy(distance):
    """Sums over what a leap leaves out, what the block after it changes in them, and the blocks in which something turns."""
    number, random = np.array([3.0, 5.0, 12.0, 20.0, 24.0, 30.0]), np.random.default_rng(distance)
    past, new = Past(ORDER, number, random.random((ORDER, 3)), random.random((ORDER, 4))), random.random(3)
    first, last = 31.0, 31.0 + distance
    later = past.then(last, new, random.random(4))
    rule = [table[distance] for table in sum_rules(ORDER)]
    assert weights_of_sum(number, first, *rule) @ past.change == pytest.approx(past.total(first, last), rel=1e-12)
    change = sum_of_new(later.number, first, *rule) * (new - past._rows(np.array([last]))[0] @ past.change)
    assert change == pytest.approx(past.error(first, last, new), rel=1e-12)
    assert turns(later.number, later.highest).tolist() == later.peaks(number[-1], last)
