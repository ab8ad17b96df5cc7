"""V(t) and the nudge, in compiled code and in plain Python."""

import math

import numpy as np
import pytest

from slipwave.compiled import allocating
from slipwave.scene.drive import NUDGE_CENTRE, Constant, Drive, Ramps, nudge_rate, velocity_at

MANY = 10_000


@allocating
def sampled(drive, times):
    found = np.empty(times.size)
    for k in range(times.size):
        found[k] = velocity_at(drive, times[k], times[k])
    return found


@pytest.mark.parametrize("knots", [2, 3, MANY])
def test_ramps_are_the_broken_line_through_the_knots(knots):
    draw = np.random.default_rng(knots)
    drive = Drive(tuple(np.cumsum(draw.uniform(0.1, 2.0, knots)).tolist()), tuple(draw.uniform(-3.0, 5.0, knots).tolist()))
    times = np.linspace(drive.times[0] - 1.0, drive.times[-1] + 1.0, 4001)
    expected = np.interp(times, drive.times, drive.velocities)
    np.testing.assert_allclose(sampled(drive.compiled, times), expected, rtol=0, atol=1e-12)  # of slopes up to 80, times to 1e4
    np.testing.assert_allclose([drive.at(float(time)) for time in times[::40]], expected[::40], rtol=0, atol=1e-12)


def test_the_next_knot_lies_after_a_time():
    drive = Drive((0.0, 5.0, 5.0, 7.0), (1.0, 1.0, 2.0, 3.0))
    assert [drive.knot_after(time) for time in (-1.0, 0.0, 4.9, 5.0, 6.0, 7.0)] == [0.0, 5.0, 5.0, 7.0, 7.0, math.inf]
    assert Drive((0.0, 5.0), (1.0, 1.0)).knot_after(0.0) == math.inf


@pytest.mark.parametrize("before", [2, 999])
def test_a_time_given_twice_is_a_step(before):
    times = (*(float(k) for k in range(before)), 1000.0, 1000.0, 1003.0)
    drive = Drive(times, (4.0,) * before + (4.0, 7.0, 1.0))
    near = np.nextafter(1000.0, 0.0)
    assert sampled(drive.compiled, np.array([near, 1000.0, 1001.5, 1003.0])).tolist() == [4.0, 7.0, 4.0, 1.0]
    assert drive.knots == (*times[:-2], 1003.0)


def test_a_step_of_a_march_sees_one_stretch_of_the_drive():
    drive = Drive((0.0, 5.0, 5.0, 6.0), (1.0, 3.0, 8.0, 10.0)).compiled
    assert isinstance(drive, Ramps)
    assert [velocity_at(drive, time, 4.9) for time in (5.0, 5.0 + 1e-9, 0.0)] == pytest.approx([3.0, 3.0, 1.0], abs=1e-8)
    assert [velocity_at(drive, time, 5.1) for time in (5.0, 5.0 - 1e-9, 6.0)] == pytest.approx([8.0, 8.0, 10.0], abs=1e-8)
    assert [velocity_at(drive, time, 6.5) for time in (5.9, 6.0, 7.0)] == [10.0] * 3


def test_only_a_drive_that_changes_is_searched():
    assert Drive((0.0, 4.0), (2.0, 2.0)).compiled == Constant(2.0)
    assert [Drive((0.0, 4.0), (2.0, last)).knots for last in (2.0, 3.0)] == [(), (0.0, 4.0)]
    at_once = Drive((0.0, 0.0), (2.0, 5.0))
    assert (at_once.initial, at_once.at(0.0), at_once.knots, at_once.rests_from(0.0)) == (2.0, 5.0, (0.0,), True)


@pytest.mark.parametrize("late", [-6.0, -1.5, 0.0, 0.3, 6.9])
def test_the_nudge_is_a_bell_around_its_centre(late):
    for size in (0.5, 1.0):
        assert nudge_rate(size, NUDGE_CENTRE + late) == pytest.approx(size * math.exp(-(late**2)), rel=1e-13)
        assert nudge_rate(size, NUDGE_CENTRE + 7.1) == 0.0  # exp(-49) is below rounding
