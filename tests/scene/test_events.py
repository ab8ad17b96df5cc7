"""Slip events and extrema of synthetic signals whose answers are known."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import scene
from scene.observe import EventObserver, Events, Pieces, summarise
from scene.observe.pieces import interpolation_matrix, lagrange_basis

Array = NDArray[np.float64]
LOG_V = np.log(100.0)
PERIOD = 20.0
RADAU = np.array([0.0885879595127, 0.4094668644407, 0.7876594617608, 1.0])
EQUISPACED = np.linspace(1 / 6, 1.0, 6)


def watch(
    signal: Callable[[Array], Array],
    nodes: Array,
    end: float,
    pieces: int,
    chunk: int = 7,
    begin: float = 0.0,
    **others: Callable[[Array], Array],
) -> Events:
    """Events of ln v = ln V + signal(t), seen in chunks of `chunk` pieces."""
    observer = EventObserver(scene.read("paper"), nodes)
    edges = np.linspace(begin, begin + end, pieces + 1)
    for first in range(0, pieces, chunk):
        left, length = edges[:-1][first : first + chunk], np.diff(edges)[first : first + chunk]
        times = left[:, None] + length[:, None] * nodes
        zero = np.zeros_like(times)
        stress = others["stress"](times) if "stress" in others else zero
        elastic = others["elastic"](times) if "elastic" in others else np.cos(2 * np.pi * (times / PERIOD - 0.25))
        observer.scan(Pieces(left, length, LOG_V + signal(times), zero, stress, elastic))
    return observer.events


def slow(t: Array) -> Array:
    return -np.cos(2 * np.pi * t / PERIOD) * 3.0


@pytest.mark.parametrize("nodes", [RADAU, EQUISPACED], ids=["radau", "equispaced"])
@pytest.mark.parametrize("chunk", [1, 7, 1000])
def test_a_plain_cycle(nodes: Array, chunk: int) -> None:
    events = watch(slow, nodes, 100.0, 1000, chunk)
    assert events.time == pytest.approx(PERIOD / 4 + PERIOD * np.arange(4), abs=1e-6)
    assert events.period == pytest.approx(np.full(4, PERIOD), abs=1e-7)
    assert np.log(events.v_max) == pytest.approx(np.full(4, LOG_V + 3.0), abs=1e-9)
    assert np.log(events.v_min) == pytest.approx(np.full(4, LOG_V - 3.0), abs=1e-9)


@pytest.mark.parametrize("size", [0.5, 1.5, 2.5])
def test_ripples_that_cross_many_times_count_once(size: float) -> None:
    def rippled(t: Array) -> Array:
        return slow(t) + size * np.sin(2 * np.pi * t)

    t = np.linspace(0, 200, 100_001)
    crossings = int(((rippled(t)[:-1] < 0) & (rippled(t)[1:] >= 0)).sum())
    events = watch(rippled, RADAU, 200.0, 4000)
    assert crossings > 15
    assert events.time.size == 9
    assert events.period == pytest.approx(np.full(9, PERIOD), abs=1e-5)


@pytest.mark.parametrize("nodes", [RADAU, EQUISPACED], ids=["radau", "equispaced"])
@pytest.mark.parametrize("pieces", [120, 400, 4000])
@pytest.mark.parametrize(("below", "counted"), [(0.99, 0), (1.01, 4)])
def test_a_stick_is_as_long_as_the_polynomial_is_below_not_the_nodes(
    nodes: Array, pieces: int, below: float, counted: int
) -> None:
    """ln v falls below ln V for a hair more or less than a round trip, whatever the sampling."""
    level = np.cos(np.pi * below / PERIOD)

    def brief(t: Array) -> Array:
        return level - np.cos(2 * np.pi * t / PERIOD)

    assert watch(brief, nodes, 100.0, pieces, begin=-10.0).time.size == counted


def test_steady_sliding_with_rounding_noise_has_no_event() -> None:
    noise = np.random.default_rng(1)
    assert watch(lambda t: 1e-13 * noise.standard_normal(t.shape), RADAU, 100.0, 400).time.size == 0


def test_ripples_alone_are_no_events() -> None:
    assert watch(lambda t: np.sin(2 * np.pi * t), RADAU, 100.0, 2000).time.size == 0


def test_a_jump_between_two_pieces_is_an_event_at_the_joint() -> None:
    def square(t: Array) -> Array:
        return np.where((t % PERIOD <= 10.0) & (t % PERIOD > 0.0), -1.0, 1.0)

    events = watch(square, RADAU, 100.0, 100)
    assert events.time == pytest.approx(10.0 + PERIOD * np.arange(4), abs=1e-12)
    assert events.period == pytest.approx(np.full(4, PERIOD), abs=1e-12)
    assert events.v_max == pytest.approx(np.full(4, 100 * np.e), rel=1e-12)


@pytest.mark.parametrize("phase", np.linspace(0.0, 1.0, 23))
def test_extrema_are_the_polynomials_own_wherever_they_lie_in_a_piece(phase: float) -> None:
    """Also just before or after a piece's end; the best node alone would be off by up to 4e-4."""

    def stress(t: Array) -> Array:
        return np.cos(2 * np.pi * (t - 13.0 - phase) / PERIOD)

    events = watch(slow, EQUISPACED, 100.0, 100, stress=stress, elastic=lambda t: -stress(t))
    assert events.stress_drop == pytest.approx(np.full(4, 2.0), abs=1e-7)
    assert events.elastic_stress_drop == pytest.approx(events.stress_drop, abs=1e-14)


@pytest.mark.parametrize("lead", [-0.3, 0.3])
def test_a_cycle_ends_where_the_next_begins_also_within_a_piece(lead: float) -> None:
    """Peaks `lead` transits from the event's start, in the same piece and of decreasing height, belong to one cycle each."""

    def stress(t: Array) -> Array:
        return np.exp(-0.01 * t) * np.cos(2 * np.pi * (t - 5.0 - lead) / PERIOD)

    events = watch(slow, EQUISPACED, 100.0, 100, begin=-0.5, stress=stress)
    cycles = [stress(np.linspace(start, start + PERIOD, 200_001)) for start in 5.0 + PERIOD * np.arange(4)]
    assert events.stress_drop == pytest.approx([values.max() - values.min() for values in cycles], abs=1e-6)


def test_statistics_are_over_cycles_after_the_given_time() -> None:
    events = watch(slow, RADAU, 100.0, 1000)
    half = summarise(events, 50.0)
    assert (half.cycles, half.period.mean) == (1, pytest.approx(PERIOD, abs=1e-7))
    none = summarise(events, 1e9)
    assert none.cycles == 0
    assert np.isnan(none.period.mean)
    assert np.isnan(none.v_max)


def test_memory_does_not_grow_with_the_run() -> None:
    observer = EventObserver(scene.read("paper"), RADAU)
    before = {name: value for name, value in vars(observer).items() if name != "_rows"}
    edges = np.arange(100.0)
    times = edges[:, None] + RADAU
    observer.scan(Pieces(edges, np.ones(100), LOG_V - 1 + 0 * times, 0 * times, 0 * times, 0 * times))
    assert observer.events.time.size == 0
    assert set(vars(observer)) == set(before) | {"_rows"}


def test_interpolation_is_exact_for_polynomials() -> None:
    basis = lagrange_basis(RADAU)
    points = np.linspace(0, 1, 11)
    for degree in range(4):
        assert interpolation_matrix(basis, points) @ RADAU**degree == pytest.approx(points**degree, abs=1e-13)
        assert basis.derivative @ RADAU**degree == pytest.approx(degree * RADAU ** max(degree - 1, 0), abs=1e-11)


def test_a_front_between_samples_does_not_ring() -> None:
    """ln v that jumps within a piece: the polynomial through it overshoots by decades of v, the extrema must not."""
    nodes = np.linspace(0.0, 1.0, 9)
    events = watch(lambda t: slow(t) + 4.0 * np.sign(slow(t)), nodes, 100.0, 333)
    assert events.v_max.size >= 3
    assert (np.log(events.v_max) < LOG_V + 7.0 + 1e-6).all()
    assert (np.log(events.v_min) > LOG_V - 7.0 - 1e-6).all()
