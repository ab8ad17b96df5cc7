"""Branches of periodic orbits in log10 r from the Hopf point, with the orbits themselves; the paper's material at V = 100."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from reduced.continuation.branch import Control
from reduced.continuation.point import OrbitPoint
from reduced.continuation.special import Special
from reduced.continuation.start import orbits_at
from reduced.orbit.closing import Closed
from reduced.stability.onsets import Onset
from slipwave.scene import Scene
from validation.models.branch import FollowedBranch
from validation.models.parameter import ParameterRange, over_range
from validation.models.points import BranchPoint

RANGE = (-2.72, -2.3)
"""log10 r."""

FAR = 200.0
"""A period (transits) that none of these branches reaches."""

COMPARED = ("period", "stress_drop", "elastic_stress_drop")
"""The figures of an orbit that tables and diagrams show."""

TOLERANCE = 1e-7


@dataclass(frozen=True)
class Branch:
    """A model's branch: its Hopf point; its points, including the special points in order; the special points."""

    model: str
    onset: Onset
    points: tuple[OrbitPoint, ...]
    special: tuple[Special, ...]

    @property
    def corners(self) -> list[BranchPoint]:
        """All points as numbers; `unstable` holds up to the next one."""
        after = {id(special.point): special.unstable_after for special in self.special}
        return [BranchPoint.of(point)._replace(unstable=after.get(id(point), point.unstable)) for point in self.points]

    def of_kind(self, *kinds: str) -> list[Special]:
        """Its special points of these kinds, in order."""
        return [special for special in self.special if special.kind in kinds]

    def orbits_at(self, log10_r: float) -> list[Closed]:
        """All orbits of the branch at one r, in order."""
        return orbits_at(self.points, log10_r, scene_at(log10_r))


@cache
def branch_of(model: str, highest: float, longest: float, tolerance: float = TOLERANCE, most: float = Control.longest) -> Branch:
    """The branch from the loss of stability of the steady sliding of `model`, until log10 r reaches `highest` or the period
    `longest` (transits); on a mesh that keeps relative errors of the figures below `tolerance`, in steps of at `most`
    (`Control`)."""
    branch = FollowedBranch(_paper_over_r(), model, tolerance)
    end = branch.begin()
    points, specials = [end.point], list[Special]()
    goes_on, steps = lambda point: point.parameter < highest and point.closed.cycle.period < longest, Control(longest=most)
    for step in branch.steps(end, goes_on, steps):
        points += [*(special.point for special in step.special), step.point]
        specials += step.special
    born = branch.special[0]
    onset = Onset(born.value, born.period, born.unstable_before or 0, born.unstable_after or 0)
    return Branch(model, onset, tuple(points), tuple(specials))


@cache
def _paper_over_r() -> ParameterRange:
    low, high = RANGE
    return over_range(f"log10_r={low}:{high}", "paper")


def scene_at(log10_r: float) -> Scene:
    """The paper's scene at another r."""
    return _paper_over_r().scene_at(log10_r)


def unaccounted(branch: Branch) -> int:
    """Points of a branch whose number of unstable multipliers is not that of the first point plus the changes at the special
    points before it: 1 at a fold and a period doubling, 2 at a torus point."""
    count, wrong = branch.points[0].unstable, 0
    special = {id(special.point): special for special in branch.special}
    for point in branch.points:
        passed = special.get(id(point))
        if passed is None:
            wrong += point.unstable != count
            continue
        change = passed.unstable_after - passed.unstable_before
        wrong += abs(change) != {"LP": 1, "PD": 1, "NS": 2}[passed.kind]
        count += change
    return wrong


def parts(corners: list[BranchPoint]) -> Iterator[tuple[bool, list[BranchPoint]]]:
    """The branch cut where its stability changes: (stable, corners), each part with both ends."""
    begin = 0
    for n in range(1, len(corners)):
        if n == len(corners) - 1 or (corners[n].unstable == 0) != (corners[begin].unstable == 0):
            yield corners[begin].unstable == 0, corners[begin : n + 1]
            begin = n
