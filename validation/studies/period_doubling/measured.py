"""The ODE's orbit of T = 79.09, the doubled orbit beside it, and the branches of both as far as the period doublings; what they
must show: P10, the closed bubble of doubled orbits (P9), agreement with AUTO-07p and with a run."""

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np

from reduced.continuation.branch import Control, follow_branch
from reduced.continuation.point import FlowFamily, OrbitPoint
from reduced.continuation.special import Special
from reduced.continuation.start import difference_of_halves, from_orbit, metric_for
from reduced.orbit import PeriodicOrbit, periodic_orbit
from reduced.orbit.closing import close
from reduced.orbit.multipliers import floquet
from slipwave.observe.pieces import interpolation_matrix, lagrange_basis
from validation.branches.branch import FollowedBranch
from validation.branches.followed import StopAt, ends_of
from validation.branches.parameter import over_range
from validation.measure.cycle import watch
from validation.references.published import half_digit, reference
from validation.registry.orbits import moving
from validation.study import EXACT, WITNESS, Verdict, claim, memo, of_paper
from validation.study.over_r import RANGE, scene_at
from validation.study.text import minus

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
_PERIOD = 3e-5  # transits; the digits of r in the reference
_RUN = 1e-10
_PASSES = 0.03
_CLOSE = 0.1  # of v_max
_DENSE = 65  # points of a piece
_ENDS = 3e-7  # of log10 r: the straight line's


class Doubled(NamedTuple):
    """The `single` and the `double` orbit at `AT`; the periods of the last two cycles of the run that settled on the latter
    (transits); and, by increasing r, points of both branches, with the special points (of the single one) among them."""

    single: PeriodicOrbit
    double: PeriodicOrbit
    last_two: float
    primary: list[OrbitPoint]
    special: list[Special]
    bubble: list[OrbitPoint]


@cache
def doubled() -> Doubled:
    """Both orbits by Newton's method from a run, and their branches in both directions."""
    single = memo.own_orbit(MODEL, scene_at(AT), TOLERANCE)
    settled = moving(MODEL, scene_at(AT))
    twice = float(watch(settled, _MARCHED).events().period[-2:].sum())
    double = periodic_orbit(*settled.flow(twice, TOLERANCE), twice, TOLERANCE)
    primary, special = _both_ways(single, 1e9)
    bubble, _ = _both_ways(double, NEAR)
    return Doubled(single, double, twice, primary, special, bubble)


def end(near: OrbitPoint, nearest: OrbitPoint) -> float:
    """log10 r at which the largest multiplier of doubled orbits reaches 1, by the line through two points of their branch."""
    first, last = (float(point.multipliers[0].real) for point in (near, nearest))
    return nearest.parameter + (1.0 - last) * (nearest.parameter - near.parameter) / (last - first)


def _both_ways(orbit: PeriodicOrbit, largest: float) -> tuple[list[OrbitPoint], list[Special]]:
    """The branch through `orbit` by increasing r, until it leaves the range or a multiplier exceeds `largest`."""
    metric, flow = metric_for(*RANGE), orbit.closed.flow
    family = FlowFamily(flow, scene_at)

    def inside(point: OrbitPoint) -> bool:
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
    found = FollowedBranch(over_range(f"log10_r={low}:{high}", scene_at(AT)), MODEL, _ROUGH, doubled=True)
    points = [end.point for end in ends_of(found, StopAt())]
    (before, far), (last, near) = ((point.parameter, difference_of_halves(point) ** 2) for point in points[-2:])
    ends = last + near * (last - before) / (far - near)  # the square of the difference vanishes linearly
    halves = [(one.value, 0.5 * one.period) for one in found.points]
    born, *special = ((one.kind, one.value) for one in found.special)
    return Bubble(born[1], ends, _multiplier_of_half(points[-1], ends), halves, special)


def _multiplier_of_half(point: OrbitPoint, log10_r: float) -> float:
    """The multiplier nearest to -1 of the simple orbit at `log10_r`, whose motion is about that of half of a doubled one."""
    flow, start, period = point.closed.flow, point.closed.cycle.start, 0.5 * point.closed.cycle.period
    flow, state = flow.remeshed(flow.march(start, period), 1.0)
    values = floquet(close(flow.of(scene_at(log10_r)), state, period).monodromy)[0]
    return float(values[np.abs(values + 1.0).argmin()].real)


def all_verdicts(found: Doubled) -> Iterator[Verdict]:
    """In the order of the page."""
    period, double = found.single.orbit.period.value, found.double.orbit.period.value
    known = reference()["paper"]["T_unstable_ode"]
    title = "The orbit of T = 79.09 lies where AUTO-07p finds it"
    yield claim(title, WITNESS, period, _PERIOD, minus(f"transits, at log_{{10}} r = {AT:.6f}"), near=known)
    remark = "relative difference of two cycles of a run from the doubled period by Newton’s method"
    yield claim("A direct run settles on the doubled orbit", WITNESS, found.last_two / double, _RUN, remark, near=1.0)
    lead = float(found.single.multipliers.values[0].real)
    holds = abs(period - known) <= half_digit(known) and found.single.multipliers.stable is False and lead < -1.0
    yield of_paper(
        "P10 At r = 10^{-2.59} the primary orbit with T = 79.09 is unstable, and a doubled orbit beside it is stable",
        f"T = {known} ± {half_digit(known):g}",
        f"T = {period:.6f}",
        holds and found.double.multipliers.stable is True,
        minus(
            f"multiplier {lead:.5f} of the primary orbit; the doubled one has T = {double:.6f}, half of it is {0.5 * double:.6f}"
        ),
    ).with_margin(abs(period - known), half_digit(known))
    yield twice_but_not_the_same(found)
    doublings, ways = sorted(one.point.parameter for one in found.special if one.kind == "PD"), found.bubble
    ends = (end(ways[1], ways[0]), end(ways[-2], ways[-1]))
    off = max(abs(one - other) for one, other in zip(ends, doublings, strict=True)) if len(doublings) == 2 else float("nan")
    title = "P9 The doubled orbits connect the two period doublings of the pair: their branch is a closed bubble"
    remark = "log_{10} r; where the doubled orbits’ multiplier reaches 1, against where the single orbit’s passes −1"
    yield claim(title, EXACT, off, _ENDS, remark)


def twice_but_not_the_same(found: Doubled) -> Verdict:
    """The peaks of the slip rate on both orbits."""
    single, (high, low) = float(found.single.orbit.v_max.value), peaks(found.double)
    periods = found.double.orbit.period.value / found.single.orbit.period.value
    off = max(abs(high / single - 1.0), abs(low / single - 1.0), abs(0.5 * periods - 1.0))
    return of_paper(
        "P10 The doubled orbit is close but not identical to two traces of the unstable one: two slightly different peaks of v",
        f"two different peaks within {100 * _CLOSE:.0f} % of {single:.2f} V*, in 2 T",
        f"{high:.2f} and {low:.2f} V*, in {periods:.6f} T",
        low < high and off < _CLOSE,
        f"v_{{max}} of both events; the unstable orbit’s is {'above both' if single > high else 'between them or below'}",
    ).with_margin(off, _CLOSE)


def peaks(double: PeriodicOrbit) -> tuple[float, float]:
    """The fastest rates of both events of a doubled orbit, the larger one first, from the dense polynomials."""
    pieces, period = double.closed.cycle.pieces, double.closed.cycle.period
    points = np.linspace(0.0, 1.0, _DENSE)
    rate = np.exp(pieces.z @ interpolation_matrix(lagrange_basis(double.closed.flow.nodes), points).T).ravel()
    time = (pieces.time[:, None] + pieces.length[:, None] * points).ravel()
    first = int(np.argmax(rate))
    apart = np.abs(np.mod(time - time[first] + 0.5 * period, period) - 0.5 * period)
    return float(rate[first]), float(rate[apart > 0.25 * period].max())


def ends_simple(bubble: Bubble) -> Verdict:
    """The end of another bubble: the simple orbit that both halves become is at a period doubling of its own."""
    return claim(
        "P9 The doubled orbits of the other pairs connect two period doublings: each of the three branches is a closed bubble",
        EXACT,
        bubble.multiplier,
        _PASSES,
        "distance of the simple orbit’s multiplier from −1 where the halves of the doubled one become the same, log_{10} r = "
        + minus(f"{bubble.ends:.6f}; born at {bubble.born:.7f}"),
        near=-1.0,
    )
