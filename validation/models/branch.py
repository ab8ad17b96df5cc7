"""A branch of periodic orbits, from a Hopf point or from an orbit that a run leads to, followed through folds."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from reduced.continuation.branch import Control, Step, follow_branch
from reduced.continuation.point import FlowFamily, Metric, OrbitPoint
from reduced.continuation.special import Special, critical
from reduced.continuation.start import (
    from_doubling,
    from_hopf,
    from_orbit,
    from_outline,
    from_stored,
    mesh_of,
    metric_for,
    stored,
    without_derivatives,
)
from reduced.orbit.approach import Guess
from reduced.orbit.closing import Closed, closed_between
from reduced.orbit.periodic import amplitude, difference_of_parts
from reduced.stability.characteristic import characteristic
from reduced.stability.onsets import ONSET_WIDTH, Onset, onsets
from reduced.stability.spectrum import unstable_count
from slipwave.errors import NumericsError, SceneError
from slipwave.friction.law import name_of
from slipwave.scene import Scene
from slipwave.solve import State
from slipwave.sources import source_digest
from validation.models.by_name import GRIDS, family_of, one_port_of
from validation.models.orbits import find_orbit, moving
from validation.models.own import digests
from validation.models.parameter import ParameterRange
from validation.models.points import SPECIAL_KINDS, BranchPoint, SpecialPoint, StopAt

_FORMAT = 4
_OUTLINE = "special_"  # before the index of a special point
_SMALL = 0.1  # amplitude of ln v
_BESIDE = 1e-6  # of the range, from its end: the first orbit, if states at the end itself have another size
_AT_END = 1e-6  # of the range, from its end: a branch that cannot be followed there ends at it
_SAME = 0.03  # difference of ln v and psi between two halves

_UNDECIDED = (
    "stability is not decided where the essential radius is 1: some motion of the slabs is never damped by friction there, and "
    "multipliers cannot tell; they accumulate at the unit circle and are not counted, so of the special points only HB and LP "
    "are found"
)
_WITHOUT_IDLE = (
    "stability, numbers of unstable multipliers, and PD and NS found by them, are said without idle modes, in which both slabs "
    "swing alike without slip or stress at the interface, and which friction never damps: slipwave orbit names them"
)


class _BranchEnd(NamedTuple):
    """The last `point` of a branch and the length of the next `step`, from which it continues."""

    point: OrbitPoint
    step: float
    metric: Metric


@dataclass(frozen=True)
class FollowedBranch:
    """The branch of `model` over a parameter, to the relative error `tolerance` of all figures. `cells` is for full waves.
    `closed`: index of a special point -> its orbit, if computed in this process; `outlines`: what it can be computed again from;
    `starts`: index of a point -> the same, if computed in this process.
    `doubled`: the branch of orbits of twice the period from the first period doubling of the scene's own branch."""

    what: ClassVar[str] = "branch"
    over: ParameterRange
    model: str
    tolerance: float
    cells: int | None = None
    doubled: bool = False
    points: list[BranchPoint] = field(default_factory=list)
    special: list[SpecialPoint] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    closed: dict[int, Closed] = field(default_factory=dict)
    outlines: dict[int, State] = field(default_factory=dict)
    starts: dict[int, State] = field(default_factory=dict)

    @property
    def varied(self) -> dict[str, ParameterRange]:
        """Column of the file -> the parameter whose values it holds."""
        return {"value": self.over}

    @property
    def shown(self) -> list[BranchPoint]:
        """The points within the range; others lie where the branch was followed outside (`StopAt.outside`)."""
        return [point for point in self.points if self.over.holds(point.value)]

    @property
    def shown_special(self) -> list[SpecialPoint]:
        """The special points within the range."""
        return [special for special in self.special if self.over.holds(special.value)]

    @property
    def facts(self) -> dict[str, Any]:
        """Facts in which a file and a branch that continues it must agree; tolerance and range may differ."""
        own = {"model": self.model, "cells": self.cells, "doubled": self.doubled, "parameter": self.over.name}
        own |= digests([name_of(self.over.base.law)], [self.model])
        scenes = {"fixed": {**self.over.scenes.fixed}, **self.over.scenes.facts}
        return {"format": _FORMAT, "scene": self.over.base.digest, **own, **scenes, "sources": source_digest()}

    @property
    def tables(self) -> dict[str, tuple[type[Any], list[Any]]]:
        """Dimension of the file -> class of its rows, and the rows."""
        return {"point": (BranchPoint, self.points), "special": (SpecialPoint, self.special)}

    def scene_of(self, row: BranchPoint | SpecialPoint) -> Scene:
        """The scene of a point."""
        return self.over.scene_at(row.value)

    def saved(self, end: _BranchEnd) -> dict[str, State]:
        """Arrays, by group and name, from which the branch continues."""
        resume = stored(end.point, end.step) | {"metric": np.array([end.metric.period, end.metric.parameter])}
        return {"resume": resume} | {f"{_OUTLINE}{index}": state for index, state in self.outlines.items()}

    def restored(self, saved: Mapping[str, State]) -> _BranchEnd:
        """The inverse of `saved`."""
        state = saved["resume"]
        self.outlines.update({int(name.removeprefix(_OUTLINE)): saved[name] for name in saved if name.startswith(_OUTLINE)})
        period, parameter = state["unknowns"][-2:].tolist()
        _, point, step = from_stored(self.family_at(parameter, period), state)
        return _BranchEnd(point, step, Metric(*state["metric"].tolist()))

    def begin(self) -> _BranchEnd:
        """Record the Hopf point in the range nearest to its first end, or else an orbit at an end where steady sliding is
        unstable.

        Raises SceneError if steady sliding is stable in the whole range, NumericsError if no orbit is found.
        """
        over, port = self.over, one_port_of(self.model)
        if self.doubled:
            return self._from_doubling()
        hopf_points = sorted(onsets(over.scene_at, *over.ends, port), key=lambda onset: abs(onset.parameter - over.first))
        if not hopf_points:
            return self._from_orbit(port)
        own, *others = hopf_points
        first = self._from_hopf(own)
        if first is None:
            at = f"{over.name} = {own.parameter:.10g}"
            self.notes.append(f"the grid's own Hopf point is not that of the waves, {at}: more --cells bring it nearer")
            return self._from_orbit(port)
        self.special.append(self._hopf(own))
        self.notes.extend(
            f"another Hopf point lies at {over.name} = {other.parameter:.10g}, period {other.period:.6g}; this branch is that of "
            f"{own.parameter:.10g}"
            for other in others
        )
        return self._first(first, metric_for(*over.ends))

    def follow(self, end: _BranchEnd, limits: StopAt) -> Iterator[_BranchEnd]:
        """Record point after point, yielding the end after each. Stops at the limits, where the branch leaves the range without
        return, and where the orbits shrink to steady sliding. Raises NumericsError where it cannot be followed within the
        range."""
        steps = self.steps(end, lambda _: True, Control(first=end.step))
        while True:
            reason = self._why_to_stop(end, limits)
            if reason is not None:
                self.notes.extend([reason] if reason else [])
                return
            try:
                step = next(steps)
            except NumericsError as error:
                if self.over.beyond(end.point.parameter) < -_AT_END:
                    raise
                reason = str(error).replace("parameter =", f"{self.over.name} =")
                self.notes.append(self._left(end.point.parameter, f": {reason}"))
                return
            new, old = step.point.closed, end.point.closed
            if self.doubled and difference_of_parts(new, 2) < min(_SAME, difference_of_parts(old, 2)):
                self.notes.append("the branch ends at a period doubling, where both halves of its orbits become the same")
                return
            if amplitude(new.cycle) < min(_SMALL, amplitude(old.cycle)):  # nearly singular beyond
                near = onsets(self.over.scene_at, *self.over.ends, one_port_of(self.model))
                nearest = min(near, key=lambda onset: abs(onset.parameter - end.point.parameter), default=None)
                if nearest and self._from_hopf(nearest):
                    self.special.append(self._hopf(nearest))
                self.notes.append("the branch ends where its orbits shrink to steady sliding")
                return
            for special in step.special:
                self.closed[len(self.special)] = special.point.closed
                self.outlines[len(self.special)] = without_derivatives(special.point)
                self.special.append(SpecialPoint.of(special, len(self.points)))
            self._record(step.point)
            end = _BranchEnd(step.point, step.next_step, end.metric)
            yield end

    def steps(self, end: _BranchEnd, inside: Callable[[OrbitPoint], bool], control: Control) -> Iterator[Step]:
        """The points after `end`, with their orbits, up to the first that is not `inside`. Raises NumericsError as `follow`."""
        family = FlowFamily(end.point.closed.flow, self.over.scene_at)
        return follow_branch(family, end.point, end.metric, inside, self.tolerance, control)

    def family_at(self, parameter: float, period: float) -> FlowFamily:
        """The model's flows, on a mesh that resolves steady sliding and its slow oscillations with `period` (transits)."""
        flow, start = moving(self.model, self.over.scene_at(parameter), self.cells).flow(period, self.tolerance)
        return FlowFamily(flow.loosened(start, self._end_scenes)[0], self.over.scene_at)

    @property
    def _end_scenes(self) -> list[Scene]:
        """The scenes at both ends of the range: a mesh serves them both."""
        return [self.over.scene_at(value) for value in self.over.ends]

    def named(self) -> dict[str, int]:
        """Name of each special point within the range, as NS2 for the second torus point, and its index."""
        count: Counter[str] = Counter()
        indices = {}
        for index, special in enumerate(self.special):
            if self.over.holds(special.value):
                count[special.kind] += 1
                indices[f"{special.kind}{count[special.kind]}"] = index
        return indices

    def special_at(self, index: int) -> Special:
        """A special point, but for a Hopf point, with its orbit. Raises NumericsError if that does not close again."""
        row, state = self.special[index], self.outlines[index]
        family = self.family_at(row.value, float(state["unknowns"][-2]))
        _, point = from_outline(family, state, metric_for(*self.over.ends))
        passing = complex(critical(row.kind, point.multipliers))
        return Special(row.kind, point, row.bracket, row.unstable_before or 0, row.unstable_after or 0, passing)

    def guess_at(self, index: int, scene: Scene) -> Guess | None:
        """The orbit of a point, on its mesh, for Newton's method at the point's `scene`; None if it was read from a file."""
        outline = self.starts.get(index)
        if outline is None:
            return None
        *start, period, value = outline["unknowns"].tolist()
        return Guess(self.family_at(value, period)(value).on_mesh(mesh_of(outline)).of(scene), np.array(start), period, False)

    def first_special(self, end: _BranchEnd, kind: str) -> tuple[Special, FlowFamily]:
        """The first special point of `kind` after `end` in the range, and the flows on its mesh. Raises NumericsError if there
        is none."""
        over, last = self.over, end.point
        for step in self.steps(end, lambda point: over.beyond(point.parameter) <= StopAt().outside, Control()):
            for special in step.special:
                if special.kind == kind and over.holds(special.point.parameter):
                    return special, FlowFamily(special.point.closed.flow, over.scene_at)
            last = step.point
        ended = f"it was followed to {over.name} = {last.parameter:.7g} and a period of {last.closed.cycle.period:.5g} transits"
        raise NumericsError(
            f"no {SPECIAL_KINDS[kind]} was found on the branch over {over.name} from {over.first:g} to {over.last:g}: {ended}"
        )

    def _first(self, point: OrbitPoint, metric: Metric) -> _BranchEnd:
        self._record(point)
        return _BranchEnd(point, Control.first, metric)

    def _record(self, point: OrbitPoint) -> None:
        self.starts[len(self.points)] = without_derivatives(point)
        self.points.append(BranchPoint.of(point))
        last = self.points[-1]
        if last.stable is None or last.idle:
            note = _UNDECIDED if last.stable is None else _WITHOUT_IDLE
            self.notes.extend([] if note in self.notes else [note])

    def _from_hopf(self, onset: Onset) -> OrbitPoint | None:
        """The first small orbit at a Hopf point; None on a grid that is so coarse that its own lies elsewhere."""
        family = self.family_at(onset.parameter, onset.period)
        try:
            return from_hopf(family, onset.parameter, onset.period, metric_for(*self.over.ends))
        except NumericsError:
            if family_of(self.model) in GRIDS:
                return None
            raise

    def _from_orbit(self, port: str) -> _BranchEnd:
        over = self.over
        growing = {value: unstable_count(characteristic(over.scene_at(value), port)) for value in (over.first, over.last)}
        unstable = [value for value, count in growing.items() if count]
        if not unstable:
            raise SceneError(
                f"--over {over.name}={over.first:g}:{over.last:g}: steady sliding of {self.model} is stable at both ends, so no "
                "branch of orbits begins between them"
            )
        failed = list[NumericsError]()
        for value in unstable:
            try:
                return self._from_end(value)
            except NumericsError as error:
                failed.append(error)
        if sum(growing.values()) % 2 == 0:
            raise failed[0]
        crosses = f"a single real root crosses between {over.name} = {over.first:g} and {over.last:g}, and no orbit begins there"
        raise NumericsError(f"{crosses}; {failed[0]}") from None

    def _from_end(self, value: float) -> _BranchEnd:
        """Record the orbit that a run at this end of the range leads to. Raises NumericsError if it leads to none."""
        over, metric = self.over, metric_for(*self.over.ends)
        other = sum(over.ends) - value
        beside = value + _BESIDE * (other - value)
        flow = self.family_at(value, 1.0)(value)
        if flow.size != flow.of(over.scene_at(beside)).size:  # at the value alone slabs are one pair
            value = beside
        closed = find_orbit(self.model, over.scene_at(value), self.tolerance, self.cells).periodic.closed
        closed = closed_between(closed, self._end_scenes)
        return self._first(from_orbit(FlowFamily(closed.flow, over.scene_at), closed, value, other, metric), metric)

    def _from_doubling(self) -> _BranchEnd:
        """The first orbit of twice the period, at the first period doubling of the scene's own branch in the range."""
        own = replace(self, doubled=False, points=[], special=[], notes=[])
        end = own.begin()
        special, family = own.first_special(end, "PD")
        born = SpecialPoint.of(special, 0)
        self.special.append(born._replace(period=2.0 * born.period))
        return self._first(from_doubling(family, special, end.metric)[1], end.metric)

    def _why_to_stop(self, end: _BranchEnd, limits: StopAt) -> str | None:
        """Reason to stop, empty if that needs no remark; None to continue."""
        point = end.point
        if limits.kind and any(special.kind == limits.kind for special in self.shown_special):
            return ""
        if self.over.beyond(point.parameter) > limits.outside:
            return self._left(point.parameter, ", and does not return within a quarter of the range")
        if point.closed.cycle.period > limits.period:
            return f"stopped at the period {limits.period:g}: --longest-period goes further"
        if len(self.points) >= limits.points:
            return f"stopped after {len(self.points)} points: --most-points goes further"
        return None

    def _left(self, value: float, how: str) -> str:
        """Note on a branch that left the range for good, last seen at `value`."""
        return f"the branch leaves the range at {self.over.name} = {self.over.nearest_end(value):g}{how}"

    def _hopf(self, onset: Onset) -> SpecialPoint:
        rate = self.over.scene_at(onset.parameter).velocity
        width = ONSET_WIDTH * metric_for(*self.over.ends).scale(onset.parameter)
        figures = (onset.parameter, onset.period, 0.0, 0.0, rate, rate)
        return SpecialPoint("HB", *figures, width, onset.unstable_below, onset.unstable_above, len(self.points))
