"""What is kept of a branch: its points, its special points, and remarks."""

from dataclasses import dataclass, field
from typing import NamedTuple

from reduced.continuation.point import Point
from reduced.continuation.special import Special
from reduced.orbit.closing import Closed
from reduced.orbit.figures import figures_of
from reduced.orbit.multipliers import is_decided
from validation.branches.parameter import Over


class BranchPoint(NamedTuple):
    """An orbit at a `value` of the parameter: its figures (`reduced.orbit.figures`), the number of `unstable` multipliers, None
    where they cannot be counted, and whether it is `stable`; None if multipliers cannot tell."""

    value: float
    period: float
    stress_drop: float
    elastic_stress_drop: float
    v_max: float
    v_min: float
    unstable: int | None
    stable: bool | None


class SpecialPoint(NamedTuple):
    """A point of `kind` HB, LP, PD or NS with the figures of its orbit; `bracket`, the width in the parameter of the interval
    that holds it; numbers of unstable multipliers (HB: of growing roots of steady sliding) before and after, None where they
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


@dataclass(frozen=True)
class Branch:
    """The branch of `model` over a parameter, as far as it is known: its lists grow. `tolerance` is the requested relative error
    of all figures, `cells` is for full waves. `closed` are the orbits of special points by their place in that list, if they were
    computed in this process. `doubled`: of the orbits of twice the period that are born at the first period
    doubling of the scene's own branch."""

    over: Over
    model: str
    tolerance: float
    cells: int | None = None
    doubled: bool = False
    points: list[BranchPoint] = field(default_factory=list)
    special: list[SpecialPoint] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    closed: dict[int, Closed] = field(default_factory=dict)

    @property
    def shown(self) -> list[BranchPoint]:
        """The points within the range; the last of all may lie beyond."""
        return [point for point in self.points if self.over.holds(point.value)]

    @property
    def shown_special(self) -> list[SpecialPoint]:
        """The special points within the range."""
        return [special for special in self.special if self.over.holds(special.value)]


def point_of(point: Point) -> BranchPoint:
    """The record of an orbit."""
    closed, known = point.closed, figures_of(point.closed)
    unstable = None if closed.flow.undecided else point.unstable
    stable = False if unstable else True if is_decided(closed) else None
    return BranchPoint(point.parameter, **known, unstable=unstable, stable=stable)


def special_of(found: Special, place: int) -> SpecialPoint:
    """The record of a special point after so many points."""
    counted = not found.point.closed.flow.undecided
    return SpecialPoint(
        found.kind,
        found.point.parameter,
        **figures_of(found.point.closed),
        bracket=found.bracket,
        unstable_before=found.unstable_before if counted else None,
        unstable_after=found.unstable_after if counted else None,
        place=place,
    )
