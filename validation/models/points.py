"""Records of followed orbits: points of a branch, its special points, and points of a curve in two parameters."""

from typing import Any, NamedTuple, Self

from reduced.continuation.curve import OnCurve
from reduced.continuation.point import OrbitPoint
from reduced.continuation.special import Special
from reduced.orbit.closing import CLOSES_TO
from reduced.orbit.periodic import figures_of

SPECIAL_KINDS = {"HB": "Hopf", "LP": "fold", "PD": "period doubling", "NS": "torus"}
"""Kinds of special points, and their names."""


class StopAt(NamedTuple):
    """Limits: stop beyond a `period` (transits), after a number of `points`, at the first special point of a `kind` (if
    given), and outside of the range by more than the share `outside` of it."""

    period: float = float("inf")
    points: int = 2000
    kind: str = ""
    outside: float = 0.25


class BranchPoint(NamedTuple):
    """An orbit at a `value` of the parameter: its figures (`reduced.orbit.periodic`), the number of `unstable` multipliers, None
    where they cannot be counted, and whether it is `stable`, None if multipliers do not decide; `idle`: whether both are said
    without the idle modes that the orbit has (`reduced.stability.idle`)."""

    value: float
    period: float
    stress_drop: float
    elastic_stress_drop: float
    v_max: float
    v_min: float
    unstable: int | None
    stable: bool | None
    idle: bool

    @classmethod
    def of(cls, point: OrbitPoint) -> Self:
        """The record of an orbit."""
        closed = point.closed
        unstable = None if closed.flow.undecided else point.unstable
        stable = None if unstable is None else unstable == 0
        return cls(point.parameter, **figures_of(closed), unstable=unstable, stable=stable, idle=bool(closed.flow.idle.size))


class SpecialPoint(NamedTuple):
    """A point of `kind` HB, LP, PD or NS with the figures of its orbit; `bracket`, the width in the parameter of the interval
    that contains it; numbers of unstable multipliers (HB: of growing roots of steady sliding) before and after, None where they
    cannot be counted; `place`, the number of points of the branch before it."""

    kind: str
    value: float
    period: float
    stress_drop: float
    elastic_stress_drop: float
    v_max: float
    v_min: float
    bracket: float
    unstable_before: int | None
    unstable_after: int | None
    place: int

    @classmethod
    def of(cls, special: Special, place: int) -> Self:
        """The record of a special point after `place` points of the branch."""
        return cls(special.kind, special.point.parameter, bracket=special.bracket, place=place, **_sides(special))


class CurvePoint(NamedTuple):
    """A special point at the values `first` and `second` of both parameters: figures of its orbit, the width of its `bracket` in
    the first parameter, numbers of unstable multipliers on both sides, None where they cannot be counted, the multiplier that
    crosses the unit circle, and its `kind`: that of the curve, or CP for the cusp at its end."""

    first: float
    second: float
    period: float
    stress_drop: float
    elastic_stress_drop: float
    v_max: float
    v_min: float
    bracket: float
    unstable_before: int | None
    unstable_after: int | None
    multiplier_re: float
    multiplier_im: float
    kind: str

    @classmethod
    def of(cls, point: OnCurve, share: float) -> Self:
        """The record of a point of a curve; `share`: unit of its bracket in the first parameter."""
        special, (first, second) = point.special, point.parameters
        passing, bracket = special.multiplier, max(share * special.bracket, CLOSES_TO * abs(first))
        sides = _sides(special) | {"multiplier_re": passing.real, "multiplier_im": passing.imag}
        return cls(first=first, second=second, bracket=bracket, kind=special.kind, **sides)

    @property
    def multiplier(self) -> tuple[float, float]:
        """Its real and imaginary part."""
        return self.multiplier_re, self.multiplier_im


def _sides(special: Special) -> dict[str, Any]:
    """Figures of its orbit, and the numbers of unstable multipliers on both sides."""
    uncounted = special.point.closed.flow.undecided
    counts = {"unstable_before": special.unstable_before, "unstable_after": special.unstable_after}
    return figures_of(special.point.closed) | {name: None if uncounted else count for name, count in counts.items()}
