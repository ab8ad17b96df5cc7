"""Slip events and extrema of cycles on motions whose answers are known, in pieces as a solver would emit them."""

import itertools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

import slipwave
from slipwave.observe import EventObserver, Pieces, summarise
from slipwave.observe.extrema import extrema
from slipwave.observe.pieces import lagrange_basis

Array = NDArray[np.float64]
SCENE = slipwave.read("paper", ["slab.log10_r=0.0"])
"""Of slabs so thick that each fall of these motions is long enough for a slip event."""
V = 100.0
RADAU = np.array([0.0885879595127, 0.4094668644407, 0.7876594617608, 1.0])
EQUISPACED = np.linspace(1 / 6, 1.0, 6)


class Motion(NamedTuple):
    """Elastic stress and ln v over time (transits), from t = 0 to `until`; the friction stress, if it is asked for."""

    elastic: Callable[[Array], Array]
    unknown: Callable[[Array], Array]
    until: float
    stress: Callable[[Array], Array] = np.zeros_like


def through(turns, step=5.0, velocity=V):
    """Elastic stress that turns at t = 0, `step`, 2 `step`, ... at the values `turns` and is monotone between; v from
    y' = k (V - v) with k so large that v > V/5."""
    curve = PchipInterpolator(step * np.arange(len(turns)), turns)
    slope = curve.derivative()
    steepest = float(np.max(slope(np.linspace(0.0, curve.x[-1], 20 * len(turns)))))
    stiffness = 1.25 * max(steepest, 1e-30) / velocity
    return Motion(curve, lambda t: np.log(velocity - slope(t) / stiffness), float(curve.x[-1]))


def watch(motion, nodes=RADAU, pieces=2000, chunk=7, resumed=False, scene=SCENE):
    """The observer after `motion` was shown to it in chunks of `chunk` of equally long `pieces`; if `resumed`, another goes on
    after each."""
    observer = EventObserver(scene, nodes)
    edges = np.linspace(0.0, motion.until, pieces + 1)
    for first in range(0, pieces, chunk):
        if resumed:
            before, observer = observer, EventObserver(scene, nodes)
            observer.restore(before.state())
        left, length = edges[:-1][first : first + chunk], np.diff(edges)[first : first + chunk]
        times = left[:, None] + length[:, None] * nodes
        state = np.zeros_like(times)
        observer.scan(Pieces(left, length, motion.unknown(times), state, motion.stress(times), motion.elastic(times)))
        _ = observer.count  # a look at the run so far changes nothing
    return observer


PERIOD = 20.0
HALF = PERIOD / (2 * np.pi) * np.arccos(-1.0 + np.log(2.0) / 3.0)
"""Where ln v = ln V - 3 cos(2 pi t/T) passes half of its largest v."""


def wave(until, of_rate=3.0, stress=np.zeros_like):
    """ln v = ln V - `of_rate` cos(2 pi t/T) with y = sin(2 pi t/T): the rate is V where y turns."""
    return Motion(
        lambda t: np.sin(2 * np.pi * t / PERIOD), lambda t: np.log(V) - of_rate * np.cos(2 * np.pi * t / PERIOD), until, stress
    )


@pytest.mark.parametrize("nodes", [RADAU, EQUISPACED], ids=["radau", "equispaced"])
@pytest.mark.parametrize("chunk", [1, 7, 1000])
def test_a_plain_cycle(nodes, chunk):
    observer = watch(wave(100.0), nodes, 1000, chunk, resumed=chunk == 7)
    events = observer.events()
    assert observer.count == 5
    assert events.time == pytest.approx(HALF + PERIOD * np.arange(4), abs=1e-6)
    assert events.period == pytest.approx(np.full(4, PERIOD), abs=1e-7)
    assert events.v_max == pytest.approx(np.full(4, V * np.exp(3.0)), rel=1e-9)
    assert events.v_min == pytest.approx(np.full(4, V * np.exp(-3.0)), rel=1e-9)
    assert events.elastic_stress_drop == pytest.approx(np.full(4, 2.0), rel=1e-9)


def test_a_small_oscillation_is_dated_where_the_rate_rises_most_steeply():
    """v = V (1 - 0.1 cos): dv/dt is largest where y has its maximum."""
    small = Motion(
        lambda t: 1e-3 * np.sin(2 * np.pi * t / PERIOD), lambda t: np.log(V - 0.1 * V * np.cos(2 * np.pi * t / PERIOD)), 100.0
    )
    assert watch(small).dates() == pytest.approx(PERIOD / 4 + PERIOD * np.arange(5), abs=1e-6)


SAW = [0.0, 1.0]
RIPPLED = [0.0, 0.3, 0.25, 0.6, 0.55, 1.0, 0.7, 0.76, 0.3, 0.37]  # ripples of 5 % on the way up, rebounds of 7 % on the way down
PRECURSOR = {0.05: [0.0, 0.8, 0.75, 1.0], 0.20: [0.0, 0.8, 0.6, 1.0]}


@pytest.mark.parametrize(
    ("turns", "count"),
    [
        pytest.param(SAW * 12, 11, id="saw"),
        pytest.param(RIPPLED * 12, 12, id="ripples and rebounds"),
        pytest.param(PRECURSOR[0.05] * 12, 11, id="precursors of 5 %"),
        pytest.param(PRECURSOR[0.20] * 12, 12 + 11, id="precursors of 20 %"),
        pytest.param([0.0, 1.0], 0, id="only rising"),
        pytest.param([1.0, 0.0], 1, id="only falling"),
        pytest.param([0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0], 2, id="hold and reload"),
        pytest.param([0.0, 1.0, 0.97, 1.2, 0.2, 1.2, 0.2, 1.2], 2, id="hold with a relaxation of 3 %"),
        pytest.param([-0.15 * k + (1.0 if k % 2 else 0.0) for k in range(24)], 11, id="falling by three events"),
        pytest.param([3.0 * k + (4.0 if k % 2 else 0.0) for k in range(24)], 11, id="rising by thirty events"),
    ],
)
@pytest.mark.parametrize(("nodes", "pieces"), [(RADAU, 700), (EQUISPACED, 7001)], ids=["radau", "equispaced"])
@pytest.mark.parametrize("scale", [1e-6, 1.0])
def test_counts_are_known(turns, count, nodes, pieces, scale):
    assert watch(through(list(scale * np.array(turns))), nodes, pieces).count == count


@pytest.mark.parametrize("noise", [1e-17, 1e-16, 1e-13])
def test_steady_sliding_with_rounding_noise_has_no_event(noise):
    draw = np.random.default_rng(1).standard_normal
    steady = Motion(lambda t: 0.3 + noise * draw(t.shape), lambda t: np.log(V) + 1e-13 * draw(t.shape), 100.0)
    observer = watch(steady, pieces=4000)
    assert observer.count == 0
    assert len(observer.state()["swings"]) <= 40


@pytest.mark.parametrize("count", range(14, 34))
def test_few_pieces_wherever_they_end_give_the_date(count):
    """Also where the largest rate lies just behind the end of a piece, and v falls below half of it within the next."""
    found = watch(wave(2 * PERIOD), np.linspace(1 / 12, 1.0, 12), count).dates()
    assert found == pytest.approx([HALF, HALF + PERIOD], abs=1e-4)


def test_of_a_long_rise_above_half_its_height_every_other_piece_is_kept_to_its_end():
    """133 000 pieces: v passes 1 long after the fall began, and before the room was full."""
    pieces, passage = 399_000, 1.0 + 0.5 * (1.0 - 0.6) / (1.15 - 0.6)

    def elastic(t):
        return np.interp(t, [0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 0.0, 1.0])

    def unknown(t):
        return np.log(np.interp(t, [0.0, 1.0, 1.5, 2.0, 3.0], [0.5, 0.6, 1.15, 2.0, 0.5]))

    found = watch(Motion(elastic, unknown, 3.0), pieces=pieces, chunk=7_000)
    assert found.dates() == pytest.approx([passage], abs=8 * 3.0 / pieces)
    assert len(found.state()["rise"]) <= 1 << 16


def test_a_jump_between_two_pieces_is_an_event_at_the_joint():
    def above(t):
        return np.where((t % PERIOD <= 10.0) & (t % PERIOD > 0.0), -1.0, 1.0)

    jumps = Motion(lambda t: 0.1 * np.abs((t % PERIOD) - 10.0) * -1.0, lambda t: np.log(V) + above(t), 105.0)
    events = watch(jumps, pieces=105).events()
    assert events.time == pytest.approx(10.0 + PERIOD * np.arange(4), abs=1e-12)
    assert events.period == pytest.approx(np.full(4, PERIOD), abs=1e-12)
    assert events.v_max == pytest.approx(np.full(4, V * np.e), rel=1e-12)


def test_what_a_jump_between_two_pieces_reaches_at_once_counts():
    """Stress and ln v that a front raises, between two samples, to their largest values, from which they fall at once."""

    def falling(t):
        return 0.1 * ((3.0 - t) % PERIOD) - 1.0

    motion = Motion(wave(100.0).elastic, lambda t: np.log(V) + 3.0 * falling(t), 100.0, falling)
    events = watch(motion, pieces=100).events()
    assert events.stress_drop == pytest.approx(np.full(4, 2.0), abs=1e-7)
    assert np.log(events.v_max / V) == pytest.approx(np.full(4, 3.0), abs=1e-7)


@pytest.mark.parametrize("phase", np.linspace(0.0, 1.0, 23))
def test_extrema_are_the_polynomials_own_wherever_they_lie_in_a_piece(phase):
    """Also just before or after a piece's end; the best node alone would be off by up to 4e-4."""

    def shifted(t):
        return np.cos(2 * np.pi * (t - 13.0 - phase) / PERIOD)

    events = watch(wave(100.0, stress=shifted), EQUISPACED, 100).events()
    assert events.stress_drop == pytest.approx(np.full(4, 2.0), abs=1e-7)
    turned = Motion(lambda t: -np.sin(2 * np.pi * (t - 13.0 - phase) / PERIOD), lambda t: np.log(V) + 3.0 * shifted(t), 100.0)
    assert watch(turned, EQUISPACED, 100).events().elastic_stress_drop[-3:] == pytest.approx(np.full(3, 2.0), abs=1e-7)


@pytest.mark.parametrize("lead", [-0.3, 0.3])
def test_a_cycle_ends_where_the_next_begins_also_within_a_piece(lead):
    """Peaks `lead` transits from where y turns, in the same piece and of decreasing height, belong to one cycle each."""

    def stress(t):
        return np.exp(-0.01 * t) * np.cos(2 * np.pi * (t - 5.0 - lead) / PERIOD)

    events = watch(wave(99.0, stress=stress), EQUISPACED, 99).events()
    cycles = [stress(np.linspace(start, start + PERIOD, 200_001)) for start in 5.0 + PERIOD * np.arange(4)]
    assert events.stress_drop == pytest.approx([values.max() - values.min() for values in cycles], abs=1e-6)


def test_cycles_begin_and_end_with_events_that_the_run_saw_whole():
    """A run that begins in the middle of one fall and ends in the middle of another."""
    observer = watch(through([0.5, 0.0, *[1.0, 0.0] * 5, 1.0, 0.5]))
    assert (observer.count, observer.events().time.size) == (7, 4)


def test_statistics_are_means_spreads_and_extremes():
    turns = list(itertools.chain.from_iterable((1.0, -0.1 * k) for k in range(6)))
    turns.append(1.0)
    events = watch(through(turns), pieces=12_000).events()
    found, drops = summarise(events), events.elastic_stress_drop
    assert drops == pytest.approx([1.1, 1.2, 1.3, 1.4], rel=1e-6)
    assert (found.cycles, found.elastic_stress_drop.mean) == (4, pytest.approx(1.25, rel=1e-6))
    assert found.elastic_stress_drop.std == pytest.approx(np.sqrt(0.0125), rel=1e-5)
    assert (found.v_max, found.v_min) == (events.v_max.max(), events.v_min.min())
    assert found.v_max > 1.01 * events.v_max.min()
    none = summarise(watch(through(turns)).events(1e9))
    assert none.cycles == 0
    assert np.isnan([none.period.mean, none.v_max, none.v_min]).all()


def test_a_front_between_samples_does_not_ring():
    """ln v that jumps within a piece: the polynomial through it overshoots by decades of v, the extrema must not."""
    smooth = wave(100.0)
    front = Motion(smooth.elastic, lambda t: smooth.unknown(t) + 4.0 * np.sign(smooth.unknown(t) - np.log(V)), 100.0)
    events = watch(front, np.linspace(0.0, 1.0, 9), 333).events()
    assert events.v_max.size >= 3
    assert (np.log(events.v_max) < np.log(V) + 7.0 + 1e-6).all()
    assert (np.log(events.v_min) > np.log(V) - 7.0 - 1e-6).all()


@pytest.mark.parametrize("after", [1, 2, 3, 4])
def test_a_jump_between_two_nodes_of_a_quartic_does_not_ring(after):
    """As V that jumps makes it of `fd`; before, by up to 13 % of the jump, in ln v."""
    jump = np.where(np.arange(5) < after, 0.0, 1.0)
    assert extrema(lagrange_basis(np.linspace(0.0, 1.0, 5)), np.array([jump])) == (1.0, 0.0)


STEP = 5.0


def plain_events(turns, rates, since):
    """Elementary falls that date the events among `turns`, judged by the falls from the elementary one `since` on: the smallest
    swing goes as long as it is below 10 % of the largest fall; `rates` are the largest v of the elementary swings."""
    swings = [(a, b, rate, k) for k, (a, b, rate) in enumerate(zip(turns[:-1], turns[1:], rates, strict=True))]
    threshold = _threshold(turns, since)
    while True:
        sizes = [abs(swing[1] - swing[0]) for swing in swings]
        inner = [i for i in range(1, len(swings) - 1) if sizes[i] <= min(sizes[i - 1], sizes[i + 1])]
        small = [i for i in inner if sizes[i] < threshold]
        if small:
            i = min(small, key=sizes.__getitem__)
            left, right = swings[i - 1], swings[i + 1]
            fastest = max(left, right, key=lambda swing: swing[2])
            swings[i - 1 : i + 2] = [(left[0], right[1], fastest[2], fastest[3])]
            continue
        return [swing[3] for swing in swings if swing[0] - swing[1] >= threshold and swing[3] >= since]


def _threshold(turns, since):
    """10 % of the largest fall from the turning point `since` on in which nothing rises by 10 % of it."""
    largest = 0.0
    for i in range(since, len(turns)):
        low, rise = turns[i], 0.0
        for y in turns[i + 1 :]:
            low, rise = min(low, y), max(rise, y - low)
            if turns[i] - y > largest and rise < 0.1 * (turns[i] - y):
                largest = turns[i] - y
    return 0.1 * largest


def _walk(kind, count, random):
    """Turning points that go up and down by turns."""
    sizes = np.exp(random.normal(0.0, {"even": 0.2, "wild": 1.5, "wilder": 3.0}.get(kind, 1.0), count))
    sizes *= {"decaying": np.exp(-0.05 * np.arange(count)), "growing": np.exp(0.05 * np.arange(count))}.get(kind, 1.0)
    return list(0.01 * np.cumsum(sizes * np.where(np.arange(count) % 2, -1.0, 1.0)))


@pytest.mark.parametrize("kind", ["even", "wild", "wilder", "decaying", "growing"])
@pytest.mark.parametrize("seed", range(4))
def test_events_are_those_of_the_definition_in_every_window(kind, seed):
    for expected, found in _by_definition_and_found(_walk(kind, 150, np.random.default_rng(seed)), (0, 40, 76, 120, 140)):
        assert found == expected
    assert expected


def test_a_run_that_begins_with_a_fall_in_two_parts_has_one_event_there():
    """The rise of 0.06 between them is below 10 % of both together, 1.24, but not of any fall after them."""
    turns = [1.0, 0.0, 0.06, -0.24, 0.2, -0.3, 0.4]
    ((expected, found),) = _by_definition_and_found(turns, (0,))
    assert found == expected
    assert len(found) == 2


def _by_definition_and_found(turns, windows):
    swings = len(turns) - 1
    motion = through(turns, STEP)
    observer = watch(motion, pieces=swings * 20, chunk=100)
    times = np.linspace(0.0, motion.until, swings * 400 + 1)
    rates = [float(part.max()) for part in np.split(motion.unknown(times[:-1]), swings)]
    for since in windows:
        found = observer.dates(STEP * (since - 0.5))
        yield plain_events(turns, rates, since), list(np.floor(found / STEP + 0.01).astype(int))


def test_memory_is_one_of_events_not_of_ripples():
    """Forty ripples of 1 % in every rise: what is kept grows by two swings an event."""
    ripples = np.repeat(np.linspace(0.0, 1.0, 41), 2)[1:-1] + np.tile([0.0, -0.01], 40)
    cycle = [0.0, *ripples[:-1], 1.0]
    observer = watch(through(cycle * 100, 1.0), pieces=16_000, chunk=1000)
    assert observer.count == 100 - 1
    assert len(observer.state()["swings"]) < 2 * 100 + len(cycle)
