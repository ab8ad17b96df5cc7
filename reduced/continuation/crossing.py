"""The orbits of a branch at one value of its parameter: where the branch crosses it."""

from reduced.continuation.point import Point
from reduced.orbit.closing import Closed, close
from slipwave.step.flow import Flow


def crosses(left: Point, right: Point, parameter: float) -> bool:
    """Whether the branch crosses the `parameter` between two neighbours."""
    return bool((left.parameter - parameter) * (right.parameter - parameter) <= 0.0)


def orbit_between(left: Point, right: Point, parameter: float, flow: Flow) -> Closed:
    """The orbit of `flow`, which is on the mesh of `right` at the `parameter`, between two points whose meshes may differ.

    Raises NumericsError if Newton's method does not find it."""
    same = left.unknowns.size == right.unknowns.size
    along = right.unknowns - left.unknowns if same else right.tangent
    guess = right.unknowns + (parameter - right.parameter) / along[-1] * along
    return close(flow, guess[:-2], float(guess[-2]))
