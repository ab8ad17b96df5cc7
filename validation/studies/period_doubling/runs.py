"""The ODE's orbit of T = 79.09, the doubled orbit beside it, and the branches of both as far as the period doublings."""

from functools import cache
from typing import NamedTuple

import numpy as np

from reduced.continuation.branch import Control, follow_branch
from reduced.continuation.doubling import difference_of_halves
from reduced.continuation.mesh import Family
from reduced.continuation.point import Point
from reduced.continuation.special import Special
from reduced.continuation.start import from_orbit, metric_for
from reduced.orbit import PeriodicOrbit, periodic_orbit
from reduced.orbit.approach import approach
from reduced.orbit.closing import close
from reduced.orbit.multipliers import floquet
from validation.branches.follow import Head, Limits, begin, follow
from validation.branches.parameter import over_range
from validation.branches.record import Branch
from validation.measure.cycle import watch
from validation.registry.orbits import moving
from validation.study.over_r import RANGE, scene_at

MODEL = "kelvin-voigt"
AT = -2.590007
"""log10 r at which AUTO-07p finds the orbit of T = 79.09."""

TOLERANCE = 1e-9
"""Relative error of the figures of both orbits."""

_MARCHED = 6000.0
_BEYOND = (-2.597, -2.578)  # log10 r just outside the pair of period doublings
NEAR = 0.997
"""Multiplier of doubled orbits above which their branch is taken to its end by a straight line."""

_STEPS = Control(longest=0.02)
_ROUGH = 1e-5  # of the other bubbles


class Doubled(NamedTuple):
    """The `single` and the `double` orbit at `AT`; the periods of the last two cycles of the run that settled on the latter
    (transits); and, by increasing r, points of both branches, with the special points (of the single one) among them."""

    single: PeriodicOrbit
    double: PeriodicOrbit
    last_two: float
    primary: list[Point]
    special: list[Special]
    bubble: list[Point]


@cache
def doubled() -> Doubled:
    """Both orbits by Newton's method from a run, and their branches in both directions."""
    model = moving(MODEL, scene_at(AT), TOLERANCE)
    single = periodic_orbit(*approach(model.solver, model.freeze)[:3], TOLERANCE)
    settled = moving(MODEL, scene_at(AT), TOLERANCE)
    twice = float(watch(settled.solver, _MARCHED).events().period[-2:].sum())
    double = periodic_orbit(*settled.freeze(settled.solver, twice), twice, TOLERANCE)
    primary, special = _both_ways(single, 1e9)
    bubble, _ = _both_ways(double, NEAR)
    return Doubled(single, double, twice, primary, special, bubble)


def end(near: Point, nearest: Point) -> float:
    """log10 r at which the largest multiplier of doubled orbits reaches 1, by the line through two points of their branch."""
    first, last = (float(point.multipliers[0].real) for point in (near, nearest))
    return nearest.parameter + (1.0 - last) * (nearest.parameter - near.parameter) / (last - first)


def _both_ways(orbit: PeriodicOrbit, largest: float) -> tuple[list[Point], list[Special]]:
    """The branch through `orbit` by increasing r, until it leaves the range or a multiplier exceeds `largest`."""
    metric, flow = metric_for(*RANGE), orbit.closed.flow
    family = Family(flow, scene_at)

    def inside(point: Point) -> bool:
        """Whether the branch is followed on from here."""
        return _BEYOND[0] < point.parameter < _BEYOND[1] and float(np.abs(point.multipliers[0])) < largest

    begin = from_orbit(family, orbit.closed, AT, _BEYOND[1], metric)
    ways = [
        list(follow_branch(family, start, metric, inside, 10.0 * TOLERANCE, _STEPS))
        for start in (from_orbit(family, orbit.closed, AT, _BEYOND[0], metric), begin)
    ]
    down, up = ([point for step in way for point in (*(one.point for one in step.special), step.point)] for way in ways)
    return [*down[::-1], begin, *up], [one for way in ways for step in way for one in step.special]


class Bubble(NamedTuple):
    """A branch of doubled orbits from the period doubling at log10 r = `born` to where its two halves become the same, `ends`;
    there the simple orbit, half of it, has the `multiplier`; (log10 r, half of the period) of its `points`; its special points,
    as (kind, log10 r)."""

    born: float
    ends: float
    multiplier: float
    points: list[tuple[float, float]]
    special: list[tuple[str, float]]


def bubble(low: float, high: float) -> Bubble:
    """The doubled orbits from the first period doubling between these log10 r on, at first towards the higher one."""
    found = Branch(over_range(f"log10_r={low}:{high}", scene_at(AT)), MODEL, _ROUGH, doubled=True)
    points = [begin(found).point]
    points += [head.point for head in follow(found, Head(points[0], Control.first, metric_for(low, high)), Limits())]
    (before, far), (last, near) = ((point.parameter, difference_of_halves(point) ** 2) for point in points[-2:])
    ends = last + near * (last - before) / (far - near)  # the square of the difference vanishes linearly
    halves = [(one.value, 0.5 * one.period) for one in found.points]
    born, *special = ((one.kind, one.value) for one in found.special)
    return Bubble(born[1], ends, _multiplier_of_half(points[-1], ends), halves, special)


def _multiplier_of_half(point: Point, log10_r: float) -> float:
    """The multiplier nearest to -1 of the simple orbit at `log10_r`, whose motion is about that of half of a doubled one."""
    flow, start, period = point.closed.flow, point.closed.cycle.start, 0.5 * point.closed.cycle.period
    flow, state = flow.remeshed(flow.march(start, period), 1.0)
    values = floquet(close(flow.of(scene_at(log10_r)), state, period).monodromy)[0]
    return float(values[np.abs(values + 1.0).argmin()].real)
