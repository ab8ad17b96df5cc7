"""Curves of special points in two parameters against closed forms and an exact symmetry of the equations."""

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from reduced.continuation.branch import Control, follow_branch
from reduced.continuation.curve import CURVE_STEPS, METRIC, OnCurve, Plane, beginning, crossing, follow_curve, turn
from reduced.continuation.point import FlowFamily, direction
from reduced.continuation.start import from_hopf, from_orbit, metric_for
from reduced.delay.flow import DelayFlow
from reduced.orbit.closing import by_parameter, close
from reduced.parameters import with_parameter
from slipwave import read
from slipwave.errors import NumericsError
from tests.orbit_by_hand import SUPERCRITICAL, FlowByHand, Oscillator


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
    first = from_orbit(family, close(family(p), oscillator.state(s), oscillator.period(s)), p, ahead, METRIC)
    found = (special for step in follow_branch(family, first, METRIC, lambda point: True, 1e-8) for special in step.special)
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


def test_a_curve_that_turns_back_in_both_parameters():
    start, points = curve("NS", circle, 0.2, (0.0, 1.0), 42, Control(2e-2, 1e-5, 0.04))
    assert start.parameters == pytest.approx((0.3, 0.0), abs=1e-9)
    places = np.array([place for place, _ in points])
    np.testing.assert_allclose(np.hypot(places[:, 0] - 0.5, places[:, 1]), 0.2, rtol=0.0, atol=1e-8)
    angles = np.unwrap(np.arctan2(places[:, 1], 0.5 - places[:, 0]))
    assert (np.diff(angles) > 0.0).all()
    assert angles[-1] > 2.0 * math.pi
    assert all(special.bracket < 3e-9 for _, special in points)


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


def test_folds_depend_on_two_products_alone():
    """With time in units of L/V the equations contain epsilon V and r V only, and psi is shifted by ln V. So an orbit at V is one
    at 100 with epsilon and r larger by V/100; a fold is a fold there."""
    base = read("paper")
    metric = metric_for(-2.72, -2.3)
    family = FlowFamily(DelayFlow(base, 6.0), lambda p: with_parameter(base, "log10_r", p))
    first = from_hopf(family, -2.6995497159, 49.66818383, metric)
    steps = follow_branch(family, first, metric, lambda point: True, 1e-6)
    (fold,) = next(step.special for step in steps if step.special)
    plane = Plane(lambda p, v: with_parameter(family(p).scene, "V", v), (0.4, 100.0))
    start = OnCurve((fold.point.parameter, 100.0), fold)
    steps = follow_curve(
        plane, beginning(start, (0.0, 1.0), replace(CURVE_STEPS, first=0.02)), 1e-6, replace(CURVE_STEPS, first=0.02)
    )
    for (p, v), special in (one.last for one in itertools.islice(steps, 4)):
        point, share = special.point, v / 100.0
        epsilon = with_parameter(base, "epsilon", 2.8e-5 * share)
        other = FlowFamily(point.closed.flow.of(epsilon), lambda q, scene=epsilon: with_parameter(scene, "log10_r", q))
        at = p + math.log10(share)
        state = point.unknowns[:-2] - point.closed.flow.steady + other(at).steady
        closed = close(other(at), state, point.closed.cycle.period)
        assert closed.cycle.period == pytest.approx(point.closed.cycle.period, rel=1e-11)
        np.testing.assert_allclose(closed.cycle.start, state, rtol=0.0, atol=1e-11)
        known = replace(closed, parameter=at, drift=by_parameter(other, closed.cycle, at))
        assert abs(direction(known, point.tangent, metric)[-1]) < 1e-6
    assert v > 103.0
