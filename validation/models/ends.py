"""Where the special points of a branch end as a second parameter changes: those left at each of its values, and its extreme on
the curves through the points at the first one."""

from collections.abc import Mapping
from typing import NamedTuple, Self

import numpy as np

from reduced.continuation.curve import CurveState, crossing, turn
from reduced.stability.onsets import Onset, onsets
from slipwave.errors import NumericsError, SceneError
from slipwave.input.assemble import SceneSource
from slipwave.input.wording import shorten
from validation.models.branch import FollowedBranch
from validation.models.by_name import one_port_of
from validation.models.curve import Curve
from validation.models.followed import ends_of
from validation.models.parameter import ParameterRange, Variation, over_ranges
from validation.models.points import SPECIAL_KINDS, StopAt

_CURVE = StopAt(points=400)
_SAME = 1e-5  # of the range: distance of two points of a branch that are one
_TURN = 1e-4  # relative accuracy of the place at which a curve of Hopf points turns


class CurveEnd(NamedTuple):
    """A curve through special points: their names on the branch at the first value; the extreme of the second parameter, and the
    first one and the period (transits) there, or None for the `reason`; `bracket`, the width that contains the extreme."""

    points: tuple[str, ...]
    extreme: float | None = None
    first: float | None = None
    period: float | None = None
    bracket: float | None = None
    reason: str = ""


class SpecialEnds:
    """The `branches` of one scene at `values` of the parameter `second`; `curves`: kind -> the curves of it through all points of
    the first branch."""

    def __init__(self, second: ParameterRange, values: tuple[float, ...]) -> None:
        self.second, self.values = second, values
        self.branches: list[FollowedBranch] = []
        self.curves: dict[str, list[CurveEnd]] = {}

    @classmethod
    def read(cls, text: str, over: str, source: "SceneSource | Variation") -> tuple[ParameterRange, Self]:
        """The parameter of `--over` at the first value of `--ends KEY=VALUE,VALUE,...`, and the latter, for a scene, or scenes
        with variables. Raises SceneError for another form."""
        key, equals, values = text.partition("=")
        words = [word.strip() for word in values.split(",")]
        if not equals or not key.strip() or len(words) < 2:
            raise SceneError(
                f"--ends {shorten(text)}: must be KEY=VALUE,VALUE,... of two values or more, as in face.coefficient=1,0.99"
            )
        pairs = [over_ranges({"--over": over, "--ends": f"{key}={words[0]}:{word}"}, source) for word in words[1:]]
        seconds = [pairs[0][1].first, *(second.last for _, second in pairs)]
        if not all(np.diff(seconds) > 0.0) and not all(np.diff(seconds) < 0.0):
            raise SceneError(f"--ends {shorten(text)}: values must rise or fall throughout")
        first, second = pairs[-1]
        if first.quantity == second.quantity:
            raise SceneError(f"--ends {shorten(text)}: must be another parameter than --over")
        return first.beside(second, seconds[0]), cls(second, tuple(seconds))

    def extreme(self, kind: str) -> CurveEnd:
        """Of all curves of the kind, that which leads farthest; without an extreme if one of them has none."""
        curves = self.curves[kind]
        none = [end for end in curves if end.extreme is None]
        if none:
            return none[0]._replace(reason="; ".join(f"{', '.join(end.points)}: {end.reason}" for end in none))
        return max(curves, key=lambda end: self._progress(end.extreme or 0.0))

    def follow(self, own: FollowedBranch, limits: StopAt) -> None:
        """Fill it, with the branch `own` at the first value, which was followed before."""
        self.branches.append(own)
        for value in self.values[1:]:
            self.branches.append(self._branch(own, value, limits))
        names = own.named()
        for kind in SPECIAL_KINDS:
            left = {name: index for name, index in names.items() if own.special[index].kind == kind}
            while left:
                self.curves.setdefault(kind, []).append(self._curve(own, left))

    def _branch(self, own: FollowedBranch, value: float, limits: StopAt) -> FollowedBranch:
        branch = FollowedBranch(own.over.beside(self.second, value), own.model, own.tolerance, own.cells, own.doubled)
        try:
            for _ in ends_of(branch, limits):
                pass
        except (NumericsError, SceneError) as error:  # SceneError: no orbits in the range
            branch.notes.append(str(error))
        return branch

    def _curve(self, own: FollowedBranch, left: dict[str, int]) -> CurveEnd:
        """The curve through the first point that is `left`; takes its points out of `left`."""
        name, index = next(iter(left.items()))
        curve = Curve(own.special[index].kind, own.over, self.second, own.model, own.tolerance, (own, index))
        del left[name]
        trail, failed = list[CurveState](), ""
        try:
            trail.extend(end for end in ends_of(curve, _CURVE))
        except NumericsError as error:
            failed = str(error)
        if curve.kind == "HB" and not failed:
            return self.of_hopf(curve, name)
        points = [name]
        for crossed, end, beyond in [] if failed else curve.left:
            if (crossed, end) != (self.second.name, self.second.first):
                failed = _leaves(crossed, end)
                break
            back = crossing(curve.plane, trail[-1], beyond, end, curve.tolerance)
            other = _named_at(own, left, back.parameters[0], back.special.point.closed.cycle.period)
            points += [other] if other else []
            left.pop(other, None)
        if not failed and not curve.left and curve.points[-1].kind != "CP":
            failed = curve.notes[-1]
        if failed:
            return CurveEnd(tuple(points), reason=failed)
        best = max(range(len(curve.points)), key=lambda k: self._progress(curve.points[k].second))
        return CurveEnd(tuple(points), *self._extreme(curve, trail, best))

    def _extreme(self, curve: Curve, trail: list[CurveState], best: int) -> tuple[float, float, float, float]:
        """Second and first parameter and period at the extreme near the point `best`, and the bracket of the second."""
        top = curve.points[best]
        if top.kind == "CP":
            width = top.bracket * abs(self.second.last - self.second.first) / abs(curve.over.last - curve.over.first)
            return top.second, top.first, top.period, width
        reached, later = (trail[best - 1], trail[min(best + 1, len(trail) - 1)]) if best else (trail[0], trail[1])
        extremum, width = turn(curve.plane, reached, trail[best], later, self.second.sign, curve.tolerance)
        return extremum.parameters[1], extremum.parameters[0], extremum.special.point.closed.cycle.period, width

    def of_hopf(self, curve: Curve, name: str) -> CurveEnd:
        """The curve of Hopf points that was begun, through the point `name`."""
        from scipy.optimize import minimize_scalar

        points, progress = curve.points, [self._progress(point.second) for point in curve.points]
        best = int(np.argmax(progress))
        if best in (0, len(points) - 1):
            return CurveEnd((name,), reason=_leaves(*curve.end_near(points[best].first, points[best].second)))
        near = points[best - 1 : best + 2]
        places = [curve.plane.at((point.first, point.second)).real for point in near]
        if not (places[1] - places[0]) * (places[2] - places[1]) > 0.0:
            return CurveEnd((name,), reason="its curve turns too sharply")
        low, middle, high = (point.first for point in near)
        reach = 2.0 * max(abs(point.second - near[1].second) for point in near)
        around = near[1].second - reach, near[1].second + reach

        def onset(first: float) -> Onset:
            """The Hopf point of the curve over the second parameter at this `first` one."""
            hopf_points = onsets(lambda second: curve.plane.scene_at(first, second), *around, one_port_of(curve.model))
            return min(hopf_points, key=lambda hopf: abs(hopf.parameter - near[1].second))

        minimum = minimize_scalar(
            lambda first: -self.second.sign * onset(first).parameter, bracket=(low, middle, high), tol=_TURN
        )
        second, period, *_ = onset(first := float(minimum.x))
        return CurveEnd((name,), second, first, period, abs(second - onset(first + _TURN * (high - low)).parameter))

    def _progress(self, second: float) -> float:
        """How far from the first value towards the last."""
        return (second - self.second.first) / (self.second.last - self.second.first)


def _leaves(name: str, end: float) -> str:
    return f"the curve leaves the range at {name} = {end:g}"


def _named_at(own: FollowedBranch, left: Mapping[str, int], first: float, period: float) -> str:
    """The name of the point of the branch, of those `left`, at this value and period; empty if there is none."""
    apart, known = _SAME * abs(own.over.last - own.over.first), ((name, own.special[index]) for name, index in left.items())
    near = (name for name, point in known if abs(point.value - first) < apart and abs(point.period / period - 1.0) < _SAME)
    return next(near, "")
