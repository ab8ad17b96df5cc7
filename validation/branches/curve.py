"""A special point followed in two parameters: where its curve begins, and what is kept of it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import slipwave
from reduced.continuation.curve import OnCurve, Plane, Reached, beginning, follow_curve
from reduced.orbit.closing import TOLERANCE
from reduced.orbit.figures import figures_of
from reduced.parameters import PARAMETERS, with_parameter
from reduced.stability.boundary import boundary
from slipwave.errors import NumericsError, SceneError
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from validation.branches import KINDS
from validation.branches.follow import begin, first_special
from validation.branches.parameter import Over
from validation.branches.record import Branch
from validation.registry.families import one_port_of


class CurvePoint(NamedTuple):
    """A special point at the values `first` and `second` of both parameters: figures of its orbit, the width of its `bracket` in
    the first parameter, numbers of unstable multipliers on both sides, None where they cannot be counted, and the `multiplier`
    that passes (re, im)."""

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
    multiplier: tuple[float, float]


@dataclass(frozen=True)
class Curve:
    """The points of `kind` of `model` in the rectangle of the ranges `over` and `second`, as far as they are known."""

    kind: str
    over: Over
    second: Over
    model: str
    tolerance: float
    points: list[CurvePoint] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    @property
    def plane(self) -> Plane:
        """Scenes over both parameters, and their scales."""
        ends = (self.over.ends, self.second.ends)
        return Plane(self._scene_at, (ends[0][1] - ends[0][0], ends[1][1] - ends[1][0]))

    def _scene_at(self, first: float, second: float) -> Scene:
        """A key is read, and a short name is set in the scene that is read: that takes a hundredth of the time."""
        given = ((self.over, first), (self.second, second))
        keyed = {over.name: over.written(value) for over, value in given if over.name not in PARAMETERS}
        scene = slipwave.read(self.over.base, keyed) if keyed else self.over.base
        for over, value in given:
            scene = with_parameter(scene, over.name, value) if over.name in PARAMETERS else scene
        return scene

    def at_first(self) -> Over:
        """The first parameter's range where the second has the value at which the curve begins."""
        over, value = self.over, self.second.first
        return Over(self._scene_at(over.first, value), over.name, over.first, over.last, lambda one: self._scene_at(one, value))


def require_curve(kind: str, over: Over, second: Over) -> None:
    """Raises SceneError if there is no such kind, or if the parameters are the same, or, of Hopf points, which are found by both
    parameters' short names, have none."""
    if kind not in KINDS:
        raise SceneError(f"--of {shorten(kind)}: must be one of {', '.join(KINDS)}")
    for option, name in (("--over", over.name), ("--and", second.name)):
        if kind == "HB" and name not in PARAMETERS:
            raise SceneError(f"{option} {shorten(name)}: a curve of Hopf points needs one of {', '.join(PARAMETERS)}")
    if over.name == second.name:
        raise SceneError(f"--and {shorten(second.name)}: must be another parameter than --over")


def trace_onsets(curve: Curve) -> None:
    """Record the Hopf points, which are not followed: they lie on the boundary of stability of steady sliding; the multiplier of
    its oscillation is 1 there. Raises NumericsError if there are none."""
    names, port = (curve.over.name, curve.second.name), one_port_of(curve.model)
    for found in boundary(curve.over.base, port, names, (curve.over.ends, curve.second.ends)):
        for first, second, omega in zip(found.first.tolist(), found.second.tolist(), found.omega.tolist(), strict=True):
            if not (curve.over.holds(first) and curve.second.holds(second)):
                continue
            scene = curve.plane.scene_at(first, second)
            period, rate = 2.0 * math.pi / (omega * scene.transit), scene.velocity
            curve.points.append(CurvePoint(first, second, period, 0.0, 0.0, rate, rate, 0.0, 0, 2, (1.0, 0.0)))
    if not curve.points:
        raise NumericsError(f"{curve.model}: steady sliding does not lose stability in this rectangle")


def begin_curve(curve: Curve) -> Reached:
    """Record the first point of the curve, on the branch at the second parameter's first value. Raises NumericsError if there is
    none."""
    branch = Branch(curve.at_first(), curve.model, curve.tolerance)
    special, _ = first_special(branch, begin(branch), curve.kind)
    towards = (0.0, math.copysign(1.0, curve.second.last - curve.second.first))
    reached = beginning(OnCurve((special.point.parameter, curve.second.first), special), towards)
    _record(curve, reached.last)
    return reached


def trace(curve: Curve, reached: Reached, most: int) -> Iterator[Reached]:
    """Record point after point, until there are so many or the curve leaves the rectangle; yields where it can go on.

    Raises NumericsError where the curve cannot be followed."""
    steps = follow_curve(curve.plane, reached, curve.tolerance)
    while len(curve.points) < most:
        further = next(steps)
        if not (curve.over.holds(further.last.place[0]) and curve.second.holds(further.last.place[1])):
            curve.notes.append("the curve leaves the rectangle of both ranges")
            return
        _record(curve, further.last)
        yield further
    curve.notes.append(f"stopped after {len(curve.points)} points: --most-points goes further")


def _record(curve: Curve, last: OnCurve) -> None:
    """Add a point to the curve. The first was found on a branch, the others on lines, where brackets are shares of a scale."""
    curve.points.append(_point(last, curve.plane.scale[0] if curve.points else 1.0))


def _point(one: OnCurve, share: float) -> CurvePoint:
    special, passing = one.special, one.special.multiplier
    counted = not special.point.closed.flow.undecided
    return CurvePoint(
        *one.place,
        **figures_of(special.point.closed),
        bracket=max(share * special.bracket, TOLERANCE),
        unstable_before=special.unstable_before if counted else None,
        unstable_after=special.unstable_after if counted else None,
        multiplier=(passing.real, passing.imag),
    )
