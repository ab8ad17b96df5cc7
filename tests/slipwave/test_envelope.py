"""What is kept of a run: ranges of the motion in equal intervals, and the solver's own polynomials in a window."""

import numpy as np
import pytest

import slipwave
from slipwave.friction import rates
from slipwave.observe import HistoryObserver
from slipwave.observe.envelope import COUNT, Envelope
from slipwave.observe.history import values_at
from slipwave.observe.pieces import Pieces, lagrange_basis
from slipwave.solve import follow
from tests.granite import GRANITE
from validation.models.build import build

STEP = {"drive.velocity": [[0, 100], [30, 100], [30, 300], [200, 300], [230.5, 0], [260, 0], [260, 50]]}


def watched(scene, until, *observers):
    solver = build("delay", scene)
    follow(solver, until, observers)
    return solver


@pytest.fixture(scope="module")
def motion():
    """Steps, a ramp and a hold: the envelope, and all samples."""
    scene = slipwave.read("paper", STEP)
    nodes = build("delay", scene).nodes
    envelope, every = Envelope(scene, nodes), HistoryObserver(scene.law, nodes)
    watched(scene, 300.0, envelope, every)
    return scene, envelope, every.samples()


def test_each_interval_has_the_range_of_its_samples(motion):
    scene, envelope, (time, z, _, mu, _) = motion
    curve, width = envelope.by_time(), 2.0**-3  # the first power of two with which 4096 intervals reach 300 transits
    assert 300.0 / COUNT <= width < 2.0 * 300.0 / COUNT
    which = np.floor(time / width).astype(int)
    filled = np.unique(which)
    for (low, high), values in ((curve.stress, mu), (curve.rate, rates(scene.law, z))):
        assert low.tolist() == [values[which == place].min() for place in filled]
        assert high.tolist() == [values[which == place].max() for place in filled]
    assert curve.time.tolist() == [time[which == place].max() for place in filled]


def test_slip_is_the_integral_of_the_slip_rate(motion):
    """Trapezoids between the nodes: their own error is 1e-3. In a hold and after steps the drive does not tell the slip."""
    scene, envelope, (time, z, _, _, _) = motion
    rate, curve = rates(scene.law, z), envelope.by_time()
    slip = scene.transit * np.concatenate(([0.0], np.cumsum(0.5 * np.diff(time) * (rate[1:] + rate[:-1]))))
    assert curve.slip == pytest.approx(np.interp(curve.time, time, slip), rel=2e-3, abs=2e-3 * slip[-1])
    along = envelope.by_slip()
    assert (along.slip[-1], along.stress[1].max()) == (curve.slip[-1], curve.stress[1].max())
    assert along.slip.size > 1000
    assert np.diff(along.slip).min() > 0.0


def test_a_leapt_stretch_has_the_ranges_of_whole_transits():
    """Of granite. Every transit has another range, by what changes in a stick from one interval to the next."""
    scene = slipwave.read(GRANITE)
    nodes = build("delay", scene).nodes
    envelope, every = (Envelope(scene, nodes) for _ in range(2))
    leaping = watched(scene, 30_000.0, envelope)
    history = HistoryObserver(scene.law, nodes, 1e9)  # keeps nothing, but asks for every transit
    watched(scene, 30_000.0, every, history)
    ours, theirs = envelope.by_time(), every.by_time()
    assert leaping.skipped > 10_000
    assert theirs.time.size > ours.time.size > 500
    (low, high), (least, most) = ours.stress, theirs.stress
    assert low == pytest.approx(np.interp(ours.time, theirs.time, least), abs=3e-4)
    assert high == pytest.approx(np.interp(ours.time, theirs.time, most), abs=3e-4)
    assert (low.min(), high.max()) == pytest.approx((least.min(), most.max()), rel=1e-6)
    assert (high - low)[ours.time > 15_000].min() > 0.8 * (most - least)[theirs.time > 15_000].min()


LAW = slipwave.read("paper").law
NODES = np.array([0.2, 0.7, 1.0])


def quadratic(time):
    """z, psi, mu and y, quadratic in time: three nodes hold them exactly."""
    return 1.0 + 0.1 * time, time**2, 3.0 - time, 2.0 * time**2 - time


def chunk(first, count, length=0.5):
    begin = first + length * np.arange(count)
    return Pieces(begin, np.full(count, length), *quadratic(begin[:, None] + length * NODES))


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
    np.testing.assert_allclose(values, quadratic(time), atol=1e-13)


def test_the_state_holds_the_window(history):
    again = HistoryObserver(LAW, NODES)
    again.restore(HistoryObserver(LAW, NODES).state())
    assert again.samples().shape == (5, 0)
    again.restore(history.state())
    again.scan(chunk(6.0, 2))
    times = np.array([2.0, 6.25])
    np.testing.assert_allclose(again.at(times)[1:], quadratic(times), atol=1e-13)
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
