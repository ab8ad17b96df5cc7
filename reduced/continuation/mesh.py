"""The flows of a branch: one for each value of the parameter, all on one mesh, and a finer mesh where the motion asks for it."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from reduced.continuation.point import Metric, Point, direction
from reduced.orbit.closing import close_family
from slipwave.errors import NumericsError
from slipwave.scene import Scene
from slipwave.step.flow import Flow

_LARGEST_REFINEMENT = 1.5
_ROOM = 1.1  # refined so far that the next points are fine enough too
MOST_REFINEMENTS = 8
"""Refinements in a row after which a branch ends."""


class Family:
    """`flow` for all scenes `scene_at(p)`: calling it gives the flow at the parameter p."""

    def __init__(self, flow: Flow, scene_at: Callable[[float], Scene]) -> None:
        self._scene_at = scene_at
        self._at = lru_cache(maxsize=8)(lambda parameter: flow.of(scene_at(parameter)))

    def __call__(self, parameter: float) -> Flow:
        """The flow at a parameter."""
        return self._at(parameter)

    def on(self, flow: Flow) -> "Family":
        """The same scenes on the mesh of `flow`."""
        return Family(flow, self._scene_at)


def roughness(point: Point, tolerance: float) -> float:
    """How much too coarse the mesh of a point is: above 1 it does not reach `tolerance`."""
    return point.closed.flow.roughness(point.closed.cycle, tolerance)


def refined(family: Family, point: Point, metric: Metric, tolerance: float) -> tuple[Family, Point]:
    """The family on a mesh that suits the motion at `point` to `tolerance`, and the point found again on it.

    Raises NumericsError if no mesh does.
    """
    for _ in range(MOST_REFINEMENTS):
        excess = roughness(point, tolerance)
        closed, nodes = point.closed, point.closed.flow.nodes.size
        finer = float(np.clip(_ROOM * excess ** (1.0 / nodes), 1.0, _LARGEST_REFINEMENT))
        flow, state = closed.flow.remeshed(closed.cycle, finer)
        family = family.on(flow)
        along = np.concatenate([np.zeros(flow.size), point.tangent[-2:]])
        weights = metric.weights(flow.size) * along
        found = close_family(family, state, closed.cycle.period, closed.parameter, weights / metric.length(along))
        point = Point(found, direction(found, along, metric))
        if roughness(point, tolerance) <= 1.0:
            return family, point
    raise too_rough(point, tolerance)


def too_rough(point: Point, tolerance: float) -> NumericsError:
    """The error of a branch that no mesh resolves beyond `point`."""
    return NumericsError(
        f"the branch ends at parameter = {point.parameter:.10g}: no mesh resolves the motion to {tolerance:g} (the highest "
        f"coefficient is {roughness(point, tolerance):.2g} times too large)"
    )
