"""Special points of branches followed in two parameters: curves of folds, period doublings and torus points.

A curve is stepped along in the plane of both parameters. Across its predicted place a line is laid; along this line, the orbits
are a branch in one parameter, on which the special point is located as on any other (`special`), between two orbits on both
sides. So a curve may turn back in either parameter, every point has its bracket and its index, and none rests on an extended
system that a neighbouring special point may attract.
"""

import cmath
from collections.abc import Callable, Iterator
from dataclasses import dataclass
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

_REACHES = (2e-4, 1e-3, 4e-3, 0.016)  # of the search on both sides, in the metric; a short one tells two near points apart
_GROWTH = 1.5


@dataclass(frozen=True)
class Plane:
    """The `scene_at` values of both parameters, and the `scale` of each: lengths in the plane are relative to these. There a
    place, a step or a direction is a complex number."""

    scene_at: Callable[[float, float], Scene]
    scale: Values

    def values(self, at: complex) -> Values:
        """Both parameters there."""
        return at.real * self.scale[0], at.imag * self.scale[1]

    def at(self, values: Values) -> complex:
        """The inverse of `values`."""
        return complex(values[0] / self.scale[0], values[1] / self.scale[1])


class OnCurve(NamedTuple):
    """A `special` point at a `place`; its own parameter is the distance along the line on which it was located."""

    place: Values
    special: Special


class Reached(NamedTuple):
    """Where a curve can go on: its last two points, at its beginning twice the first; the direction of the step between them, at
    the beginning that of the next one; and the length of the next step."""

    before: OnCurve
    last: OnCurve
    direction: Values
    length: float


CURVE_STEPS = Control(2e-3, 1e-5, 0.05)
"""Lengths of steps in the plane, in units of its scales."""


def beginning(start: OnCurve, towards: Values, steps: Control = CURVE_STEPS) -> Reached:
    """The beginning of a curve at `start`, which was found on a branch in the first parameter, at first in the direction
    `towards`."""
    return Reached(start, start, towards, steps.first)


def follow_curve(plane: Plane, reached: Reached, tolerance: float, steps: Control = CURVE_STEPS) -> Iterator[Reached]:
    """The curve point after point beyond what is `reached`, without end; on meshes that keep relative errors of the figures below
    `tolerance`.

    Raises NumericsError where the curve cannot be followed; what came before has been yielded.
    """
    while True:
        new = _next(plane, reached, tolerance, steps.shortest)
        step = plane.at(new.place) - plane.at(reached.last.place)
        used = abs(step)
        reached = Reached(reached.last, new, (step.real / used, step.imag / used), min(steps.longest, _GROWTH * used))
        yield reached


def _next(plane: Plane, reached: Reached, tolerance: float, shortest: float) -> OnCurve:
    before, last, direction, length = reached

    def step(length: float) -> OnCurve:
        new = _across(plane, reached, length, tolerance)
        turn = (plane.at(new.place) - plane.at(last.place)) / complex(*direction)
        if before is not last and not abs(cmath.phase(turn)) < LARGEST_TURN:
            raise NumericsError(TURNS)
        return new

    try:
        return longest(step, length, shortest)
    except NumericsError as reason:
        at = ", ".join(f"{value:.8g}" for value in last.place)
        raise NumericsError(f"the curve cannot be followed beyond the parameters {at}: {reason}") from None


def _across(plane: Plane, reached: Reached, length: float, tolerance: float) -> OnCurve:
    """The special point on the line across the curve's predicted place, at this `length` from the last one."""
    _, last, direction, _ = reached
    centre, line = plane.at(last.place) + length * complex(*direction), complex(*direction) / 1j
    known = last.special.point
    family = FlowFamily(known.closed.flow, lambda along: plane.scene_at(*plane.values(centre + along * line)))
    point = point_near(family, _predicted(plane, reached, centre), known.tangent, METRIC)
    special = _nearest(family, point, last.special.kind)
    if special.point.roughness(tolerance) > 1.0:
        family, point = on_finer_mesh(family, special.point, METRIC, tolerance)
        special = _nearest(family, point, last.special.kind)
    return OnCurve(plane.values(centre + special.point.parameter * line), special)


def _predicted(plane: Plane, reached: Reached, centre: complex) -> Array:
    """Unknowns at the centre of a line: those of the last point, in the same deviation from steady sliding, and continued along
    the secant if both points have one mesh."""
    before, last = reached.before, reached.last
    guess, earlier = _deviation(last), _deviation(before)
    if before is not last and earlier.size == guess.size:
        share = abs(centre - plane.at(last.place)) / abs(plane.at(last.place) - plane.at(before.place))
        guess = guess + share * (guess - earlier)
    steady = last.special.point.closed.flow.of(plane.scene_at(*plane.values(centre))).steady
    return np.concatenate([guess[:-2] + steady, [guess[-2], 0.0]])


def _deviation(known: OnCurve) -> Array:
    """Unknowns, less the state of steady sliding."""
    point = known.special.point
    return np.asarray(point.unknowns - np.append(point.closed.flow.steady, [0.0, 0.0]))


def _nearest(family: FlowFamily, point: OrbitPoint, kind: str) -> Special:
    """The special point of `kind` on the branch through `point` that is nearest to it."""
    for reach in _REACHES:
        left, right = (
            point_near(family, point.unknowns + shift * point.tangent, point.tangent, METRIC, point) for shift in (-reach, reach)
        )
        found = [one for one in specials_between(family, left, right, METRIC) if one.kind == kind]
        if found:
            return min(found, key=lambda one: METRIC.length(one.point.unknowns - point.unknowns))
    raise NumericsError(f"no {kind} was found beside an orbit of period {point.closed.cycle.period:.6g}")
