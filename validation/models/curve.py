"""A curve of special points of branches in two parameters, followed where it turns back too."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from reduced.continuation.curve import CurveState, OnCurve, Plane, beginning, follow_curve
from reduced.continuation.point import FlowFamily
from reduced.continuation.special import Special
from reduced.continuation.start import from_stored, stored
from reduced.stability.boundary import Boundary, boundary
from slipwave.errors import NumericsError, SceneError
from slipwave.friction.law import name_of
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import State
from slipwave.sources import source_digest
from validation.models.branch import FollowedBranch
from validation.models.by_name import one_port_of
from validation.models.own import digests
from validation.models.parameter import ParameterRange
from validation.models.points import CurvePoint, StopAt

_FORMAT = 2


@dataclass(frozen=True)
class Curve:
    """The points of `kind` of `model` in the rectangle of the ranges `over` and `second`, from the special point of this index on
    the branch `start`, if given; `left`: if it leaves the rectangle, the parameter, its end, and the first point outside."""

    what: ClassVar[str] = "curve"
    kind: str
    over: ParameterRange
    second: ParameterRange
    model: str
    tolerance: float
    start: tuple[FollowedBranch, int] | None = None
    points: list[CurvePoint] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    left: list[tuple[str, float, CurveState]] = field(default_factory=list)

    @property
    def facts(self) -> dict[str, Any]:
        """As `FollowedBranch`."""
        ends = [[axis.name, axis.first, axis.last] for axis in (self.over, self.second)]
        own = {"model": self.model, "type": self.kind, "rectangle": ends}
        own |= digests([name_of(self.over.base.law)], [self.model])
        return {"format": _FORMAT, "scene": self.over.base.digest, **own, "sources": source_digest()}

    @property
    def tables(self) -> dict[str, tuple[type[Any], list[Any]]]:
        """As `FollowedBranch`."""
        return {"point": (CurvePoint, self.points)}

    @property
    def plane(self) -> Plane:
        """Scenes over both parameters, and their scales."""
        (low, high), (least, most) = self.over.ends, self.second.ends
        return Plane(self._scene_at, (high - low, most - least))

    def begin(self) -> CurveState | None:
        """Record the first point, on the branch at the second parameter's first value, or all Hopf points, which lie on the
        boundary of stability of steady sliding, those of the curve through `start` if given. Raises NumericsError if there is
        none."""
        if self.kind == "HB":
            for line in self._boundaries():
                for end in line.vanishing:
                    at = f"{self.over.name} = {line.first[end]:.6g}, {self.second.name} = {line.second[end]:.6g}"
                    self.notes.append(
                        f"the curve ends where its period grows without bound, near {at}; a single root crosses there"
                    )
                columns = (column.tolist() for column in (line.first, line.second, line.omega, line.growing))
                for first, second, omega, others in zip(*columns, strict=True):
                    if self._holds(first, second):
                        scene = self._scene_at(first, second)
                        figures = 2.0 * math.pi / (omega * scene.transit), 0.0, 0.0, scene.velocity, scene.velocity
                        # the multiplier of the oscillation of steady sliding is 1 there
                        self.points.append(CurvePoint(first, second, *figures, 0.0, others, others + 2, 1.0, 0.0, "HB"))
            if not self.points:
                raise NumericsError(f"{self.model}: steady sliding does not lose stability in this rectangle")
            return None
        if self.start is None:
            branch = self._branch()
            special, _ = branch.first_special(branch.begin(), self.kind)
        else:
            special = self.start[0].special_at(self.start[1])
        reached = beginning(OnCurve((special.point.parameter, self.second.first), special), (0.0, self.second.sign))
        self.points.append(CurvePoint.of(reached.last, 1.0))
        return reached

    def require_start(self) -> None:
        """Raises SceneError unless the second parameter's first value is that of the branch `start`."""
        if self.start is None:
            return
        over, second = self.start[0].over, self.second
        if self.start[0].cells is not None:
            raise SceneError("--from: a full wave's branch; curves are those of a model without cells")
        if self._scene_at(over.first, second.first).digest != over.scene_at(over.first).digest:
            raise SceneError(
                f"--and {second.name}={second.first:g}:{second.last:g}: FROM must be the value that the branch of --from has"
            )

    def follow(self, end: CurveState, limits: StopAt) -> Iterator[CurveState]:
        """Record point after point, yielding the end after each, up to the number in `limits` or until the curve leaves the
        rectangle or ends at a cusp. Raises NumericsError where the curve cannot be followed."""
        steps = follow_curve(self.plane, end, self.tolerance)
        while len(self.points) < limits.points:
            if self.points[-1].kind == "CP":
                return
            further = next(steps)
            if further.last.special.kind == "CP":
                self.points.append(CurvePoint.of(further.last, self.plane.scale[0]))
                self.notes.append(self._at_cusp(end.last, further.before))
                yield end
                return
            if not self._holds(*further.last.parameters):
                name, crossed = self.end_near(*further.last.parameters)
                self.left.append((name, crossed, further))
                self.notes.append(f"the curve leaves the rectangle of both ranges at {name} = {crossed:g}")
                return
            end = further
            self.points.append(CurvePoint.of(end.last, self.plane.scale[0]))  # brackets of lines are shares of a scale
            yield end
        self.notes.append(f"stopped after {len(self.points)} points: --most-points goes further")

    def end_near(self, first: float, second: float) -> tuple[str, float]:
        """Of both parameters the one whose range the point leaves, or is nearest to leaving, and the end."""
        axis, value = max(((self.over, first), (self.second, second)), key=lambda pair: pair[0].beyond(pair[1]))
        return axis.name, axis.nearest_end(value)

    def saved(self, end: CurveState) -> dict[str, State]:
        """As `FollowedBranch`."""
        ends = {name: _saved(point, end.length) for name, point in (("before", end.before), ("last", end.last))}
        return ends | {"resume": {"direction": np.array(end.direction)}}

    def restored(self, saved: Mapping[str, State]) -> CurveState:
        """As `FollowedBranch`."""
        last, length = self._on_curve(saved["last"])
        along, across = saved["resume"]["direction"].tolist()
        before = last if len(self.points) < 2 else self._on_curve(saved["before"])[0]
        return CurveState(before, last, (along, across), length)

    @property
    def varied(self) -> dict[str, ParameterRange]:
        """As `FollowedBranch`."""
        return {"first": self.over, "second": self.second}

    def scene_of(self, row: CurvePoint) -> Scene:
        """The scene of a point."""
        return self._scene_at(row.first, row.second)

    def _scene_at(self, first: float, second: float) -> Scene:
        """The scene at both values."""
        return self.over.scenes.at((self.over, self.second), (first, second))

    def _boundaries(self) -> list[Boundary]:
        """The boundaries of stability in the rectangle; of these only the one that passes nearest to `start`, if given."""
        boundaries = boundary(self._scene_at, one_port_of(self.model), (self.over.ends, self.second.ends))
        if self.start is None or not boundaries:
            return boundaries
        own = self.plane.at((self.start[0].special[self.start[1]].value, self.second.first))
        scale = self.plane.scale
        return [min(boundaries, key=lambda line: float(np.abs(line.first / scale[0] + 1j * line.second / scale[1] - own).min()))]

    def _holds(self, first: float, second: float) -> bool:
        return self.over.holds(first) and self.second.holds(second)

    def _at_cusp(self, *folds: OnCurve) -> str:
        """Note on the two folds that meet at the cusp."""
        places = " and ".join(
            f"{self.over.name} = {fold.parameters[0]:.10g}, {self.second.name} = {fold.parameters[1]:.8g} "
            f"(period {fold.special.point.closed.cycle.period:.6g})"
            for fold in folds
        )
        return f"the curve ends at a cusp, where two folds meet and are no more; right before it they lie at {places}"

    def _branch(self) -> FollowedBranch:
        """The branch at the second parameter's first value."""
        return FollowedBranch(self.over.beside(self.second, self.second.first), self.model, self.tolerance)

    def _on_curve(self, state: State) -> tuple[OnCurve, float]:
        """The inverse of `_saved`."""
        first, second = state["place"].tolist()
        bracket, before, after, real, imaginary = state["special"].tolist()
        scene, period = self._scene_at(first, second), float(state["unknowns"][-2])
        flow = self._branch().family_at(first, period)(first)
        _, point, length = from_stored(FlowFamily(flow, lambda _: scene), state)
        special = Special(self.kind, point, bracket, round(before), round(after), complex(real, imaginary))
        return OnCurve((first, second), special), length


def _saved(point: OnCurve, length: float) -> dict[str, Array]:
    """A point of the curve, and the length of the next step, as arrays."""
    special = point.special
    numbers = (special.bracket, special.unstable_before, special.unstable_after, special.multiplier.real, special.multiplier.imag)
    return stored(special.point, length) | {"place": np.array(point.parameters), "special": np.array(numbers)}
