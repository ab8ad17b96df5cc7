"""The branch of orbits of twice the period that is born at a period doubling."""

import numpy as np
import scipy.linalg

from reduced.continuation.mesh import Family
from reduced.continuation.point import Metric, Point, point_near
from reduced.continuation.special import Special
from reduced.orbit.returns import difference_of_parts
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array

_AMPLITUDES = (3e-3, 1e-3, 1e-4)  # of the largest component of the state; the first with which Newton's method converges
_ALIKE = 0.1  # difference of the halves, over the amplitude, below which the orbit is a simple one
_NEAR = 1e-3  # distance of the multiplier from -1


def from_doubling(family: Family, special: Special, metric: Metric) -> tuple[Family, Point]:
    """The first orbit of twice the period beside the period doubling `special`, and the family on a mesh for it: displaced along
    the eigenvector of the multiplier -1, by which the two halves of the doubled orbit differ.

    Raises NumericsError if the special point is no period doubling, or no such orbit is found.
    """
    closed = special.point.closed
    values, vectors = scipy.linalg.eig(closed.monodromy)
    passing = int(np.abs(values + 1.0).argmin())
    if special.kind != "PD" or abs(values[passing] + 1.0) > _NEAR:
        raise NumericsError(f"parameter = {closed.parameter:.10g} is no period doubling: the multiplier is {values[passing]:.6g}")
    shape = vectors[:, passing].real
    shape = shape / np.abs(shape).max()
    failed = NumericsError("")
    for amplitude in _AMPLITUDES:
        try:
            return _displaced(family, special.point, shape, amplitude, metric)
        except NumericsError as reason:
            failed = reason
    raise failed


def _displaced(family: Family, simple: Point, shape: Array, amplitude: float, metric: Metric) -> tuple[Family, Point]:
    """The doubled orbit at this amplitude of its deviation `shape` from the simple one, measured across the branch of simple
    orbits, so that none of these can be found instead."""
    closed = simple.closed
    period = 2.0 * closed.cycle.period
    flow, state = closed.flow.remeshed(closed.cycle._replace(start=closed.cycle.start + amplitude * shape, period=period), 1.0)
    family = family.on(flow)
    branch = simple.tangent[:-2]
    along = np.append(shape - (shape @ branch) / (branch @ branch) * branch, [0.0, 0.0])
    point = point_near(family, np.append(state, [period, closed.parameter]), along / metric.length(along), metric)
    if difference_of_halves(point) < _ALIKE * amplitude:
        raise NumericsError(f"no orbit of twice the period was found beside parameter = {closed.parameter:.10g}")
    return family, point


def difference_of_halves(point: Point) -> float:
    """Largest difference of z and psi between the first and the second half of an orbit; 0 if it is a simple one, twice."""
    return difference_of_parts(point.closed.cycle, point.closed.flow.nodes, 2)
