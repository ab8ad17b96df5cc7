"""Branches of periodic orbits against closed forms (`tests.orbit_by_hand`)."""

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from reduced.continuation.branch import Control, follow_branch
from reduced.continuation.curve import CURVE_STEPS, OnCurve, Plane, beginning, crossing, follow_curve, turn
from reduced.continuation.curve import METRIC as ON_PLANE
from reduced.continuation.point import FlowFamily, Metric
from reduced.continuation.special import specials_between, trend_of
from reduced.continuation.start import from_hopf, from_orbit
from reduced.orbit.closing import CLOSES_TO, close
from slipwave.errors import NumericsError
from tests.orbit_by_hand import SHRINKS, SNAKE, SUBCRITICAL, SUPERCRITICAL, TURN, FlowByHand, Oscillator
from validation.models.points import BranchPoint

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
    points = [BranchPoint.of(step.point) for step in steps]
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


class TwoParameters(FlowByHand):
    made = staticmethod(lambda q: SUPERCRITICAL)

    def of(self, scene):
        return replace(self, parameter=scene.p, oscillator=type(self).made(scene.q))


def scene_of(p, q):
    return SimpleNamespace(p=p, q=q)


def curve(kind, made, s, towards, count, steps=CURVE_STEPS, ahead=9.0, **settings):
    """The first `count` points after the one on the branch at q = 0 beyond |w|^2 = s, and that one."""
    flow_type = type("Made", (TwoParameters,), {"made": staticmethod(made)})
    oscillator, plane = made(0.0), Plane(scene_of, (1.0, 1.0))
    flow = flow_type(oscillator, 0.0, **settings)
    family = FlowFamily(flow, lambda p: scene_of(p, 0.0))
    p = float(oscillator.g(s))
    first = from_orbit(family, close(family(p), oscillator.state(s), oscillator.period(s)), p, ahead, ON_PLANE)
    found = (special for step in follow_branch(family, first, ON_PLANE, lambda point: True, 1e-8) for special in step.special)
    special = next(one for one in found if one.kind == kind)
    start = OnCurve((special.point.parameter, 0.0), special)
    reached = follow_curve(plane, beginning(start, towards, steps), 1e-8, steps)
    return start, [one.last for one in itertools.islice(reached, count)]


def leaning(q):
    """g = s^2 - (1 + q) s: the fold at s = (1 + q)/2 has p = -(1 + q)^2/4."""
    return Oscillator(lambda s: s * s - (1.0 + q) * s, lambda s: 2.0 * s - 1.0 - q)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_curve_of_folds(sign):
    start, points = curve("LP", leaning, 0.3, (0.0, sign), 8, ahead=-9.0)
    assert start.parameters == pytest.approx((-0.25, 0.0), abs=1e-9)
    for (p, q), special in points:
        assert p == pytest.approx(-0.25 * (1.0 + q) ** 2, abs=1e-10)
        assert special.point.closed.cycle.period == pytest.approx(2.0 * math.pi / (1.0 + 0.15 * (1.0 + q)), abs=1e-4)
        assert (special.kind, special.unstable_before + special.unstable_after) == ("LP", 1)
    assert (sign * np.diff([0.0, *(place[1] for place, _ in points)]) > 0.0).all()


def test_the_mesh_of_a_curve_is_refined_as_the_motion_gets_rougher():
    """|w| grows along the folds, and with it the roughness; beyond 1 the mesh does not reach the tolerance of 1e-8."""
    start, points = curve("LP", leaning, 0.3, (0.0, 1.0), 3, replace(CURVE_STEPS, first=0.05), -9.0, roughest=1.7e-7)
    flows = [special.point.closed.flow for _, special in (start, *points)]
    rough = [flow.roughness(one.special.point.closed.cycle, 1e-8) for flow, one in zip(flows, (start, *points), strict=True)]
    assert flows[-1].steps > flows[0].steps
    assert max(rough) <= 1.0
    assert [p for (p, _), _ in points] == pytest.approx([-0.25 * (1.0 + q) ** 2 for (_, q), _ in points], abs=1e-10)


def cubic(q):
    """g = (s - 1)^3 + (q - 0.02) (s - 1) + q/2: folds at s = 1 +- sqrt((0.02 - q)/3), which meet at q = 0.02 with p = 0.01."""
    return Oscillator(lambda s: (s - 1.0) ** 3 + (q - 0.02) * (s - 1.0) + 0.5 * q, lambda s: 3.0 * (s - 1.0) ** 2 + q - 0.02)


@pytest.mark.parametrize(("begin", "side", "ahead"), [(0.8, -1.0, 9.0), (1.2, 1.0, -9.0)])
def test_a_curve_of_folds_ends_at_a_cusp(begin, side, ahead):
    """Either of both folds leads to it."""
    _, points = curve("LP", cubic, begin, (0.0, 1.0), 60, replace(CURVE_STEPS, first=0.002), ahead)
    *folds, cusp = points
    for (p, q), special in folds:
        apart = side * math.sqrt((0.02 - q) / 3.0)
        assert p == pytest.approx(0.5 * q - 2.0 * apart**3, abs=1e-10)
        assert special.kind == "LP"
    assert (cusp.special.kind, cusp.parameters) == ("CP", (pytest.approx(0.01, abs=1e-7), pytest.approx(0.02, abs=1e-7)))
    assert cusp.special.point.closed.cycle.period == pytest.approx(2.0 * math.pi / 1.3, rel=1e-4)
    assert {special.unstable_before + special.unstable_after for _, special in folds} == {1}
    assert (cusp.special.unstable_before, cusp.special.unstable_after) == (0, 0)


def circle(q):
    """A pair passes the unit circle where (p - 0.5)^2 + q^2 = 0.04."""
    return SUPERCRITICAL._replace(beside=lambda p: (p - 0.5) ** 2 + q * q - 0.04)


def test_a_curve_that_turns_within_a_hundred_thousandth():
    """Of an ellipse 0.004 wide and 0.4 high the radius at the tip is 2e-5: the torus ends there."""

    def thin(q):
        return SUPERCRITICAL._replace(beside=lambda p: 0.1 * math.tanh(((p - 0.5) / 2e-3) ** 2 + (q / 0.2) ** 2 - 1.0))

    start, points = curve("NS", thin, 0.2, (0.0, 1.0), 75, Control(2e-2, 1e-9, 0.04))
    places = np.array([place for place, _ in points])
    assert start.parameters == pytest.approx((0.498, 0.0), abs=1e-9)
    np.testing.assert_allclose(np.hypot((places[:, 0] - 0.5) / 2e-3, places[:, 1] / 0.2), 1.0, rtol=0.0, atol=1e-5)
    assert places[:, 1].max() == pytest.approx(0.2, abs=2e-6)


def test_where_a_curve_turns_and_returns():
    """The circle's highest point, from neighbours up to 0.04 away, and where it is back at the height of its beginning."""
    plane, steps = Plane(scene_of, (1.0, 1.0)), Control(2e-2, 1e-5, 0.04)
    start, points = curve("NS", circle, 0.2, (0.0, 1.0), 20, steps)
    trail = list(itertools.islice(follow_curve(plane, beginning(start, (0.0, 1.0), steps), 1e-8, steps), 20))
    top = max(range(20), key=lambda k: points[k].parameters[1])
    found, width = turn(plane, trail[top - 1], trail[top], trail[top + 1], 1.0, 1e-8)
    assert found.parameters == (pytest.approx(0.5, abs=1e-4), pytest.approx(0.2, abs=1e-8))
    assert width < 1e-6
    below = next(k for k in range(20) if points[k].parameters[1] < 0.0)
    back = crossing(plane, trail[below - 1], trail[below], 0.0, 1e-8)
    assert back.parameters == (pytest.approx(0.7, abs=1e-8), pytest.approx(0.0, abs=1e-8))


def test_a_curve_that_ends_says_where():
    """Beyond q = 0.1 the pair does not exist."""

    def ended(q):
        return circle(0.0) if q < 0.1 else SUPERCRITICAL._replace(beside=lambda p: -0.1)

    with pytest.raises(NumericsError, match=r"cannot be followed beyond the parameters 0\.3, 0\.(1|099\d*): "):
        curve("NS", ended, 0.2, (0.0, 1.0), 40)
