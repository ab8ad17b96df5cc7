"""The ODE's unstable orbit and its doubled one (the paper's Fig 7), and the bubbles of doubled orbits between two doublings."""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np

from reduced.orbit import PeriodicOrbit, periodic_orbit
from reduced.orbit.closing import Closed
from slipwave.observe.history import values_at
from slipwave.observe.pieces import interpolation_matrix, lagrange_basis
from validation.measure import memo
from validation.measure.over_r import Branch, scene_at
from validation.models.branch import FollowedBranch
from validation.models.cycle import watch
from validation.models.followed import ends_of
from validation.models.orbits import moving
from validation.models.parameter import over_range
from validation.models.points import BranchPoint, StopAt
from validation.references.published import half_digit, reference
from validation.report import EXACT, PAPER, WITNESS, Verdict, Verdicts, claim, holding, minus
from validation.report.known import error_of

ODE = "kelvin-voigt"
AT = -2.590007
"""log10 r at which AUTO-07p finds the orbit of T = 79.09."""

TOLERANCE = 1e-9
"""Relative error of the figures of both orbits."""

_MARCHED = 6000.0
_ROUGH = 1e-6  # of the bubbles
_NEAREST = 4  # last orbits of a bubble, from which its end is extrapolated
_ENDS = 1e-3  # of a branch's last step: error of the extrapolation over it
_CLOSE = 0.1  # of v_max
_DENSE = 65  # points of a piece
_SAMPLES = 1 << 14  # of half a doubled orbit, whose fronts take a thousandth of it

PAIRS = ((-2.597, -2.578), (-2.571, -2.535), (-2.5375, -2.47))
"""log10 r on both sides of each pair of period doublings."""


class Doubled(NamedTuple):
    """The `single` and the `double` orbit at `AT`, and the periods of the last two cycles of the run that settled on the latter
    (transits)."""

    single: PeriodicOrbit
    double: PeriodicOrbit
    last_two: float


Bubble: TypeAlias = tuple[float, float, list[tuple[float, float]]]
"""A branch of doubled orbits: log10 r of the period doubling where it is born, and of where its two halves become the same;
(log10 r, half of the period) of its points."""


@cache
def doubled() -> Doubled:
    """Both orbits by Newton's method, from a run that passes the unstable orbit and settles on the doubled one."""
    settled = moving(ODE, scene_at(AT))
    twice = watch(settled, _MARCHED).events().period[-2:].sum()
    double = periodic_orbit(*settled.flow(twice, TOLERANCE), twice, TOLERANCE)
    return Doubled(memo.own_orbit(ODE, scene_at(AT), TOLERANCE), double, twice)


def bubble(low: float, high: float) -> Bubble:
    """The doubled orbits from the first period doubling between these log10 r on, at first towards the higher one. The mean
    square of the difference of their halves vanishes linearly in r."""
    branch = FollowedBranch(over_range(f"log10_r={low}:{high}", scene_at(AT)), ODE, _ROUGH, doubled=True)
    last = [end.point for end in ends_of(branch, StopAt())][-_NEAREST:]
    square = [_square_of_difference(point.closed) for point in last]
    ends = np.polyfit(square, [point.parameter for point in last], _NEAREST - 1)[-1]
    return branch.special[0].value, ends, [(point.value, 0.5 * point.period) for point in branch.points]


def _square_of_difference(double: Closed) -> float:
    """Mean square of the difference of ln v between both halves of a doubled orbit; smooth in r, as the largest difference, which
    passes from one front to another, is not."""
    basis, half = lagrange_basis(double.flow.nodes), 0.5 * double.cycle.period
    times = np.linspace(0.0, half, _SAMPLES, endpoint=False)
    first, second = (values_at(double.cycle.pieces, basis, times + shift)[0] for shift in (0.0, half))
    return float(np.mean((second - first) ** 2))


def between_doublings(ode: Branch) -> list[list[BranchPoint]]:
    """The simple orbits along the branch from the one to the other of each pair of period doublings, both included."""
    doublings, corners = {id(special.point) for special in ode.of_kind("PD")}, ode.corners
    places = [n for n, point in enumerate(ode.points) if id(point) in doublings]
    return [corners[begin : end + 1] for begin, end in zip(places[::2], places[1::2], strict=False)]


def doubling_verdicts(doubled: Doubled, ode: Branch, bubbles: Sequence[Bubble]) -> Verdicts:
    """The orbits at `AT`, then the bubbles."""
    period, double = doubled.single.orbit.period.value, doubled.double.orbit.period.value
    known, simple = reference()["paper"]["T_unstable_ode"], between_doublings(ode)
    r, periods = zip(*((corner.value, corner.period) for corner in simple[0]), strict=True)
    digit = np.ptp(np.interp([AT, AT + half_digit(AT)], r, periods))
    where = f"transits, at log_{{10}} r = {AT:.6f}, of which half the last digit is allowed"
    yield claim("The orbit of T = 79.09 lies where AUTO-07p finds it", WITNESS, period, digit, minus(where), near=known)
    remark, allowed = "two cycles over the doubled period by Newton’s method", error_of(doubled.double.orbit.period)
    yield claim("A direct run settles on the doubled orbit", WITNESS, doubled.last_two / double, allowed, remark, near=1.0)
    lead = doubled.single.multipliers.values[0].real
    holds = abs(period - known) <= half_digit(known) and doubled.single.multipliers.stable is False and lead < -1.0
    yield holding(
        "P10 At r = 10^{-2.59} the primary orbit with T = 79.09 is unstable, and a doubled orbit beside it is stable",
        PAPER,
        f"T = {known} ± {half_digit(known):g}",
        f"T = {period:.6f}",
        holds and doubled.double.multipliers.stable is True,
        minus(f"multiplier {lead:.5f} of the primary orbit; half the doubled period is {0.5 * double:.6f}"),
    ).with_margin(abs(period - known), half_digit(known))
    yield _twice_but_not_the_same(doubled)
    for (born, ends, path), points in zip(bubbles, simple, strict=True):
        yield claim(
            "P9 The doubled orbits connect two period doublings: their branch is a closed bubble",
            EXACT,
            ends,
            _ENDS * abs(path[-1][0] - path[-2][0]),
            minus(f"born at log_{{10}} r = {born:.7f}; where both halves become the same, and the next period doubling"),
            near=points[-1].value,
        )


def _twice_but_not_the_same(doubled: Doubled) -> Verdict:
    """The peaks of the slip rate on both orbits."""
    single, (high, low) = doubled.single.orbit.v_max.value, peaks(doubled.double)
    periods = doubled.double.orbit.period.value / doubled.single.orbit.period.value
    off = max(abs(high / single - 1.0), abs(low / single - 1.0), abs(0.5 * periods - 1.0))
    return holding(
        "P10 The doubled orbit is close but not identical to two traces of the unstable one: two slightly different peaks of v",
        PAPER,
        f"two different peaks within {100 * _CLOSE:.0f} % of {single:.2f} V*, in 2 T",
        f"{high:.2f} and {low:.2f} V*, in {periods:.6f} T",
        low < high and off < _CLOSE,
    ).with_margin(off, _CLOSE)


def peaks(double: PeriodicOrbit) -> tuple[float, float]:
    """The fastest rates of both events of a doubled orbit, the larger one first, from the dense polynomials."""
    pieces, period = double.closed.cycle.pieces, double.closed.cycle.period
    points = np.linspace(0.0, 1.0, _DENSE)
    rate = np.exp(pieces.z @ interpolation_matrix(lagrange_basis(double.closed.flow.nodes), points).T).ravel()
    time = (pieces.time[:, None] + pieces.length[:, None] * points).ravel()
    first = int(np.argmax(rate))
    apart = np.abs(np.mod(time - time[first] + 0.5 * period, period) - 0.5 * period)
    return rate[first], rate[apart > 0.25 * period].max()
