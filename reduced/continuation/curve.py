"""Special points of branches followed in two parameters: curves of folds, period doublings and torus points.

A curve is followed in the plane of both parameters. Through each predicted point a line is laid across the curve; along it, the
orbits are a branch in one parameter, on which the special point is located as on any other (`special`), between two orbits on
either side. So a curve may turn back in either parameter, every point has its bracket and its index, and no extended system can
converge to a neighbouring special point.
"""

import cmath
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from reduced.continuation.branch import TURNS, Control, longest
from reduced.continuation.point import FlowFamily, Metric, OrbitPoint, on_finer_mesh, point_near
from reduced.continuation.special import Special, specials_between
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene

Values = tuple[float, float]
"""Values of both parameters, or a direction in their plane."""

METRIC = Metric(20.0, 1.0)
"""On a line: one scale of the parameters counts as much as twenty transits of period."""

LARGEST_TURN = 0.3
"""Radians between a step and the one before it."""

_REACHES = (2e-4, 1e-3, 4e-3, 0.016, 2e-5, 2e-6)  # of the search on both sides, in the metric; short ones tell near points apart
_GROWTH = 1.5
_APART = 2e-3  # of points on the branch, in the metric, from whose slopes that of its flattest point is interpolated
_MEET = 0.1  # largest distance of a fold from the flattest point between it and the fold that it meets at a cusp
_TURN, _CROSSING = 1e-3, 1e-9  # relative accuracy of the place of a turn, and that of a crossing in units of the plane
_CENTRED, _CENTRINGS, _SECANTS = 0.01, 12, 12
_BEYOND_FOLD, _CUSP = 1e-5, 1e-7  # first and last step towards a cusp, in units of the plane
_ROUNDED = 1e-6  # slopes near a cusp, where they differ by 1e-7 from line to line


@dataclass(frozen=True)
class Plane:
    """The plane of two parameters: `scene_at` gives the scene at their values, `scale` their units of length. Points, steps and
    directions in the plane are complex numbers."""

    scene_at: Callable[[float, float], Scene]
    scale: Values

    def values(self, at: complex) -> Values:
        """Values of both parameters at a point of the plane."""
        return at.real * self.scale[0], at.imag * self.scale[1]

    def at(self, values: Values) -> complex:
        """The inverse of `values`."""
        return complex(values[0] / self.scale[0], values[1] / self.scale[1])


class OnCurve(NamedTuple):
    """A `special` point at values of both `parameters`; its own parameter is the distance along the line on which it was
    located."""

    parameters: Values
    special: Special


class CurveState(NamedTuple):
    """State of following a curve: its last two points (at the beginning both are the first), the direction of the step between
    them (at the beginning, of the next), and the length of the next step."""

    before: OnCurve
    last: OnCurve
    direction: Values
    length: float


CURVE_STEPS = Control(2e-3, 1e-9, 0.05)
"""Lengths of steps in the plane, in units of its scales; where a torus ends its curve may turn within 1e-5."""

_AT_CUSP = 1e-5  # shortest step of a curve of folds: those at a cusp are too near to be told apart


def beginning(start: OnCurve, towards: Values, steps: Control = CURVE_STEPS) -> CurveState:
    """Beginning of a curve at `start`, a special point of a branch in the first parameter, in the direction `towards`."""
    return CurveState(start, start, towards, steps.first)


def follow_curve(plane: Plane, reached: CurveState, tolerance: float, steps: Control = CURVE_STEPS) -> Iterator[CurveState]:
    """Yield the points of the curve after `reached` on meshes that keep relative errors of the figures below `tolerance`: without
    end, but for a curve of folds, which ends with the cusp, of kind CP, where it meets another. Raises NumericsError, after
    yielding all earlier points, where the curve cannot be followed.
    """
    while True:
        try:
            folds = reached.last.special.kind == "LP"
            new = _next(plane, reached, tolerance, max(steps.shortest, _AT_CUSP) if folds else steps.shortest)
        except NumericsError:
            end = _cusp_after(plane, reached) if reached.last.special.kind == "LP" else None
            if end is None:
                raise
            yield end
            return
        step = plane.at(new.parameters) - plane.at(reached.last.parameters)
        used = abs(step)
        reached = CurveState(reached.last, new, (step.real / used, step.imag / used), min(steps.longest, _GROWTH * used))
        yield reached


def _next(plane: Plane, reached: CurveState, tolerance: float, shortest: float) -> OnCurve:
    before, last, direction, length = reached

    def step(length: float) -> OnCurve:
        new = _across(plane, reached, length, tolerance)
        turn = (plane.at(new.parameters) - plane.at(last.parameters)) / complex(*direction)
        if before is not last and not abs(cmath.phase(turn)) < LARGEST_TURN:
            raise NumericsError(TURNS)
        return new

    try:
        return longest(step, length, shortest)
    except NumericsError as reason:
        at = ", ".join(f"{value:.8g}" for value in last.parameters)
        raise NumericsError(f"the curve cannot be followed beyond the parameters {at}: {reason}") from None


def _across(plane: Plane, reached: CurveState, length: float, tolerance: float) -> OnCurve:
    """The special point on the line across the curve at the predicted point, a step of `length` after the last one."""
    _, last, direction, _ = reached
    centre, line = plane.at(last.parameters) + length * complex(*direction), complex(*direction) / 1j
    known = last.special.point
    family = FlowFamily(known.closed.flow, lambda along: plane.scene_at(*plane.values(centre + along * line)))
    point = point_near(family, _predicted(plane, reached, centre), known.tangent, METRIC)
    special = _nearest(family, point, last.special.kind)
    if special.point.roughness(tolerance) > 1.0:
        family, point = on_finer_mesh(family, special.point, METRIC, tolerance)
        special = _nearest(family, point, last.special.kind)
    return OnCurve(plane.values(centre + special.point.parameter * line), special)


def _predicted(plane: Plane, reached: CurveState, centre: complex) -> Array:
    """Guess of the unknowns at the centre of a line: the last point's deviation from steady sliding, extrapolated along the
    secant if both points have the same mesh."""
    before, last = reached.before, reached.last
    guess, earlier = _deviation(last), _deviation(before)
    if before is not last and earlier.size == guess.size:
        share = abs(centre - plane.at(last.parameters)) / abs(plane.at(last.parameters) - plane.at(before.parameters))
        guess = guess + share * (guess - earlier)
    steady = last.special.point.closed.flow.of(plane.scene_at(*plane.values(centre))).steady
    return np.concatenate([guess[:-2] + steady, [guess[-2], 0.0]])


def _deviation(known: OnCurve) -> Array:
    """Unknowns minus those of steady sliding."""
    point = known.special.point
    return np.asarray(point.unknowns - np.append(point.closed.flow.steady, [0.0, 0.0]))


def _nearest(family: FlowFamily, point: OrbitPoint, kind: str) -> Special:
    """The special point of `kind` on the branch through `point` that is nearest to it."""
    for reach in _REACHES:
        left, right = (
            point_near(family, point.unknowns + shift * point.tangent, point.tangent, METRIC, point) for shift in (-reach, reach)
        )
        specials = [special for special in specials_between(family, left, right, METRIC) if special.kind == kind]
        if specials:
            return min(specials, key=lambda special: METRIC.length(special.point.unknowns - point.unknowns))
    raise NumericsError(f"no {kind} was found near an orbit of period {point.closed.cycle.period:.6g}")


def turn(
    plane: Plane, reached: CurveState, near: CurveState, beyond: CurveState, sign: float, tolerance: float
) -> tuple[OnCurve, float]:
    """The point between those `reached` and `beyond`, around that `near`, at which `sign` times the second parameter is largest,
    and the width that contains this parameter's extreme."""
    from scipy.optimize import minimize_scalar

    at = _Line(plane, reached, tolerance, (near.last, beyond.last))
    low, middle, high = sorted(at.known)
    minimize_scalar(lambda length: -sign * at(length), bracket=(low, middle, high), tol=_TURN)
    best, next_best = sorted(at.known, key=lambda length: -sign * at(length))[:2]
    return at.known[best], abs(at(best) - at(next_best))


def crossing(plane: Plane, reached: CurveState, beyond: CurveState, second: float, tolerance: float) -> OnCurve:
    """The point between those `reached` and `beyond` at which the second parameter has the value `second`."""
    from scipy.optimize import brentq

    at = _Line(plane, reached, tolerance, (beyond.last,))
    low, high = sorted(at.known)
    brentq(lambda length: at(length) - second, low, high, xtol=_CROSSING)
    return at.known[min(at.known, key=lambda length: abs(at(length) - second))]


class _Line:
    """Points of a curve by their distance ahead of the last one `reached`, along its direction; some are known from the start.
    Calling it gives the second parameter."""

    def __init__(self, plane: Plane, reached: CurveState, tolerance: float, others: tuple[OnCurve, ...]) -> None:
        self._across = partial(_across, plane, reached, tolerance=tolerance)
        own = plane.at(reached.last.parameters)
        ahead = [((plane.at(other.parameters) - own) / complex(*reached.direction)).real for other in others]
        self.known = {0.0: reached.last, **dict(zip(ahead, others, strict=True))}

    def __call__(self, length: float) -> float:
        """The second parameter at this distance."""
        if length not in self.known:
            self.known[length] = self._across(length)
        return self.known[length].parameters[1]


def _cusp_after(plane: Plane, reached: CurveState) -> CurveState | None:
    """The cusp right after the last point of a curve of folds, of kind CP, with the other fold that meets it there as the point
    `before`; None if none is near.

    Near it, on a line at the distance x across the curve, the slope of the parameter over the branch's arclength s is
    g = c (x - x_c) + k s^2: its extremum m(x) passes zero at the cusp, and is regular there as the folds are not."""
    direction, start = complex(*reached.direction), plane.at(reached.last.parameters)
    line = direction / 1j
    fold = reached.last.special
    flow = fold.point.closed.flow

    def family(x: float) -> FlowFamily:
        return FlowFamily(flow, lambda along: plane.scene_at(*plane.values(start + x * direction + along * line)))

    def flattest(x: float, known: OrbitPoint) -> tuple[OrbitPoint, float, float]:
        """The point of the branch at `x`, next to `known`, at which its slope is extremal; the slope, and its curvature."""
        point = point_near(family(x), known.unknowns, known.tangent, METRIC, known)
        for _ in range(_CENTRINGS):
            low, high = (
                point_near(family(x), point.unknowns + h * point.tangent, point.tangent, METRIC, point) for h in (-_APART, _APART)
            )
            ends = low.tangent[-1], high.tangent[-1]
            bend, rise = (ends[0] + ends[1] - 2.0 * point.tangent[-1]) / _APART**2, (ends[1] - ends[0]) / (2.0 * _APART)
            shift = -rise / bend
            if not abs(shift) < _MEET:
                raise NumericsError("no other fold is near")
            if abs(shift) < _CENTRED * _APART:
                return point, float(point.tangent[-1] - 0.5 * rise**2 / bend), float(bend)
            point = point_near(family(x), point.unknowns + shift * point.tangent, point.tangent, METRIC, point)
        raise NumericsError("no slope of the branch is extremal near")

    try:
        first = point_near(family(0.0), np.append(fold.point.unknowns[:-1], 0.0), fold.point.tangent, METRIC)
        middle, slope, bend = flattest(0.0, first)
        if slope * np.sign(bend) > _ROUNDED:  # else rounding errors have put the last fold behind the cusp
            return None
        apart = middle.unknowns - first.unknowns  # nearly as far on the other side
        other = point_near(family(0.0), middle.unknowns + apart, apart, METRIC, middle)
        x, step, before, known = 0.0, _BEYOND_FOLD, slope, middle
        for _ in range(_SECANTS):
            x += step
            known, slope, _ = flattest(x, known)
            step, before = -step * slope / (slope - before), slope
            if abs(step) < _CUSP:
                break
        else:
            return None
    except NumericsError:
        return None
    outside = fold.unstable_before + fold.unstable_after - middle.unstable
    special = Special("CP", known, _CUSP, outside, outside, complex(1.0))
    at = OnCurve(plane.values(start + x * direction + known.parameter * line), special)
    partner = OnCurve(plane.values(start + other.parameter * line), replace(fold, point=other))
    return CurveState(partner, at, reached.direction, reached.length)
