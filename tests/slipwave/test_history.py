"""The window observer: what it keeps is the solver's own polynomials, wherever and however often it is asked."""

import numpy as np
import pytest

import slipwave
from slipwave.observe import HistoryObserver
from slipwave.observe.history import values_at
from slipwave.observe.pieces import Pieces, lagrange_basis

LAW = slipwave.read("paper").law
NODES = np.array([0.2, 0.7, 1.0])


def motion(time):
    """z, psi, mu and y, quadratic in time: three nodes hold them exactly."""
    return 1.0 + 0.1 * time, time**2, 3.0 - time, 2.0 * time**2 - time


def chunk(first, count, length=0.5):
    begin = first + length * np.arange(count)
    return Pieces(begin, np.full(count, length), *motion(begin[:, None] + length * NODES))


@pytest.fixture
def history():
    """The window from 1 to 4 of a run from 0 to 6, in chunks of two pieces."""
    observer = HistoryObserver(LAW, NODES, 1.0, 4.0)
    for first in range(6):
        observer.scan(chunk(float(first), 2))
    return observer


@pytest.mark.parametrize(("per_piece", "inside"), [(None, 19), (4, 24)])
def test_the_window_at_the_nodes_or_at_equal_steps(history, per_piece, inside):
    time, *values = history.samples(per_piece)
    assert (time.size, time.min() >= 1.0, time.max() <= 4.0) == (inside, True, True)
    np.testing.assert_allclose(values, motion(time), atol=1e-13)


def test_the_state_holds_the_window(history):
    again = HistoryObserver(LAW, NODES)
    again.restore(HistoryObserver(LAW, NODES).state())
    assert again.samples().shape == (5, 0)
    again.restore(history.state())
    again.scan(chunk(6.0, 2))
    times = np.array([2.0, 6.25])
    np.testing.assert_allclose(again.at(times)[1:], motion(times), atol=1e-13)
    again.forget(2.65)
    assert again.samples()[0].min() == pytest.approx(2.85)


def test_a_late_time_is_found_in_its_piece_in_spite_of_rounding():
    """A sum of 48 steps at t = 1.6e6 is off by 1e-8; half a piece away there is nothing."""
    begin, length = 1_580_689.0 + 47.0 / 48.0, 1.0 / 48.0
    piece = Pieces(np.array([begin - 1e-8]), np.array([length]), *(np.array([[1.0, 2.0, 4.0]]),) * 4)
    assert values_at(piece, lagrange_basis(NODES), np.array([1_580_690.0]))[0] == pytest.approx(4.0, abs=1e-5)
    for outside in (begin - 0.6 * length, begin + 1.6 * length):
        with pytest.raises(ValueError, match="no piece contains t = "):
            values_at(piece, lagrange_basis(NODES), np.array([outside]))
