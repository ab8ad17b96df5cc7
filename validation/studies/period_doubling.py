"""The ODE's unstable orbit and its doubled one (the paper's Fig 7), and the bubble of doubled orbits between two doublings."""

import math
from collections.abc import Iterable, Iterator
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
from slipwave.observe.pieces import Array, interpolation_matrix, lagrange_basis
from validation.compute.branch import FollowedBranch
from validation.compute.followed import ends_of
from validation.compute.orbits import moving
from validation.compute.parameter import over_range
from validation.compute.points import StopAt
from validation.measure.cycle import watch
from validation.references.published import half_digit, reference
from validation.study import Budget, Cell, Figure, Number, Omission, StudyResult, Table, memo, stated, table
from validation.study.branch_drawing import MARKS
from validation.study.drawing import WIDTH, Drawing, canvas, line, ruled
from validation.study.known import error_of
from validation.study.over_r import RANGE, scene_at
from validation.study.text import minus, places, plain, power
from validation.study.verdict import EXACT, WITNESS, Verdict, claim, of_paper

NAME = "period-doubling"
QUESTION = "What becomes of the paper’s ODE where its orbit loses stability by period doubling?"
SCENES = ("paper",)
SECONDS = (10.0, 24.0)

MODEL = "kelvin-voigt"
AT = -2.590007
"""log10 r at which AUTO-07p finds the orbit of T = 79.09."""

TOLERANCE = 1e-9
"""Relative error of the figures of both orbits."""

_MARCHED = 6000.0
_BEYOND = (-2.597, -2.578)  # log10 r just outside the pair of period doublings
NEAR = 0.997
"""Multiplier of doubled orbits above which the end of their branch is extrapolated by a straight line."""

_STEPS = Control(longest=0.02)
_ROUGH = 1e-5  # of the other bubbles
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


class Bubble(NamedTuple):
    """A branch of doubled orbits from the period doubling at log10 r = `born` to where its two halves become the same, `ends`;
    there the simple orbit, half of it, has the `multiplier`; (log10 r, half of the period) of its `points`; its special points,
    as (kind, log10 r)."""

    born: float
    ends: float
    multiplier: float
    points: list[tuple[float, float]]
    special: list[tuple[str, float]]


_PAIRS = ((-2.571, -2.535), (-2.5375, -2.47))
"""log10 r on both sides of the other pairs of period doublings."""


def run(budget: Budget) -> StudyResult:
    """Compute both orbits, and follow both branches to the period doublings; then the other pairs."""
    found = doubled()
    budget.report(0.3)
    others = [] if budget.quick else [bubble(*ends) for ends in _PAIRS]
    return StudyResult(
        answer=_answer(found),
        figures=(Figure("planes", _CAPTION, lambda: orbits_in_planes(found, others), paper="Fig 7", carries=("P10 ",)),),
        tables=(_orbit_table(found), *([bubble_table(others)] if others else [])),
        verdicts=(*verdicts_on_doubling(found), *map(ends_simple, others)),
        notes=(_HOW,),
        numbers={
            "T": stated(found.single.orbit.period.value, found.single.orbit.period.error),
            "doubled T": stated(found.double.orbit.period.value, found.double.orbit.period.error),
            "multiplier": Number(float(found.single.multipliers.values[0].real), 1e-7),
            "doubled multiplier": Number(float(found.double.multipliers.values[0].real), 1e-6),
        },
        omissions=(_OTHERS,) if budget.quick else (),
    )


def _answer(found: Doubled) -> str:
    low, high = sorted(one.point.parameter for one in found.special)
    return (
        f"Its orbit is unstable from log_{{10}} r = {low:.7f} to {high:.7f}. A stable orbit of twice the period is born at "
        "one end and vanishes at the other."
    ).replace("-", "−")


_CAPTION = (
    f"The ODE’s orbits at log_{{10}} r = {AT:.6f}, the paper’s Fig 7: the unstable one of T = 79.09 transits (dotted) and the "
    "stable one of twice the period. Above: slip rate over time, each over its own period, as in the paper; middle: two planes; "
    "below: periods of the single orbits over r and, between the two period doublings, half the "
    "periods of the doubled ones; in the full report those of the other two pairs too."
).replace("= -", "= −")
_HOW = (
    "Both orbits come from Newton’s method on the motion over one or two cycles; it began from a run that passes the unstable "
    "orbit and settles on the doubled one. The branch of doubled orbits is followed in both directions until their largest "
    f"multiplier exceeds {NEAR:g}; a straight line takes it to 1."
)
_OTHERS = Omission("The other two pairs of period doublings.", "The quick report does not follow their doubled orbits.", ("P9 ",))

_DOUBLE = "#d55e00"
_THIN = (0, (1.5, 1.2))
_TEN = math.log(10.0)
_EVERY = 4  # nodes of a step, of which one is drawn


def _orbit_table(found: Doubled) -> Table:
    rows: list[tuple[Cell, ...]] = [
        (name, *orbit.orbit.values().values(), ", ".join(plain(float(one.real), ".5f") for one in orbit.multipliers.values[:2]))
        for name, orbit in (("single", found.single), ("doubled", found.double))
    ]
    heading = "orbit | T [transits] .9f | Δμ [σ] .10f | Δy [σ] .10f | v_{max} [V*] .4f | v_{min} [V*] .8f | multipliers"
    caption = f"Both orbits of the ODE at log_{{10}} r = {places([AT], '.6f')}; relative errors are below {power(TOLERANCE)}."
    return table("orbits", caption, heading, rows)


def bubble_table(bubbles: Iterable[Bubble]) -> Table:
    """The other bubbles, with the special points of their doubled orbits."""
    rows = [(one.born, one.ends, _r_of(one, "PD"), _r_of(one, "LP")) for one in bubbles]
    heading = "born at [log_{10} r] .9f | ends at [log_{10} r] .6f | doubles again at [log_{10} r] | turns at [log_{10} r]"
    return table("bubbles", "Branches of doubled orbits of the other two pairs of period doublings.", heading, rows)


def _r_of(bubble: Bubble, kind: str) -> str:
    return ", ".join(f"{value:.7f}" for name, value in bubble.special if name == kind).replace("-", "−") or "–"


def orbits_in_planes(found: Doubled, others: Iterable[Bubble] = ()) -> Drawing:
    """The paper's Fig 7: both orbits in two planes; below, T and half the doubled period over r."""
    figure = canvas(WIDTH, 8.4)
    grid = figure.subplot_mosaic([["rate", "rate"], ["stress", "state"], ["branch", "branch"]], height_ratios=(0.8, 1.2, 1.0))
    single = line("kelvin-voigt", linestyle=_THIN, linewidth=1.2, label="T = 79.09, unstable")
    double = line("kelvin-voigt", color=_DOUBLE, linestyle="-", linewidth=0.9, label="doubled orbit, stable")
    for orbit, look in ((found.double, double), (found.single, single)):
        time, rate, stress, state = _curves(orbit)
        grid["rate"].plot(time / time[-1], rate, **look)
        grid["stress"].plot(rate, stress, **look)
        grid["state"].plot(rate, state, **look)
    grid["rate"].set(xlabel="time over the period of each orbit", ylabel=r"$\log_{10} v$")
    grid["stress"].set(xlabel=r"$\log_{10} v$", ylabel=r"$\mu$")
    grid["state"].set(xlabel=r"$\log_{10} v$", ylabel=r"$\log_{10}\phi$")
    axes = grid["branch"]
    ends = sorted(one.point.parameter for one in found.special)
    for stable in (True, False):
        r, period = _periods(found.primary, 1.0)
        period[(r > ends[0]) & (r < ends[-1]) if stable else (r < ends[0]) | (r > ends[-1])] = np.nan
        axes.plot(r, period, color=single["color"], linestyle="-" if stable else _THIN, linewidth=1.3)
    axes.plot(*_periods(found.bubble, 0.5), color=_DOUBLE, linewidth=1.3)
    for other in others:
        axes.plot(*np.array(other.points).T, color=_DOUBLE, linewidth=1.3)
    doublings = [[one.point.parameter, one.point.closed.cycle.period] for one in found.special]
    axes.plot(*np.array(doublings).T, MARKS["PD"], color=single["color"], markerfacecolor="white", label="period doubling")
    axes.set(xlabel=r"$\log_{10} r$", ylabel="$T$, half of the doubled $T$")
    ruled(*grid.values())
    handles = [*grid["stress"].get_lines(), axes.get_lines()[-1]]
    figure.legend(handles=handles, loc="outside upper left", ncols=3, handlelength=2.6)
    return figure


def _periods(points: list[OrbitPoint], share: float) -> tuple[Array, Array]:
    """log10 r and a share of the period along a branch."""
    return np.array([point.parameter for point in points]), share * np.array([point.closed.cycle.period for point in points])


def _curves(orbit: PeriodicOrbit) -> list[Array]:
    """Time from the event's fastest moment on, log10 v, mu and log10 phi at some nodes of an orbit's steps, over one period."""
    pieces, nodes = orbit.closed.cycle.pieces, orbit.closed.flow.nodes
    time = pieces.time[:, None] + pieces.length[:, None] * nodes
    columns = [values[:, _EVERY - 1 :: _EVERY].ravel() for values in (time, pieces.z / _TEN, pieces.mu, pieces.psi / _TEN)]
    return [columns[0] - columns[0][0], *columns[1:]]


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
        """Whether the branch is followed further."""
        return _BEYOND[0] < point.parameter < _BEYOND[1] and float(np.abs(point.multipliers[0])) < largest

    begin = from_orbit(family, orbit.closed, AT, _BEYOND[1], metric)
    ways = [
        list(follow_branch(family, start, metric, inside, 10.0 * TOLERANCE, _STEPS))
        for start in (from_orbit(family, orbit.closed, AT, _BEYOND[0], metric), begin)
    ]
    down, up = ([point for step in way for point in (*(one.point for one in step.special), step.point)] for way in ways)
    return [*down[::-1], begin, *up], [one for way in ways for step in way for one in step.special]


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


def verdicts_on_doubling(found: Doubled) -> Iterator[Verdict]:
    """In the order of the page."""
    period, double = found.single.orbit.period.value, found.double.orbit.period.value
    known = reference()["paper"]["T_unstable_ode"]
    title = "The orbit of T = 79.09 lies where AUTO-07p finds it"
    digits = np.ptp(np.interp([AT, AT + half_digit(AT)], *_periods(found.primary, 1.0)))
    where = f"transits, at log_{{10}} r = {AT:.6f}, of which half the last digit is allowed"
    yield claim(title, WITNESS, period, float(digits), minus(where), near=known)
    remark = "relative difference of two cycles of a run from the doubled period by Newton’s method"
    title, allowed = "A direct run settles on the doubled orbit", error_of(found.double.orbit.period)
    yield claim(title, WITNESS, found.last_two / double, allowed, remark, near=1.0)
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
    off = max(abs(one - other) for one, other in zip(ends, doublings, strict=True)) if len(doublings) == 2 else math.nan
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
    """The end of another bubble: both halves become a simple orbit at a period doubling of its own."""
    return claim(
        "P9 The doubled orbits of the other pairs connect two period doublings: each of the three branches is a closed bubble",
        EXACT,
        bubble.multiplier,
        _PASSES,
        "distance of the simple orbit’s multiplier from −1 where the halves of the doubled one become the same, log_{10} r = "
        + minus(f"{bubble.ends:.6f}; born at {bubble.born:.7f}"),
        near=-1.0,
    )
