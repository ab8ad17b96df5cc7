"""Verdicts on sequences of cycles whose nature is known, margins of means, and the largest Lyapunov exponent."""

import itertools
import math

import numpy as np
import pytest
from scipy.stats import t

import slipwave
from reduced.stability import spectrum
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import Pieces
from slipwave.observe.events import Events
from slipwave.observe.statistics import BATCHES, FEWEST, margin_of_mean, summarise
from slipwave.observe.torus import rotation
from slipwave.observe.verdict import judge_motion, repeating
from slipwave.solve import follow
from slipwave.solve.lyapunov import WHOLE, largest_exponent
from validation.models.build import build

K = np.arange(24)


def verdict(sizes, ratio=1000.0, rests=True, slides=False, until=4000.0, back=False):
    """Of events with prominences 0.1 `sizes` and periods and rates that go with them, the least rate reversed if `back`; one
    cycle less than events."""
    drop = 0.1 * np.asarray(sizes, dtype=float)
    period = 50.0 + 300.0 * drop[:-1]
    v_max = 100.0 * (1.0 + (np.sqrt(ratio) - 1.0) * drop[:-1] / 0.1)
    time = 2000.0 + np.concatenate(([0.0], np.cumsum(period[:-1]))) if period.size else period
    v_min = (-1e4 if back else 1e4) / v_max
    return judge_motion(Events(time, period, 1.1 * drop[:-1], drop[:-1], v_max, v_min), drop, rests, slides, until)


def henon(count, a, b=0.3):
    x, y, values = 0.1, 0.1, []
    for _ in range(500 + count):
        x, y = 1.0 - a * x * x + y, b * x
        values.append(x)
    return 1.0 + 0.2 * np.array(values[500:])


@pytest.mark.parametrize(
    ("sizes", "kind", "multiplicity"),
    [
        (np.ones(24), "periodic", 1),
        (1.0 + 2e-4 * (-1.0) ** K, "periodic", 1),
        (1.0 + 2e-2 * (-1.0) ** K, "periodic", 2),
        (henon(24, 1.0), "periodic", 4),
        (1.0 + 0.01 * np.cos(2 * np.pi * 0.263 * np.arange(26)), "torus", None),
        (henon(24, 1.4), "irregular", None),
        (1.0 + 0.2 * 0.7**K, "settling", None),
        (1.0 - 0.5 * 0.95**K, "settling", None),
        (1.0 + 0.2 * (-1.0) ** K * (1.0 - 0.7**K), "settling", None),  # to a period of two events
        (1.0 + 1e-2 * 0.99**K * np.cos(2 * np.pi * 0.263 * K), "settling", None),  # along a spiral, to one
        (1.0 + 1e-2 * np.cos(2 * np.pi * 0.26 * K / 24), "settling", None),  # a quarter of a turn
        (1.0 + 4e-5 * K, "settling", None),  # the later half agrees within 1e-3
        (1.0 + 0.9**K * (1.0 + 0.3 * np.sin(5.0 * K)), "settling", None),  # to a limit above half of the last
        (0.92 ** (K**1.05) * np.where(K < 12, 1.0, 1.003), "decaying", None),  # ever faster, with a jump of the date
        (np.tile(1.0 + 0.1 * np.sin(np.arange(5.0) ** 2), 4), "periodic", 5),  # the later half has no two periods
        (np.tile(1.0 + 0.1 * np.sin(np.arange(11.0) ** 2), 3), "periodic", 11),
        (0.89**K, "decaying", None),
        (0.9**K * (1.0 + 0.1 * (-1.0) ** K), "decaying", None),
        (1.1**K, "growing", None),
        (1e-3 * 0.998**K, "decaying", None),  # small: however slowly
        (0.998**K, "settling", None),
        (1e-3 * (1.0 + 0.2 * 0.9**K), "settling", None),  # to a smaller one
        (np.exp(-0.4 * K[:12]).tolist() + (np.exp(-4.4) * np.exp(-0.36 * K[1:13])).tolist(), "decaying", None),  # by its end
        (np.ones(3), "too short", None),
        (henon(15, 1.4), "too short", None),
    ],
)
def test_verdicts_on_known_sequences(sizes, kind, multiplicity):
    found = verdict(sizes)
    assert (found.kind, found.multiplicity) == (kind, multiplicity)
    assert found.repeats == (kind in ("periodic", "torus", "irregular"))
    assert (found.rotation is not None) == (kind == "torus")


@pytest.mark.parametrize("turn", [0.1, 0.2, 0.263, 0.35, 0.409, 0.45, 0.49])
@pytest.mark.parametrize("shrink", [0.8, 0.875, 0.9])
def test_swings_that_decay_are_neither_chaos_nor_several_events(shrink, turn):
    """To one event, `turn` of a turn a cycle: whatever size is left, and however few cycles are judged; before, 82 of 1110 such
    sequences were irregular, and 145 had two to eight events."""
    for left, count in itertools.product((1e-2, 3e-3, 1e-3, 3e-4), (12, 16, 18, 20, 24, 32, 40)):
        cycles = np.arange(count + 1)
        size = left * shrink ** (cycles - count)
        if size[0] < 0.5:
            found = verdict(1.0 + size * np.cos(2.0 * np.pi * turn * cycles + 0.3))
            assert found.kind in ("settling", "too short") or found.multiplicity == 1


@pytest.mark.parametrize("until", [1800.0, 2200.0])  # before: irregular, and periodic with 5 events
def test_cycles_that_swing_around_their_orbit_settle(until):
    assert slipwave.run("unlike", until=until).verdict == "settling"


def test_large_cycles_whose_slip_reverses_and_hardly_change_do_not_decay():
    """v_max/v_min is below zero; before, they were small motions, which may decay however slowly."""
    assert verdict(0.998**K, back=True).kind == verdict(0.998**K).kind == "settling"


def test_the_ups_and_downs_of_chaos_are_no_approach():
    """Whatever stretch of it is judged: its largest change halves by chance in one of five."""
    sizes = np.exp(2.0 * henon(600, 1.4))
    kinds = [verdict(sizes[first : first + 60], ratio=4.0).kind for first in range(0, 540, 20)]
    assert kinds.count("irregular") >= 25
    assert "torus" not in kinds


@pytest.mark.parametrize("share", [0.3, 0.4, 0.6, 0.7])
@pytest.mark.parametrize("factor", [0.85, 0.9, 0.95])
def test_a_fall_whose_limit_is_above_half_of_the_last_event_is_no_decay(share, factor):
    """1 at the last event, of which `share` stays for ever."""
    assert verdict(share + (1.0 - share) * factor ** (K - 23.0)).kind == ("decaying" if share < 0.5 else "settling")


@pytest.mark.parametrize(("events", "transient", "left"), [(1, 5, 25), (3, 5, 25), (3, 9, 23), (1, 0, 30)])
def test_means_of_a_periodic_motion_are_of_the_cycles_that_repeat(events, transient, left):
    """Of 30 cycles; an excess of 2^-7 of 11 is the first below 1e-3."""
    period = 10.0 + np.arange(30) % events
    period[:transient] += 2.0 ** -np.arange(transient)
    columns = [np.cumsum(period), period, *np.tile(period / 10.0, (4, 1))]
    found = repeating(Events(*columns), events)
    assert (found.time.tolist(), found.period.tolist()) == (columns[0][-left:].tolist(), period[-left:].tolist())


def test_the_rate_of_decay_and_growth_is_that_of_the_stress_drops():
    """Drops of e^(rate t) at dates 80 transits apart, and periods and rates of slip that do not matter."""
    one = np.ones(12)
    for rate in (-0.002, 0.0015):
        drop = np.exp(rate * 80.0 * np.arange(12.0))
        found = judge_motion(Events(80.0 * np.arange(12.0), one, one, drop, 2.0 * one, one), drop, True, False, 2000.0)
        assert (found.kind, found.rate) == ("decaying" if rate < 0.0 else "growing", pytest.approx(rate, rel=1e-12))
    assert np.isnan(verdict(np.ones(24)).rate)


def test_drive_and_steady_sliding_come_first_and_a_run_too_short_is_told_how_long_it_should_be():
    assert verdict(np.ones(24), rests=False).kind == "driven"
    none = np.empty(0)
    empty = Events(*[none] * 6)
    assert judge_motion(empty, none, True, True, 100.0).kind == "steady"
    loading = judge_motion(empty, none, True, False, 100.0)
    assert (loading.kind, loading.needed) == ("too short", 200.0)
    period = np.array([70.0, 90.0])
    cycles = Events(np.cumsum(period), period, *np.ones((4, 2)))
    assert judge_motion(cycles, np.ones(3), True, False, 300.0).needed == pytest.approx(2 * 5 * 90.0)


@pytest.mark.parametrize("number", [0.0631, 0.2632, 0.41421, 0.44])
def test_the_rotation_number_of_a_known_torus(number):
    phase = 2.0 * np.pi * number * np.arange(40)
    found = rotation(79.3 + 0.2 * np.cos(phase + 0.4) + 0.03 * np.cos(2.0 * phase))
    assert found.number == pytest.approx(number, abs=1e-8)
    assert found.misfit < 1e-6


@pytest.mark.parametrize("count", [16, 24, 40])
def test_neither_noise_nor_chaos_is_a_torus(count):
    draws = np.random.default_rng(7).standard_normal((50, count))
    assert min(rotation(draw).misfit for draw in draws) > 0.15
    assert rotation(henon(count, 1.4)).misfit > 0.15
    assert rotation(draws[0][:15]) is None
    assert rotation(np.ones(count)) is None


def test_a_torus_needs_the_same_phase_in_period_and_rate():
    phase = 2.0 * np.pi * 0.2632 * K
    one, other = 1.0 + 0.01 * np.cos(phase), 1.0 + 0.01 * np.cos(1.5 * phase)
    cycles = Events(K, one, one, one, 2.0 * one, one)
    assert judge_motion(cycles, one, True, False, 24.0).rotation == pytest.approx(0.2632, abs=1e-6)
    assert judge_motion(cycles._replace(v_max=2.0 * other), one, True, False, 24.0).kind != "torus"


RUNS = 400


def autoregressive(memory, count):
    """Rows with mean 0 and correlation memory^k between values k apart."""
    noise = np.random.default_rng(11).standard_normal((RUNS, count + 100))
    rows = noise.copy()
    for k in range(1, count + 100):
        rows[:, k] += memory * rows[:, k - 1]
    return rows[:, 100:]


@pytest.mark.parametrize(
    ("memory", "count", "least"),
    [
        *((memory, count, 0.95) for memory in (-0.7, 0.0, 0.5) for count in (64, 256)),
        *(
            (memory, 100, least) for memory, least in ((0.9, 0.95), (0.95, 0.945))
        ),  # 87 of 100 with 0.95 without the margin by a fading memory
        (0.5, 24, 0.95),  # 92 of 100 by batches alone
    ],
)
def test_the_true_mean_is_within_the_margin_in_95_of_100_runs(memory, count, least):
    rows = autoregressive(memory, count)
    assert least <= np.mean([abs(row.mean()) <= margin_of_mean(row) for row in rows]) <= 0.995


def test_by_hand():
    """Batches of two with means 1, 2, ..., 6, in an order without memory: their deviation is sqrt(3.5). Neighbours
    alternate, so that the autocorrelations of one pair of lags say nothing."""
    values = np.repeat([1.0, 6.0, 3.0, 5.0, 4.0, 2.0], 2) + np.tile([10.0, -10.0], BATCHES)
    assert margin_of_mean(values) == pytest.approx(2.570581836 * np.sqrt(3.5) / np.sqrt(6.0), rel=1e-9)
    assert np.isnan(margin_of_mean(values[: FEWEST - 1]))


def test_autocorrelations_by_hand():
    """Covariances times 64 are 16, -1, -8, 3, ...: with one pair of lags, a window of 3 in 16, the variance is (2 15 - 16)/64
    over 1 - 3/16, known as that of 16/3 values. Neighbours alternate too often for a memory."""
    variance = 14.0 / 64.0 / (1.0 - 3.0 / 16.0)
    expected = t.ppf(0.975, 16.0 / 3.0) * np.sqrt(variance / 16.0)
    assert margin_of_mean(np.tile([0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0], 2)) == pytest.approx(expected, rel=1e-9)


def test_only_cycles_that_never_repeat_have_margins():
    column = np.linspace(1.0, 2.0, 16)
    events = Events(*[column] * 6)
    assert all(np.isnan(margin) for margin in summarise(events).margins.values())
    assert summarise(events, repeat=False).margins == dict.fromkeys(
        ("period", "stress_drop", "elastic_stress_drop"), margin_of_mean(column)
    ) | {"v_max_median": 1.0}  # from the least to the largest: so few values leave no less


class Logistic:
    """A solver whose only value x becomes r x (1 - x) every two transits; `counts` is no part of the motion."""

    model, failures, failed_at = "logistic", 0, math.nan
    seconds_per_piece, transits_per_piece = 0.0, WHOLE
    nodes, bookkeeping = np.array([0.0, 1.0]), frozenset({"counts"})

    def __init__(self, r, x=0.3):
        self.scene, self.r, self.steps = slipwave.read("paper"), r, 0
        self.now, self.x = np.zeros(1), np.array([x])

    @property
    def time(self):
        return float(self.now[0])

    def advance(self, until):
        one = np.zeros((1, 2))
        pieces = Pieces(self.now.copy(), np.array([WHOLE]), one, one, one, one)
        self.now, self.x, self.steps = self.now + WHOLE, self.r * self.x * (1.0 - self.x), self.steps + 1
        return pieces

    def state(self):
        return {"now": self.now.copy(), "x": self.x.copy(), "counts": np.array([float(self.steps)])}

    def restore(self, state):
        self.now, self.x, self.steps = state["now"].copy(), state["x"].copy(), int(state["counts"][0])

    def energy(self):
        return None


def test_the_exponent_of_an_irregular_map():
    """ln 2 in a step of the map with r = 4."""
    found = largest_exponent(Logistic(4.0), Logistic(4.0), WHOLE)
    assert found.rate == pytest.approx(0.5 * math.log(2.0), abs=1.5 * found.margin)
    assert 1e-4 < found.margin < 0.05
    assert found.transits == 400.0


def test_the_exponent_of_an_orbit_that_attracts():
    """The orbit of period 2 at r = 3.2 has the multiplier 4 + 2 r - r^2 = 0.16."""
    found = largest_exponent(Logistic(3.2), Logistic(3.2), 2.0 * WHOLE)
    assert found.rate == pytest.approx(math.log(0.16) / (2.0 * WHOLE), rel=1e-4)
    assert found.margin < 1e-5


class Refined(Logistic):
    """Its state has more entries from t = 4 on, as that of a solver that takes shorter steps."""

    def state(self):
        known = super().state()
        return known | {"x": np.repeat(known["x"], 2 if self.time < 4.0 else 3)}

    def restore(self, state):
        super().restore(state | {"x": state["x"][:1]})


def test_steps_that_are_refined_at_first_are_no_obstacle():
    found = largest_exponent(Refined(4.0), Refined(4.0), WHOLE)
    assert found.rate == pytest.approx(0.5 * math.log(2.0), abs=1.5 * found.margin)


def test_what_stays_has_no_exponent():
    with pytest.raises(NumericsError, match="slides steadily within rounding at t = 4 transits"):
        largest_exponent(Logistic(2.0, 0.5), Logistic(2.0, 0.5), WHOLE)


def test_work_without_end_is_refused_for_its_whole_length():
    """1040 intervals of 200 pieces: of each solver, 1 s a piece."""
    slow = Logistic(4.0), Logistic(4.0)
    slow[0].seconds_per_piece = slow[1].seconds_per_piece = 1.0
    with pytest.raises(SceneError, match=r"model logistic: 416002 transits would take about \d"):
        largest_exponent(*slow, 400.0, intervals=1000, most_seconds=2e5)


def exponent(model, log10_r, cycle, intervals, **options):
    scene = slipwave.read("paper", {"slab.log10_r": log10_r})
    solver, twin = (build(model, scene, **options) for _ in range(2))
    follow(solver, 1000.0)
    found = largest_exponent(solver, twin, cycle, intervals=intervals)
    assert solver.time == twin.time
    assert found.transits == intervals * WHOLE * round(cycle / WHOLE)
    return found


@pytest.mark.parametrize(("model", "options"), [("delay", {}), ("fd", {"cells": 12})])
def test_irregular_motions_part(model, options):
    """At log10 r = -2.5 all exact models have the same attractor; measured: 0.0163 to 0.0172 on five of them."""
    found = exponent(model, -2.5, 94.0, 32, **options)
    assert found.rate == pytest.approx(0.0166, abs=3.0 * found.margin)
    assert found.rate > found.margin > 0.0


@pytest.mark.parametrize("log10_r", [-2.66, -2.6, -2.3])
@pytest.mark.parametrize("model", ["block8", "block12"])
def test_cycles_of_blocks_neither_part_nor_meet(model, log10_r):
    """Their steps follow the motion and end at a given time only if they are told to."""
    found = exponent(model, log10_r, 76.0, 64)
    assert abs(found.rate) < min(max(found.margin, 1e-5), 1e-3)


@pytest.mark.parametrize(
    ("model", "log10_r"),
    [("quasidynamic", -2.656), ("block8", -2.703), ("block12", -2.703), ("modal:2", -2.703), ("kelvin-voigt", -2.703)],
)
def test_small_swings_part_as_their_root_says(model, log10_r):
    """Near steady sliding the exponent is the growth rate of the characteristic equation's leading root."""
    scene = slipwave.read("paper", {"slab.log10_r": log10_r, "start.kind": "jump", "start.size": 1e-3})
    solver, twin = (build(model, scene) for _ in range(2))
    rate = spectrum(scene, model).rate * scene.transit
    assert rate < -2e-4
    assert largest_exponent(solver, twin, 52.0).rate == pytest.approx(rate, rel=0.06)


@pytest.mark.parametrize(("name", "r"), [("machine", 0.00164), ("grip", 0.00165), ("layered", 0.00262)])
def test_errors_of_the_march_are_not_taken_for_chaos(name, r):
    """Swings of 1e-4 in psi: motions that were 1e-6 of their change apart would part at 0.02 by what the solves leave."""
    scene = slipwave.read(name, {"slab.r": r, "start.kind": "jump", "start.size": 1e-4})
    solver, twin = (build("delay", scene) for _ in range(2))
    rate = spectrum(scene, "delay").rate * scene.transit
    assert -1e-3 < rate < -2e-4
    assert largest_exponent(solver, twin, 52.0).rate == pytest.approx(rate, abs=6e-5)


def test_an_exponent_begins_behind_a_step_that_a_run_cut():
    scene = slipwave.read("paper", {"slab.log10_r": -2.3})
    solver, twin = (build("block8", scene) for _ in range(2))
    follow(solver, 1019.0)
    while "rest" not in solver.state():
        follow(solver, solver.time + 1.0)
    found = largest_exponent(solver, twin, 76.0, intervals=8)
    assert abs(found.rate) < 1e-3
    assert solver.time == twin.time == WHOLE * round(solver.time / WHOLE)


def test_motions_on_a_torus_do_not():
    found = exponent("delay", -2.65, 79.3, 48)
    assert abs(found.rate) < 2.0 * found.margin < 8e-3
