"""The events of any sequence of turning points, held against the definition carried out in the plainest way."""

import numpy as np
import pytest
from motions import through, watch

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
