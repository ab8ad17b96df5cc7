"""Leaps over long sticks: the figures of the march without leaps, gaps only where nothing happens, and nothing else changes."""

import numpy as np
import pytest

import slipwave
from reduced.delay.alike import Delay
from reduced.delay.system import LeapingDelay, delay_system
from slipwave.observe import EventObserver
from slipwave.observe.history import HistoryObserver
from slipwave.observe.pieces import Pieces
from slipwave.observe.protocol import ProtocolObserver
from slipwave.solve import follow
from tests.granite import GRANITE

CYCLE = 80_000.0
"""Transits; two slip events of granite, and the rise after the second."""


def granite(**drive):
    """Slabs of granite, 10 m thick, driven at 1 um/s: a stick lasts 57,000 transits; or with some other drive."""
    return slipwave.read(GRANITE | {"drive": {"velocity": 1.0} | drive})


class Seen:
    """An observer that keeps all pieces, with their gaps."""

    whole_from = np.inf

    def __init__(self):
        self._parts = []

    def scan(self, pieces):
        self._parts.append(pieces)

    @property
    def pieces(self):
        return Pieces.joined(self._parts)


def watched(solver, until, marks=()):
    """Events and pieces of a run, and its end."""
    events, seen = EventObserver(solver.scene, solver.nodes), Seen()
    return events, seen, follow(solver, until, [events, seen], marks=marks)


@pytest.fixture(scope="module", params=[1e-6, 1e-8])
def both(request):
    """The tolerance, a run with leaps, and the same by the march without."""
    leaping, plain = (kind(granite(), tolerance=request.param) for kind in (LeapingDelay, Delay))
    every = EventObserver(plain.scene, plain.nodes)
    return request.param, leaping, watched(leaping, CYCLE), every, follow(plain, CYCLE, [every])


def test_a_cycle_has_the_figures_of_the_march_without_leaps(both):
    """Measured: 0.03 to 0.5 of the tolerance; for v_min, the value of one transit, 0.8 to 1.1."""
    tolerance, leaping, (ours, _, end), every, wanted = both
    found, known = ours.events(), every.events()
    assert leaping.skipped > 50_000
    assert found.time.size == known.time.size == 1
    for name in ("period", "stress_drop", "elastic_stress_drop", "v_max"):
        assert getattr(found, name) == pytest.approx(getattr(known, name), rel=5.0 * tolerance), name
    assert found.v_min == pytest.approx(known.v_min, rel=10.0 * tolerance)
    assert end.psi == pytest.approx(wanted.psi, abs=5.0 * tolerance)


def test_only_whole_transits_without_events_are_left_out(both):
    """Of the stick and, where it pays, of the rise of v after it, in which y falls."""
    tolerance, leaping, (ours, seen, _), _, _ = both
    pieces = seen.pieces
    ends = pieces.time + pieces.length
    gap = np.flatnonzero(pieces.time[1:] - ends[:-1] > 1e-9)
    lengths = pieces.time[gap + 1] - ends[gap]
    assert (lengths, lengths.sum()) == (pytest.approx(np.round(lengths), abs=1e-9), pytest.approx(leaping.skipped))
    assert pieces.time[gap + 1] == pytest.approx(np.round(pieces.time[gap + 1]), abs=1e-9)
    assert all(((pieces.time < date) & (date < ends)).any() for date in ours.dates())
    rising = pieces.y[gap + 1, 0] > pieces.y[gap, -1]
    assert lengths[rising].sum() > 50_000
    assert (lengths[~rising].sum() > 500) == (tolerance == 1e-6)
    assert pieces.z[gap + 1].max() < 1.0


def test_one_observer_that_needs_every_transit_gets_them():
    scene = granite()
    leaping, plain = delay_system(scene, tolerance=1e-6), Delay(scene, tolerance=1e-6)
    ours, theirs = (HistoryObserver(scene.law, plain.nodes, start=19_000.0) for _ in range(2))
    assert isinstance(leaping, LeapingDelay)
    assert follow(leaping, 20_000.0, [EventObserver(scene, plain.nodes), ours]) == follow(plain, 20_000.0, [theirs])
    assert np.array_equal(ours.samples(), theirs.samples())
    assert leaping.skipped == 0


@pytest.mark.parametrize(
    ("velocity", "leaps_again"),
    [
        ([[30_000.25, 1.0], [30_010.5, 2.0]], True),
        ([[30_000.0, 1.0], [35_000.0, 3.0]], False),  # 1000 transits are left
        ([[20_000.0, 1.0], [20_100.0, 0.0]], True),
        ([[30_000.0, 1.0], [30_000.5, 1.3], [30_001.0, 1.0]], True),
    ],
    ids=["step", "long ramp", "hold", "pulse"],
)
def test_no_leap_crosses_a_change_of_the_drive(velocity, leaps_again):
    """Nor one after which V is what it was."""
    scene = granite(velocity=velocity)
    leaping, plain = (kind(scene, tolerance=1e-6) for kind in (LeapingDelay, Delay))
    _, seen, found = watched(leaping, 36_000.4)
    known = follow(plain, 36_000.4)
    assert (found.psi, found.mu) == (pytest.approx(known.psi, abs=2e-6), pytest.approx(known.mu, abs=5e-4))
    pieces = seen.pieces
    begins, ends = pieces.time[1:], (pieces.time + pieces.length)[:-1]
    gap = begins - ends > 1e-9
    first, last = scene.drive.knots[0], scene.drive.knots[-1]
    assert gap[ends < first].any()
    assert not (gap & (begins > first - 1.0) & (ends < last)).any()
    assert gap[ends >= last].any() == leaps_again


def test_a_hold_is_leapt_over_and_has_the_figures_of_every_transit():
    """Steady sliding, a hold, and sliding again: the wave of each step goes round through all of it."""
    knots = [[0.0, 1.0], [300.5, 1.0], [300.5, 0.0], [6000.25, 0.0], [6000.25, 1.0]]
    scene = slipwave.read(GRANITE | {"drive": {"velocity": knots}, "start": {"size": 0.0}})
    leaping, plain = (kind(scene, tolerance=1e-6) for kind in (LeapingDelay, Delay))
    protocols = [ProtocolObserver(scene, plain.nodes, 7000.0) for _ in range(2)]
    ends = [follow(solver, 7000.0, [one]) for solver, one in zip((leaping, plain), protocols, strict=True)]
    assert 4500 < leaping.skipped < 5700
    assert ends[0].psi == pytest.approx(ends[1].psi, abs=2e-6)
    (_, hold, slide), (_, known, later) = (one.figures for one in protocols)
    assert hold.relaxation == pytest.approx(known.relaxation, rel=1e-6)
    assert slide.healing == pytest.approx(later.healing, rel=1e-6)


SMALL = GRANITE | {"start": {"size": 1e-4}}


@pytest.mark.parametrize(
    ("source", "until"), [("paper", 1500.0), ("rock", 1500.0), (SMALL, 20_000.0)], ids=["paper", "rock", "small"]
)
def test_nothing_changes_where_sticks_are_short_or_a_small_disturbance_grows(source, until):
    """While v stays near V no transit is left out."""
    scene = slipwave.read(source)
    leaping, plain = (kind(scene, tolerance=1e-6) for kind in (LeapingDelay, Delay))
    (ours, seen, end), theirs = watched(leaping, until), EventObserver(scene, plain.nodes)
    assert end == follow(plain, until, [theirs])
    assert np.array_equal(ours.dates(), theirs.dates())
    assert leaping.skipped == 0
    assert seen.pieces.time[1:] == pytest.approx((seen.pieces.time + seen.pieces.length)[:-1], abs=1e-9)
    assert abs(end.psi - scene.steady_psi) > 5e-4
