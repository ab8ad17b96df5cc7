"""The orbits of a branch at one value of its parameter: where the branch crosses it."""

from collections.abc import Iterable
from itertools import pairwise

from reduced.continuation.point import Point
from reduced.orbit.closing import Closed, close
from slipwave.scene import Scene
from slipwave.step.flow import Flow

_ROUND = 1e-9  # difference of two periods that count as one orbit's, relative


def orbits_at(points: Iterable[Point], parameter: float, scene: Scene) -> list[Closed]:
    """All orbits of a branch at one value of its `parameter`, in order along the branch, each by Newton's method from the points
    on both sides; `scene` is that of this value. Raises NumericsError if it does not find one."""
    found: list[Closed] = []
    for left, right in pairwise(points):
        if (left.parameter - parameter) * (right.parameter - parameter) <= 0.0:
            one = _orbit_between(left, right, parameter, right.closed.flow.of(scene))
            if not found or abs(one.cycle.period / found[-1].cycle.period - 1.0) > _ROUND:
                found.append(one)
    return found


def _orbit_between(left: Point, right: Point, parameter: float, flow: Flow) -> Closed:
    """The orbit of `flow`, which is on the mesh of `right`, between two points whose meshes may differ."""
    same = left.unknowns.size == right.unknowns.size
    along = right.unknowns - left.unknowns if same else right.tangent
    guess = right.unknowns + (parameter - right.parameter) / along[-1] * along
    return close(flow, guess[:-2], float(guess[-2]))
