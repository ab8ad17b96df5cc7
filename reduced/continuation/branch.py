"""Follows a branch of periodic orbits by pseudo-arclength: predict along the tangent, correct orthogonally to it.

A step is accepted only if the tangents at its ends differ by a small angle and the chord lies in the cone around both, so that
the corrector neither lands on a neighbouring part of the branch nor reverses the direction, and if the special points between its
ends (`special`) explain the change of the number of unstable multipliers. Otherwise the step is halved.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from reduced.continuation.point import MOST_REFINEMENTS, FlowFamily, Metric, OrbitPoint, on_finer_mesh, point_near, too_rough
from reduced.continuation.special import Special, specials_between, trend_of
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array

BRANCH_TOLERANCE = 1e-6
"""Relative error of the figures along a branch. With it the 37 special points of the paper's delay system up to T = 85 differ by
at most 4e-8 in log10 r from those with 1e-8, which take five times as long."""

LARGEST_ANGLE = 0.2
"""Radians; between tangents at the ends of a step, and between these and its chord."""

_GROWTH, _EASY = 1.4, 0.4  # a step grows by this factor if the angle is below this share of the largest
_EASY_ITERATIONS = 6
TURNS = "it turns too sharply"
_VERTICAL = 1e-7  # slope of a branch, in its metric, whose sign is that of rounding errors

Stepped = TypeVar("Stepped")


@dataclass(frozen=True)
class Control:
    """Lengths of steps in the branch's metric: the `first`, `shortest` and `longest`. Longer ones can pass a whole pair of folds
    of a delay system, which recur after about a transit of period (0.05 of this metric) without a change of any count."""

    first: float = 2e-3
    shortest: float = 1e-9
    longest: float = 0.02


@dataclass(frozen=True)
class Step:
    """A `point` of a branch with the special points between it and the one before, and the length of the `next_step`."""

    point: OrbitPoint
    special: tuple[Special, ...]
    next_step: float


def follow_branch(
    family: FlowFamily,
    first: OrbitPoint,
    metric: Metric,
    inside: Callable[[OrbitPoint], bool],
    tolerance: float = BRANCH_TOLERANCE,
    control: Control = Control(),
) -> Iterator[Step]:
    """Yield the points after `first`, in the direction of its tangent, up to the first that is not `inside`. The mesh is refined
    where it does not reach `tolerance`, the relative error of the figures. Raises NumericsError, after yielding all earlier
    points, if no step is short enough or no mesh fine enough.
    """
    point, size, refinements = first, control.first, 0
    trend: Array | None = None
    while inside(point):
        new, special, used = _longest_step(family, point, metric, size, control, trend)
        if new.roughness(tolerance) > 1.0:
            if refinements == MOST_REFINEMENTS:
                raise too_rough(new, tolerance)
            family, finer = on_finer_mesh(family, point, metric, tolerance)
            if finer.unstable != point.unstable:
                raise NumericsError(
                    f"the number of unstable multipliers at parameter = {point.parameter:.10g} depends on the mesh: "
                    f"{point.unstable} and {finer.unstable}"
                )
            point = finer
            size, refinements = used if refinements == 0 else 0.5 * used, refinements + 1
            continue
        refinements = 0
        angle = metric.angle(point.tangent, new.tangent)
        easy = angle < _EASY * LARGEST_ANGLE and new.closed.iterations <= _EASY_ITERATIONS
        size = min(control.longest, used * (_GROWTH if easy else 1.0))
        yield Step(new, special, size)
        point, trend = new, trend_of(point, new, used)


def _longest_step(
    family: FlowFamily, point: OrbitPoint, metric: Metric, size: float, control: Control, trend: Array | None
) -> tuple[OrbitPoint, tuple[Special, ...], float]:
    """(next point, special points before it, length of the step)."""

    def step(length: float) -> tuple[OrbitPoint, tuple[Special, ...], float]:
        new = point_near(family, point.unknowns + length * point.tangent, point.tangent, metric, point)
        chord = new.unknowns - point.unknowns
        pairs = ((point.tangent, new.tangent), (chord, point.tangent), (chord, new.tangent))
        if not max(metric.angle(*pair) for pair in pairs) < LARGEST_ANGLE:  # each lies in the cone around the other's tangent
            raise NumericsError(TURNS)
        return new, specials_between(family, point, new, metric, trend), length

    try:
        return longest(step, size, control.shortest)
    except NumericsError as reason:
        at = f"parameter = {point.parameter:.10g}, period {point.closed.cycle.period:.6g} transits"
        if abs(point.tangent[-1]) >= _VERTICAL * metric.parameter:
            raise NumericsError(f"the branch cannot be followed beyond {at}: {reason}") from None
        raise NumericsError(
            f"the branch is vertical at {at}: orbits of all sizes lie there within rounding errors, so that it cannot be "
            "followed any further; slipwave run at several values of the parameter shows the motion on either side"
        ) from None


def longest(step: Callable[[float], Stepped], length: float, shortest: float) -> Stepped:
    """Result of `step` for `length`, or for the first of its halves, quarters ... down to `shortest` that does not raise
    NumericsError. Raises NumericsError if all do."""
    failed = NumericsError(TURNS)
    while length >= shortest:
        try:
            return step(length)
        except NumericsError as reason:
            failed = reason
        length *= 0.5
    raise failed
