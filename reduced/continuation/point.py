"""A branch of periodic orbits: its flows, on one mesh, its points, and its refinement to a finer mesh."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.linalg

from reduced.impedance.transmission_line import Complex
from reduced.orbit.closing import Closed, FlowAt, close_family
from reduced.orbit.multipliers import floquet
from slipwave.errors import NumericsError, SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.step.flow import Flow

_LARGEST_REFINEMENT = 1.5
_EXCESS = 1.1  # refined so far that the next points are fine enough too
MOST_REFINEMENTS = 8
"""Refinements in a row after which a branch ends."""


class FlowFamily:
    """The flow of the scenes `scene_at(p)` on the mesh of `flow`: calling it gives the flow at the parameter p."""

    def __init__(self, flow: Flow, scene_at: Callable[[float], Scene]) -> None:
        self._scene_at, self._size = scene_at, flow.size
        self._at = lru_cache(maxsize=8)(lambda parameter: flow.of(scene_at(parameter)))

    def __call__(self, parameter: float) -> Flow:
        """The flow at a parameter. Raises NumericsError where there is no such scene, or none with states of this size."""
        try:
            start = self._at(parameter)
        except SceneError as error:
            raise NumericsError(f"there is no scene at parameter = {parameter:.10g}: {error}") from None
        if start.size != self._size:
            raise NumericsError(f"waves at parameter = {parameter:.10g} need a state of {start.size} values, not {self._size}")
        return start

    def on(self, flow: Flow) -> "FlowFamily":
        """The same scenes on the mesh of `flow`."""
        return FlowFamily(flow, self._scene_at)


@dataclass(frozen=True)
class Metric:
    """Lengths on a branch: |u|^2 = |x|^2/n + (T/period)^2 + (p/parameter)^2 for changes u = (x, T, p) of the unknowns."""

    period: float
    parameter: float

    def scale(self, parameter: float) -> float:
        """What rounding errors of a parameter are relative to."""
        return max(abs(parameter), self.parameter)

    def weights(self, size: int) -> Array:
        """w (n + 2,) with |u|^2 = sum w u^2, for states of `size` values."""
        return np.concatenate([np.full(size, 1.0 / size), [self.period**-2, self.parameter**-2]])

    def product(self, u: Array, v: Array) -> float:
        """Scalar product of two changes."""
        return float(u @ (self.weights(u.size - 2) * v))

    def length(self, u: Array) -> float:
        """|u|."""
        return float(np.sqrt(self.product(u, u)))

    def angle(self, u: Array, v: Array) -> float:
        """Angle between two changes (radians)."""
        return float(np.arccos(np.clip(self.product(u, v) / (self.length(u) * self.length(v)), -1.0, 1.0)))


@dataclass(frozen=True)
class OrbitPoint:
    """A `closed` orbit on a branch; `tangent` (n + 2,), the direction of the branch with length 1 in the branch's metric."""

    closed: Closed
    tangent: Array

    @property
    def unknowns(self) -> Array:
        """u = (x, T, p)."""
        return self.closed.unknowns

    @property
    def parameter(self) -> float:
        """p."""
        return self.closed.parameter

    @cached_property
    def multipliers(self) -> Complex:
        """Multipliers without the trivial one and those of idle modes, largest modulus first; none if `Flow.undecided`."""
        closed = self.closed
        return np.empty(0, dtype=complex) if closed.flow.undecided else floquet(closed.monodromy, closed.flow.idle)[0]

    @property
    def unstable(self) -> int:
        """Number of `multipliers` outside the unit circle."""
        return int((np.abs(self.multipliers) > 1.0).sum())

    def roughness(self, tolerance: float) -> float:
        """Highest coefficient over the allowed one (`Flow.roughness`): above 1 the mesh does not reach `tolerance`."""
        return self.closed.flow.roughness(self.closed.cycle, tolerance)


def point_near(flow_at: FlowAt, guess: Array, along: Array, metric: Metric, neighbour: OrbitPoint | None = None) -> OrbitPoint:
    """The point of the branch on the plane through `guess` that is orthogonal to `along`, oriented as `along`; the derivatives at
    a `neighbour` save time. Raises NumericsError if there is none."""
    *start, period, parameter = guess
    weights = metric.weights(len(start)) * along / metric.length(along)
    known = neighbour.closed if neighbour is not None else None
    closed = close_family(
        flow_at, np.array(start), float(period), float(parameter), weights, neighbour=known, unit=metric.parameter
    )
    return OrbitPoint(closed, direction(closed, along, metric))


def direction(closed: Closed, along: Array, metric: Metric) -> Array:
    """The branch's tangent at `closed`, oriented as `along`: the change of (x, T, p) that keeps the motion closed."""
    size = closed.velocity.size
    border = np.zeros((2, size + 2))
    border[0, :size] = closed.velocity
    border[1] = metric.weights(size) * along
    matrix = np.vstack([np.column_stack([closed.monodromy - np.eye(size), closed.velocity, closed.drift]), border])
    matrix[:, -1] *= metric.parameter  # units are not to make the matrix look singular
    matrix[size:] /= np.abs(matrix[size:]).max(axis=1, keepdims=True)
    try:
        with warnings.catch_warnings(action="error", category=scipy.linalg.LinAlgWarning):
            tangent = scipy.linalg.solve(matrix, np.append(np.zeros(size + 1), 1.0))
            tangent[-1] *= metric.parameter
    except (np.linalg.LinAlgError, scipy.linalg.LinAlgWarning):
        raise NumericsError("the branch has no unique direction here") from None
    return tangent / metric.length(tangent)


def on_finer_mesh(family: FlowFamily, point: OrbitPoint, metric: Metric, tolerance: float) -> tuple[FlowFamily, OrbitPoint]:
    """The family on a mesh that resolves the motion at `point` to `tolerance`, and the point on it. Raises NumericsError if no
    mesh does."""
    for _ in range(MOST_REFINEMENTS):
        closed, excess = point.closed, point.roughness(tolerance)
        finer = float(np.clip(_EXCESS * excess ** (1.0 / closed.flow.nodes.size), 1.0, _LARGEST_REFINEMENT))
        flow, state = closed.flow.remeshed(closed.cycle, finer)
        family = family.on(flow)
        along = np.concatenate([np.zeros(flow.size), point.tangent[-2:]])
        point = point_near(family, np.append(state, [closed.cycle.period, closed.parameter]), along, metric)
        if point.roughness(tolerance) <= 1.0:
            return family, point
    raise too_rough(point, tolerance)


def too_rough(point: OrbitPoint, tolerance: float) -> NumericsError:
    """Error for a branch that no mesh resolves beyond `point`."""
    return NumericsError(
        f"the branch ends at parameter = {point.parameter:.10g}: no mesh resolves the motion to {tolerance:g} (the highest "
        f"coefficient is {point.roughness(tolerance):.2g} times too large)"
    )
