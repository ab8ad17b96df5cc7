"""Branches of periodic orbits against closed forms (`tests.orbit_by_hand`)."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from reduced.continuation.branch import Control, follow_branch
from reduced.continuation.point import FlowFamily, Metric
from reduced.continuation.special import specials_between, trend_of
from reduced.continuation.start import from_hopf, from_orbit, from_stored, stored
from reduced.orbit.closing import CLOSES_TO, close
from slipwave.errors import NumericsError
from tests.orbit_by_hand import SHRINKS, SNAKE, SUBCRITICAL, SUPERCRITICAL, TURN, FlowByHand, Oscillator
from validation.models.points import point_of

METRIC = Metric(2.0 * math.pi, 1.0)
WIDEST = 2.1e-9
"""Of a bracket: 1e-9 of the metric's parameter on either side."""
CONTROL = Control(first=1e-2, longest=0.2)


def family_of(oscillator, **settings):
    return FlowFamily(FlowByHand(oscillator, 0.0, **settings), lambda p: SimpleNamespace(p=p))


def at(family, oscillator, s, towards=9.0, metric=METRIC):
    """The point of the branch with |w|^2 = s."""
    p = float(oscillator.g(s))
    return from_orbit(family, close(family(p), oscillator.state(s), oscillator.period(s)), p, towards, metric)


def squared(point):
    """|w|^2."""
    return float(point.closed.cycle.start[-2:] @ point.closed.cycle.start[-2:])


def branch(family, first, inside, metric=METRIC, control=CONTROL):
    return list(follow_branch(family, first, metric, inside, 1e-8, control))


def events(steps):
    return [special for step in steps for special in step.special]


def require_closed_form(oscillator, steps):
    """Every point lies on the branch and has the period and the multiplier that it should have."""
    for step in steps:
        s, point = squared(step.point), step.point
        assert point.parameter == pytest.approx(oscillator.g(s), abs=1e-9)
        assert point.closed.cycle.period == pytest.approx(oscillator.period(s), abs=1e-9)
        assert point.multipliers[-1].real == pytest.approx(oscillator.multiplier(s), abs=1e-4, rel=2e-3)


def test_the_first_orbit_beside_a_hopf_point():
    """With 0.02 of psi along the oscillation, s = 0.0004."""
    for oscillator in (SUPERCRITICAL, SUBCRITICAL):
        first = from_hopf(family_of(oscillator), 0.0, 2.0 * math.pi, METRIC)
        assert squared(first) == pytest.approx(4e-4, rel=1e-6)
        assert first.parameter == pytest.approx(oscillator.g(4e-4), abs=1e-10)
        assert first.closed.cycle.period == pytest.approx(oscillator.period(4e-4), abs=1e-9)
        assert first.unstable == (oscillator is SUBCRITICAL)
        assert first.tangent[:2] @ first.closed.cycle.start > 0.0
    with pytest.raises(NumericsError, match=r"does not oscillate with a period of 5\.5 transits"):
        from_hopf(family_of(SUPERCRITICAL), 0.0, 5.5, METRIC)


def test_the_direction_of_a_branch():
    """dT : dp : d|w| = T'(s) : g'(s) : 1/(2 |w|), of length 1, towards the parameter asked for."""
    for s, towards in ((0.2, 1.0), (0.2, -1.0), (0.7, 1.0)):
        point = at(family_of(SUBCRITICAL), SUBCRITICAL, s, towards)
        change = np.array([-SUBCRITICAL.period(s) * 0.3 / (1.0 + 0.3 * s), SUBCRITICAL.slope(s)])
        expected = np.r_[0.5 * SUBCRITICAL.state(s) / s, change]
        expected *= np.sign(towards * expected[-1]) / METRIC.length(expected)
        np.testing.assert_allclose(point.tangent, expected, rtol=0.0, atol=1e-6)


def test_a_subcritical_branch_turns_at_its_fold():
    """p = s^2 - s: the fold at p = -1/4 has s = 1/2; its unstable orbits become stable."""
    family = family_of(SUBCRITICAL)
    steps = branch(family, from_hopf(family, 0.0, 2.0 * math.pi, METRIC), lambda q: q.parameter < 0.05)
    (fold,) = events(steps)
    assert (fold.kind, fold.unstable_before, fold.unstable_after) == ("LP", 1, 0)
    assert fold.point.parameter == pytest.approx(-0.25, abs=1e-11)
    assert fold.point.closed.cycle.period == pytest.approx(2.0 * math.pi / 1.15, abs=1e-4)
    assert fold.multiplier == pytest.approx(1.0, abs=1e-3)
    assert fold.bracket == CLOSES_TO  # the parameter hardly changes beside a fold, but orbits close to this only
    require_closed_form(SUBCRITICAL, steps)


def test_where_multipliers_cannot_be_counted_folds_are_found_all_the_same():
    """The same branch, beside it a pair that would pass the circle: no count, no torus point."""
    oscillator = SUBCRITICAL._replace(beside=lambda p: p + 0.1)
    family = family_of(oscillator, radius=1.0)
    steps = branch(family, at(family, oscillator, 0.2, towards=-9.0), lambda q: q.parameter < 0.05)
    (fold,) = events(steps)
    assert (fold.kind, fold.unstable_before, fold.unstable_after) == ("LP", 0, 0)
    assert fold.point.parameter == pytest.approx(-0.25, abs=1e-11)
    points = [point_of(step.point) for step in steps]
    assert {(point.unstable, point.stable) for point in points} == {(None, None)}


def snake_folds(highest):
    """(p, s) where g'(s) = 0.02 + 0.18 cos 6 s vanishes, up to s = `highest`."""
    first = math.acos(-1.0 / 9.0)
    values = sorted(sign * first + 2.0 * math.pi * k for sign in (1, -1) for k in range(20))
    return [(SNAKE.g(x / 6.0), x / 6.0) for x in values if 0.6 < x < 6.0 * highest]


@pytest.mark.filterwarnings("error::scipy.linalg.LinAlgWarning")
@pytest.mark.parametrize("longest", [0.2, 5.0])
def test_a_branch_that_folds_back_and_forth_is_never_reversed(longest):
    """However long the steps may be, s grows, every fold is found once, and the counts alternate."""
    family, metric = family_of(SNAKE), Metric(0.5, 0.1)
    first, control = at(family, SNAKE, 0.1, metric=metric), Control(1e-2, longest=longest)
    steps = branch(family, first, lambda q: squared(q) < 1.6, metric, control)
    assert (np.diff([squared(step.point) for step in steps]) > 0.0).all()
    folds, expected = events(steps), snake_folds(squared(steps[-1].point))
    assert [fold.kind for fold in folds] == ["LP"] * len(expected)
    assert [fold.unstable_after for fold in folds] == [1, 0, 1, 0, 1, 0][: len(folds)]
    assert [fold.point.parameter for fold in folds] == pytest.approx([p for p, _ in expected], abs=1e-10)
    assert [squared(fold.point) for fold in folds] == pytest.approx([s for _, s in expected], abs=1e-4)
    require_closed_form(SNAKE, steps)


def beside(rate, **shape):
    return SUPERCRITICAL._replace(beside=rate, **shape)


def test_a_pair_that_passes_the_unit_circle():
    oscillator = beside(lambda p: p - 0.5)
    family, period = family_of(oscillator), oscillator.period(0.5)
    (torus,) = events(branch(family, at(family, oscillator, 0.3), lambda q: q.parameter < 0.7))
    assert (torus.kind, torus.unstable_before, torus.unstable_after) == ("NS", 0, 2)
    assert torus.point.parameter == pytest.approx(0.5, abs=1e-9)
    assert torus.point.closed.cycle.period == pytest.approx(period, abs=1e-8)
    angle = TURN * period
    assert torus.multiplier == pytest.approx(complex(math.cos(angle), abs(math.sin(angle))), abs=1e-8)
    assert torus.bracket < WIDEST


@pytest.mark.parametrize("sign", [1, -1])
def test_a_multiplier_that_passes_minus_one(sign):
    """The other one of the strip stays at -exp(-0.4 T)."""
    oscillator = beside(lambda p: sign * (p - 0.5), moebius=True)
    family, period = family_of(oscillator), oscillator.period(0.5)
    (doubling,) = events(branch(family, at(family, oscillator, 0.3), lambda q: q.parameter < 0.7))
    assert (doubling.kind, doubling.unstable_before, doubling.unstable_after) == ("PD", *((0, 1) if sign > 0 else (1, 0)))
    assert doubling.point.parameter == pytest.approx(0.5, abs=1e-9)
    assert doubling.multiplier == pytest.approx(-1.0, abs=1e-8)
    assert doubling.point.multipliers[1] == pytest.approx(-math.exp(SHRINKS * period), abs=1e-8)
    assert doubling.bracket < WIDEST


def test_a_doubling_beside_a_multiplier_that_is_nearer_to_minus_one():
    """The test function has one sign at both ends: -0.13 is nearer to -1 than -2.8."""
    oscillator = beside(lambda p: p - 0.5, moebius=True)
    family = family_of(oscillator)
    (doubling,) = specials_between(family, at(family, oscillator, 0.3), at(family, oscillator, 0.7), METRIC)
    assert (doubling.kind, doubling.unstable_before, doubling.unstable_after) == ("PD", 0, 1)
    assert doubling.point.parameter == pytest.approx(0.5, abs=1e-11)
    assert doubling.multiplier == pytest.approx(-1.0, abs=1e-9)
    assert CLOSES_TO <= doubling.bracket < WIDEST


def test_events_within_one_step_are_told_apart():
    """A period doubling at p = -0.2495, on both sides of the fold: s = 0.5 -+ sqrt(0.0005)."""
    oscillator = SUBCRITICAL._replace(beside=lambda p: 40.0 * (p + 0.2495), moebius=True)
    family = family_of(oscillator)
    found = events(
        branch(family, at(family, oscillator, 0.4, -1.0), lambda q: q.parameter < -0.2, control=Control(0.1, longest=0.2))
    )
    assert [one.kind for one in found] == ["PD", "LP", "PD"]
    assert [one.point.parameter for one in found] == pytest.approx([-0.2495, -0.25, -0.2495], abs=1e-9)
    assert [(one.unstable_before, one.unstable_after) for one in found] == [(2, 1), (1, 0), (0, 1)]


def test_a_count_that_no_event_explains_ends_the_branch():
    """Without a turn two multipliers pass 1 together, where the branch does not fold."""
    oscillator = beside(lambda p: p - 0.5, turn=0.0)
    family, control = family_of(oscillator), replace(CONTROL, shortest=1e-3)
    with pytest.raises(NumericsError, match=r"changes from 0 to 2 near parameter = 0\.4999.*no single special point explains it"):
        branch(family, at(family, oscillator, 0.3), lambda q: q.parameter < 0.7, control=control)


def test_a_stored_point_goes_on_as_the_branch_did():
    """Through arrays only, on the mesh that the branch had there; the family given has another."""
    family = family_of(SUBCRITICAL, roughest=2e-8)
    steps = branch(family, from_hopf(family, 0.0, 2.0 * math.pi, METRIC), lambda q: q.parameter < 0.1)
    middle = next(k for k, step in enumerate(steps) if step.special)
    saved = stored(steps[middle].point, steps[middle].next_step)
    again, point, step = from_stored(family, saved)
    assert again(0.0).steps == steps[middle].point.closed.flow.steps != 6
    assert all(step.point.closed.flow.roughness(step.point.closed.cycle, 1e-8) <= 1.0 for step in steps)
    assert point.closed.residual < 1e-11
    rest = branch(again, point, lambda q: q.parameter < 0.1, control=replace(CONTROL, first=step))
    expected = [step.point.unknowns for step in steps[middle + 1 :]]
    np.testing.assert_array_equal([step.point.unknowns for step in rest], expected)


def test_a_branch_that_is_lost_says_where():
    """Steps of 0.3 and more cannot follow the turn at the fold; they begin at p = -0.21."""
    family, control = family_of(SUBCRITICAL), Control(0.6, shortest=0.3)
    with pytest.raises(NumericsError, match=r"cannot be followed beyond parameter = -0\.21, period 5\.764"):
        branch(family, at(family, SUBCRITICAL, 0.3, -1.0), lambda q: q.parameter < 0.9, control=control)


def test_a_vertical_branch_says_what_to_do_instead():
    """With g = s 1e-10 all orbits lie at p = 0; periods shrink so fast with s that no step of 0.3 is straight enough."""
    vertical = Oscillator(lambda s: 1e-10 * s, lambda s: 1e-10, 5.0)
    family = family_of(vertical)
    with pytest.raises(NumericsError) as failed:
        branch(family, at(family, vertical, 0.3), lambda q: True, control=Control(0.6, shortest=0.3))
    said = str(failed.value)
    assert said.startswith("the branch is vertical at parameter = ")
    assert "period 2.51327 transits: orbits of all sizes lie there within rounding errors" in said


def test_two_folds_between_two_points_are_found():
    """A narrow pair at s = 0.5 -+ sqrt(0.001): both ends go towards larger p and have the same count."""
    narrow = Oscillator(lambda s: (s - 0.5) ** 3 - 0.003 * (s - 0.5), lambda s: 3.0 * (s - 0.5) ** 2 - 0.003, 0.02)
    family, metric = family_of(narrow), Metric(0.5, 0.1)
    ends = [at(family, narrow, s, metric=metric) for s in (0.44, 0.57)]
    found = specials_between(family, *ends, metric)
    assert [(fold.kind, fold.unstable_before, fold.unstable_after) for fold in found] == [("LP", 0, 1), ("LP", 1, 0)]
    size = 2.0 * 0.001**1.5
    assert [fold.point.parameter for fold in found] == pytest.approx([size, -size], abs=1e-10)


@pytest.mark.parametrize(("kind", "moebius"), [("NS", False), ("PD", True)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("height", [0.05, 3e-3, 1e-4, -1e-6, -0.01])
def test_a_pair_of_special_points_within_a_step_is_found(height, sign, kind, moebius):
    """A multiplier that leaves the circle, or dips into it, around p = 0.5 is as stable at both ends."""
    oscillator = beside(lambda p: sign * (height - (p - 0.5) ** 2), moebius=moebius)
    family = family_of(oscillator)
    before, left, right = (at(family, oscillator, p) for p in (0.1, 0.2, 0.8))
    found = specials_between(family, left, right, METRIC, trend_of(before, left, METRIC.length(left.unknowns - before.unknowns)))
    places = [0.5 - height**0.5, 0.5 + height**0.5] if height > 0.0 else []
    assert ([one.kind for one in found], left.unstable) == ([kind] * len(places), right.unstable)
    assert [one.point.parameter for one in found] == pytest.approx(places, abs=1e-8)
