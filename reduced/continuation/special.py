"""Special points of a branch: folds (LP), period doublings (PD) and torus points (NS), bracketed between points of the branch.

    LP  the branch turns: its tangent has no component along the parameter, and a real multiplier passes through 1
    PD  a real multiplier passes through -1
    NS  a complex pair passes through the unit circle

The number of unstable multipliers changes by 1, 1 and 2. An interval in which its change is not explained by the points found is
refused. Where multipliers cannot be counted (`Flow.undecided`), only folds are located.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reduced.continuation.point import Metric, OrbitPoint, point_near
from reduced.impedance.transmission_line import Complex
from reduced.orbit.closing import CLOSES_TO, FlowAt
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array

_BRACKET = 1e-9  # half of a bracket's length in the branch's metric
_MOST_WIDENINGS = 10
_CLOSE = 0.01  # of half a bracket, to which the point is located
_REAL = 1e-9  # imaginary part below which a multiplier is real
_WATCHED = 4  # moduli
_NARROWEST = 2e-4  # interval, in the branch's metric, that is not searched for a pair of points of one kind


@dataclass(frozen=True)
class Special:
    """A special point of `kind` LP, PD or NS, as the `point` found nearest to it; `bracket`, the width in the parameter of the
    interval that contains it, at least the accuracy to which orbits close; numbers of unstable multipliers before and after, and
    the `multiplier` that passes."""

    kind: str
    point: OrbitPoint
    bracket: float
    unstable_before: int
    unstable_after: int
    multiplier: complex


def specials_between(
    flow_at: FlowAt, left: OrbitPoint, right: OrbitPoint, metric: Metric, trend: Array | None = None
) -> tuple[Special, ...]:
    """The special points between two neighbours of a branch, in order. `trend`, up to `left`, reveals a pair of points that the
    counts miss. Raises NumericsError if they do not explain the change of the number of unstable multipliers."""

    def halves(middle: OrbitPoint) -> tuple[Special, ...]:
        beyond = trend_of(left, middle, metric.length(middle.unknowns - left.unknowns))
        return specials_between(flow_at, left, middle, metric, trend) + specials_between(flow_at, middle, right, metric, beyond)

    if not _differ(left, right):
        crosses = _may_cross(left, right, metric, trend)
        if not crosses and not _may_turn(left, right, metric):
            return ()
        middle = _middle(flow_at, left, right, metric)
        return halves(middle) if crosses or _differ(left, middle) else ()
    tests = [kind for kind, test in _TESTS.items() if test(left, right)]
    change = abs(left.unstable - right.unstable)
    if len(tests) == 1 and (left.closed.flow.undecided or change == _CHANGES[tests[0]]):
        return (_locate(flow_at, left, right, metric, tests[0]),)
    if metric.length(right.unknowns - left.unknowns) < 1e-7:
        changes = f"changes from {left.unstable} to {right.unstable} near parameter = {left.parameter:.10g}"
        raise NumericsError(f"the number of unstable multipliers {changes}, and no single special point explains it")
    return halves(_middle(flow_at, left, right, metric))


def trend_of(left: OrbitPoint, right: OrbitPoint, length: float) -> Array:
    """Slopes along the branch of the largest moduli of multipliers that may cross the unit circle elsewhere than at 1."""
    return (_moduli(right) - _moduli(left)) / length


def _real(point: OrbitPoint) -> Array:
    """The real multipliers."""
    return point.multipliers[np.abs(point.multipliers.imag) < _REAL].real


def _above(values: Complex) -> Complex:
    """The value above the real axis of each complex pair."""
    return values[values.imag >= _REAL]


def _moduli(point: OrbitPoint) -> Array:
    """The largest moduli of complex pairs and of real multipliers below zero, in order."""
    real = _real(point)
    turning = np.abs(np.concatenate([_above(point.multipliers), real[real < 0.0]]))
    return np.append(np.sort(turning)[::-1], np.zeros(_WATCHED))[:_WATCHED]


def _may_cross(left: OrbitPoint, right: OrbitPoint, metric: Metric, trend: Array | None) -> bool:
    """Whether a modulus extrapolated by its trend passes 1 before `right` although it lies on the same side of 1 there as at
    `left`: it may have passed and returned. A modulus that turns stays below its extrapolation."""
    length = metric.length(right.unknowns - left.unknowns)
    if trend is None or length < _NARROWEST:
        return False
    begin = _moduli(left)
    return bool(((begin - 1.0) * (begin + length * trend - 1.0) < 0.0).any())


def _differ(left: OrbitPoint, right: OrbitPoint) -> bool:
    return left.unstable != right.unstable or _turns(left, right)


def _may_turn(left: OrbitPoint, right: OrbitPoint, metric: Metric) -> bool:
    """Whether the cubic with the parameters and slopes of both ends turns between them though both slopes have one sign: then
    two folds lie there, or the chord is nearly vertical."""
    change = right.parameter - left.parameter
    length = metric.length(right.unknowns - left.unknowns)
    first, last = left.tangent[-1] * length, right.tangent[-1] * length
    middle = 1.5 * change - 0.25 * (first + last)  # slope halfway
    return bool(first * middle < 0.0 or first * change < 0.0)


def _turns(left: OrbitPoint, right: OrbitPoint) -> bool:
    return bool(left.tangent[-1] * right.tangent[-1] < 0.0)


def _pairs_outside(point: OrbitPoint) -> int:
    return int((np.abs(_above(point.multipliers)) > 1.0).sum())


_TESTS: dict[str, Callable[[OrbitPoint, OrbitPoint], bool]] = {
    "LP": _turns,
    "PD": lambda left, right: bool((_real(left) < -1.0).sum() != (_real(right) < -1.0).sum()),
    "NS": lambda left, right: _pairs_outside(left) != _pairs_outside(right),
}
_CHANGES = {"LP": 1, "PD": 1, "NS": 2}  # of the number of unstable multipliers


def _middle(flow_at: FlowAt, left: OrbitPoint, right: OrbitPoint, metric: Metric, share: float = 0.5) -> OrbitPoint:
    """The point of the branch between two others, at `share` of the chord, found by Newton's method from the cubic through
    both."""
    chord = right.unknowns - left.unknowns
    rest, length = 1.0 - share, metric.length(chord)
    bend = rest * (length * left.tangent - chord) - share * (length * right.tangent - chord)
    guess = left.unknowns + share * chord + share * rest * bend
    return point_near(flow_at, guess, chord / length, metric, left if share < 0.5 else right)


def _locate(flow_at: FlowAt, left: OrbitPoint, right: OrbitPoint, metric: Metric, kind: str) -> Special:
    """The special point of `kind` between two points: the zero of its test function, bracketed by two close points."""
    length = metric.length(right.unknowns - left.unknowns)
    points = {0.0: left, 1.0: right}

    def point(share: float) -> OrbitPoint:
        """The point at `share` of the chord, from the nearest two known points."""
        if share not in points:
            low, high = max(point for point in points if point < share), min(point for point in points if point > share)
            within = (share - low) / (high - low)
            points[share] = _middle(flow_at, points[low], points[high], metric, within)
        return points[share]

    gap = _BRACKET / length
    at = _zero(lambda share: _value(kind, point(share)), lambda share: _TESTS[kind](left, point(share)), _CLOSE * gap)
    for _ in range(_MOST_WIDENINGS):
        before, after = point(max(0.0, at - gap)), point(min(1.0, at + gap))
        if _TESTS[kind](before, after):
            width = max(abs(after.parameter - before.parameter), CLOSES_TO * metric.scale(point(at).parameter))
            passing = complex(critical(kind, point(at).multipliers))
            return Special(kind, point(at), width, left.unstable, right.unstable, passing)
        gap *= 4.0
    raise NumericsError(f"a point of kind {kind} near parameter = {left.parameter:.10g} cannot be located")


def _zero(value: Callable[[float], float], is_beyond: Callable[[float], bool], within: float) -> float:
    """The share at which `value` changes sign or, if it has one sign at both ends, from which on `is_beyond` holds."""
    from scipy.optimize import brentq

    low, high = 0.0, 1.0
    while high - low > within:
        if value(low) * value(high) < 0.0:
            return float(brentq(value, low, high, xtol=within))
        middle = 0.5 * (low + high)
        low, high = (low, middle) if is_beyond(middle) else (middle, high)
    return 0.5 * (low + high)


def _value(kind: str, point: OrbitPoint) -> float:
    """The test function of `kind`; its sign changes at the special point."""
    if kind == "LP":
        return float(point.tangent[-1])
    passing = critical(kind, point.multipliers)
    return float(-1.0 - passing.real) if kind == "PD" else float(abs(passing) - 1.0)


def critical(kind: str, values: Complex) -> complex:
    """The multiplier, of `values` (m,) near a special point of `kind`, that crosses there; of a pair the one above the real
    axis."""
    if kind == "LP":
        return complex(values[np.abs(values - 1.0).argmin()]) if values.size else complex(1.0)
    if kind == "PD":
        real = values[np.abs(values.imag) < _REAL]
        return complex(real[np.abs(real + 1.0).argmin()]) if real.size else complex(-np.inf)
    pairs = _above(values)
    return complex(pairs[np.abs(np.abs(pairs) - 1.0).argmin()]) if pairs.size else complex(0.0)
