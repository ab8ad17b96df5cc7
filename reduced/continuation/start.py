"""The first point of a branch that does not begin at a Hopf point (`hopf`): an orbit found otherwise, or a stored point."""

from dataclasses import dataclass, replace

import numpy as np

from reduced.continuation.mesh import Family
from reduced.continuation.point import FlowAt, Metric, Point, direction
from reduced.orbit.closing import Closed, by_parameter
from slipwave.observe.pieces import Array
from slipwave.solve import State


@dataclass(frozen=True)
class Stored:
    """All that is needed to go on from a point, to the last digit: its `unknowns` (x, T, p), `tangent`, the next `step`, the
    `mesh` and the derivatives of `Closed`, which may be those of a neighbour."""

    unknowns: Array
    tangent: Array
    step: float
    mesh: State
    monodromy: Array
    velocity: Array
    drift: Array


def metric_for(low: float, high: float) -> Metric:
    """Lengths on a branch between two parameters: a change by this range counts as much as twenty transits of period.

    Periods of a delay system's orbits at one parameter differ by about a transit from fold to fold, so that folds are round."""
    return Metric(20.0, abs(high - low) or 1.0)


def from_orbit(flow_at: FlowAt, closed: Closed, parameter: float, towards: float, metric: Metric) -> Point:
    """An orbit found at a fixed `parameter` as a point of its branch, oriented towards the parameter `towards`."""
    cycle = closed.cycle
    found = replace(closed, parameter=parameter, drift=by_parameter(flow_at, cycle, parameter))
    along = np.zeros(cycle.start.size + 2)
    along[-1] = np.sign(towards - parameter) * metric.parameter
    return Point(found, direction(found, along, metric))


def stored(point: Point, step: float) -> Stored:
    """A point in the form for a file."""
    closed = point.closed
    derivatives = (closed.monodromy, closed.velocity, closed.drift)
    return Stored(point.unknowns, point.tangent, step, closed.flow.mesh_state(), *derivatives)


def from_stored(family: Family, saved: Stored) -> tuple[Family, Point]:
    """The family on the stored mesh, and the point."""
    *start, period, parameter = saved.unknowns.tolist()
    flow = family(parameter).on_mesh(saved.mesh)
    cycle = flow.march(np.array(start), period)
    residual = float(np.abs(cycle.end - cycle.start).max())
    closed = Closed(flow, cycle, residual, saved.monodromy, saved.velocity, saved.drift, parameter, 0)
    return family.on(flow), Point(closed, saved.tangent)
