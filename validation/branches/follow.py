"""Begins a branch of periodic orbits, at a Hopf point or at an orbit that a run leads to, and follows it."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from reduced.continuation.branch import Control, follow_branch
from reduced.continuation.onset import WIDTH, Onset, onsets
from reduced.continuation.point import Family, Metric, Point
from reduced.continuation.special import Special
from reduced.continuation.start import difference_of_halves, from_doubling, from_hopf, from_orbit, metric_for
from reduced.orbit.figures import amplitude
from reduced.stability.characteristic import characteristic
from reduced.stability.spectrum import unstable_count
from slipwave.errors import NumericsError, SceneError
from slipwave.input.wording import shorten
from validation.branches import KINDS
from validation.branches.parameter import Over
from validation.branches.record import Branch, SpecialPoint, point_of, special_of
from validation.registry.families import one_port_of
from validation.registry.orbits import find_orbit, moving

_SMALL = 0.1  # amplitude of ln v
_MOST_OUTSIDE = 200  # points of a branch that begins just outside of its range before it is given up
_SAME = 0.03  # difference of ln v and psi between two halves

_UNDECIDED = (
    "stability is not decided where the essential radius is 1: some motion of the slabs is never damped by friction there, and "
    "multipliers cannot tell; "
)
_UNCOUNTED = "they accumulate at the unit circle and are not counted, so of the special points only HB and LP are found"
_WITHOUT_IDLE = (
    "numbers of unstable multipliers, and PD and NS found by them, leave out idle modes, in which both slabs swing alike without "
    "slip or stress at the interface: slipwave orbit names them"
)


class Head(NamedTuple):
    """The last `point` of a branch and the length of the next `step`: all that is needed to go on."""

    point: Point
    step: float
    metric: Metric


class Limits(NamedTuple):
    """Where to stop: beyond a `period` (transits), after so many `points`, at the first special point of a `kind` (if any)."""

    period: float = math.inf
    points: int = 2000
    kind: str = ""


def limits_of(kind: str | None, period: float | None, points: int) -> Limits:
    """The limits of the command line. Raises SceneError naming an option that makes no sense."""
    if kind is not None and kind not in KINDS:
        raise SceneError(f"--stop-at {shorten(kind)}: must be one of {', '.join(KINDS)}")
    if period is not None and not period > 0.0:
        raise SceneError(f"--longest-period = {period:g}: must be above 0")
    if points < 1:
        raise SceneError(f"--most-points = {points}: must be at least 1")
    return Limits(math.inf if period is None else period, points, kind or "")


def is_doubled(switch: str | None) -> bool:
    """Whether --switch asks for the doubled orbits. Raises SceneError for another word than HB and PD."""
    if switch not in (None, "HB", "PD"):
        raise SceneError(f"--switch {shorten(switch)}: must be HB or PD")
    return switch == "PD"


def begin(branch: Branch) -> Head:
    """The beginning of a branch, whose Hopf point is recorded: the one in the range nearest to its first end, or else an orbit at
    an end where steady sliding is unstable.

    Raises SceneError if steady sliding is stable in the whole range, NumericsError if no orbit is found.
    """
    over, port = branch.over, one_port_of(branch.model)
    if branch.doubled:
        return _from_doubling(branch)
    found = sorted(onsets(over.scene_at, *over.ends, port), key=lambda onset: abs(onset.parameter - over.first))
    if found:
        branch.special.append(_hopf(over, found[0], 0))
        branch.notes.extend(
            f"another Hopf point lies at {over.name} = {other.parameter:.10g}, period {other.period:.6g}; this branch is that of "
            f"{found[0].parameter:.10g}"
            for other in found[1:]
        )
        return _from_onset(branch, found[0])
    return _from_orbit(branch, port)


def follow(branch: Branch, head: Head, limits: Limits) -> Iterator[Head]:
    """Record point after point; what is yielded is where the branch can go on. Ends at the limits, where it leaves the range, and
    where the orbits shrink to steady sliding. Raises NumericsError where it cannot be followed."""
    over = branch.over
    family = Family(head.point.closed.flow, over.scene_at)
    steps = follow_branch(family, head.point, head.metric, lambda _: True, branch.tolerance, Control(first=head.step))
    while True:
        reason = _end(branch, head, limits)
        if reason is not None:
            branch.notes.extend([reason] if reason else [])
            return
        step = next(steps)
        if branch.doubled and _closes(head.point, step.point):
            branch.notes.append("the branch ends at a period doubling, where both halves of its orbits become the same")
            return
        if _vanishes(head.point, step.point):
            _end_at_hopf(branch, head.point)
            return
        for special in step.special:
            branch.closed[len(branch.special)] = special.point.closed
            branch.special.append(special_of(special, len(branch.points)))
        record(branch, step.point)
        head = Head(step.point, step.next_step, head.metric)
        yield head


def record(branch: Branch, point: Point) -> None:
    """Add a point to the branch."""
    branch.points.append(point_of(point))
    if branch.points[-1].stable is None:
        note = _UNDECIDED + (_UNCOUNTED if point.closed.flow.undecided else _WITHOUT_IDLE)
        branch.notes.extend([] if note in branch.notes else [note])


def _end(branch: Branch, head: Head, limits: Limits) -> str | None:
    """Why the branch is not followed any further: empty if that needs no remark; None if it is."""
    point = head.point
    if limits.kind and any(special.kind == limits.kind for special in branch.special):
        return ""
    if not branch.over.holds(point.parameter) and not _enters(branch):
        low, high = branch.over.ends
        return f"the branch leaves the range at {branch.over.name} = {low if point.parameter < low else high:g}"
    if point.closed.cycle.period > limits.period:
        return f"stopped at the period {limits.period:g}: --longest-period goes further"
    if len(branch.points) >= limits.points:
        return f"stopped after {len(branch.points)} points: --most-points goes further"
    return None


def _enters(branch: Branch) -> bool:
    """Whether the branch, which began at a Hopf point at the edge of the range or a little outside, may still come into it."""
    return [special.kind for special in branch.special[:1]] == ["HB"] and len(branch.points) < _MOST_OUTSIDE and not branch.shown


def _hopf(over: Over, onset: Onset, place: int) -> SpecialPoint:
    rate = over.scene_at(onset.parameter).velocity
    drops = (0.0, 0.0)
    counts = (onset.unstable_below, onset.unstable_above)
    return SpecialPoint("HB", onset.parameter, onset.period, *drops, rate, rate, WIDTH, *counts, place)


def family_at(branch: Branch, parameter: float, period: float) -> Family:
    """The model's flows, on a mesh that suits steady sliding and its slow oscillations with `period` (transits)."""
    model = moving(branch.model, branch.over.scene_at(parameter), branch.tolerance, branch.cells)
    return Family(model.freeze(model.solver, period)[0], branch.over.scene_at)


def _from_onset(branch: Branch, onset: Onset) -> Head:
    metric = metric_for(*branch.over.ends)
    point = from_hopf(family_at(branch, onset.parameter, onset.period), onset.parameter, onset.period, metric)
    record(branch, point)
    return Head(point, Control.first, metric)


def _from_orbit(branch: Branch, port: str) -> Head:
    over = branch.over
    unstable = [value for value in (over.first, over.last) if unstable_count(characteristic(over.scene_at(value), port))]
    if not unstable:
        raise SceneError(
            f"--over {over.name}={over.first:g}:{over.last:g}: steady sliding of {branch.model} is stable at both ends, so no "
            "branch of orbits begins between them"
        )
    value, metric = unstable[0], metric_for(*over.ends)
    found = find_orbit(moving(branch.model, over.scene_at(value), branch.tolerance, branch.cells), branch.tolerance).found.closed
    point = from_orbit(Family(found.flow, over.scene_at), found, value, sum(over.ends) - value, metric)
    record(branch, point)
    return Head(point, Control.first, metric)


def _from_doubling(branch: Branch) -> Head:
    """The first orbit of twice the period, beside the first period doubling of the scene's own branch in the range."""
    own = replace(branch, doubled=False, points=[], special=[], notes=[])
    head = begin(own)
    special, family = first_special(own, head, "PD")
    born = special_of(special, 0)
    branch.special.append(born._replace(period=2.0 * born.period))
    _, point = from_doubling(family, special, head.metric)
    record(branch, point)
    return Head(point, Control.first, head.metric)


def first_special(branch: Branch, head: Head, kind: str) -> tuple[Special, Family]:
    """The first special point of `kind` after `head` in the branch's range, and the flows on its mesh. Raises NumericsError if
    there is none."""
    over = branch.over
    family, last = Family(head.point.closed.flow, over.scene_at), head.point
    for step in follow_branch(family, head.point, head.metric, lambda point: over.holds(point.parameter), branch.tolerance):
        for special in step.special:
            if special.kind == kind:
                return special, Family(special.point.closed.flow, over.scene_at)
        last = step.point
    ended = f"it was followed to {over.name} = {last.parameter:.7g} and a period of {last.closed.cycle.period:.5g} transits"
    raise NumericsError(
        f"no {KINDS[kind]} was found on the branch over {over.name} from {over.first:g} to {over.last:g}: {ended}"
    )


def _closes(before: Point, after: Point) -> bool:
    """Whether the two halves of doubled orbits are nearly alike and become more so: that ends in a period doubling."""
    return difference_of_halves(after) < min(_SAME, difference_of_halves(before))


def _vanishes(before: Point, after: Point) -> bool:
    """Whether the orbits are small and become smaller: that can only end in steady sliding, and near it the equations are nearly
    singular."""
    return amplitude(after.closed.cycle) < min(_SMALL, amplitude(before.closed.cycle))


def _end_at_hopf(branch: Branch, last: Point) -> None:
    """Record the Hopf point at which the branch ends."""
    near = onsets(branch.over.scene_at, *branch.over.ends, one_port_of(branch.model))
    if near:
        nearest = min(near, key=lambda onset: abs(onset.parameter - last.parameter))
        branch.special.append(_hopf(branch.over, nearest, len(branch.points)))
    branch.notes.append("the branch ends where its orbits shrink to steady sliding")
