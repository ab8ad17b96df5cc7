"""A point of a branch of periodic orbits, with the direction of the branch there."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from reduced.orbit.closing import Closed, close_family
from reduced.orbit.multipliers import Complex, floquet
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.step.flow import Flow

FlowAt = Callable[[float], Flow]


@dataclass(frozen=True)
class Metric:
    """Lengths on a branch: |u|^2 = |x|^2/n + (T/period)^2 + (p/parameter)^2 for changes u = (x, T, p) of the unknowns."""

    period: float
    parameter: float

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
class Point:
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
        """All multipliers but the trivial one and those of idle modes, largest modulus first (complex); none where they cannot be
        counted (`Flow.undecided`)."""
        closed = self.closed
        return np.empty(0, dtype=complex) if closed.flow.undecided else floquet(closed.monodromy, closed.flow.idle)[0]

    @property
    def unstable(self) -> int:
        """Number of `multipliers` outside the unit circle."""
        return int((np.abs(self.multipliers) > 1.0).sum())


def point_near(flow_at: FlowAt, guess: Array, along: Array, metric: Metric, neighbour: Point | None = None) -> Point:
    """The point of the branch on the plane through `guess` that is orthogonal to `along`, oriented as `along`; the derivatives at
    a `neighbour` save time.

    Raises NumericsError if there is none.
    """
    size = guess.size - 2
    weights = metric.weights(size) * along
    known = neighbour.closed if neighbour is not None else None
    at = (guess[:size], float(guess[size]), float(guess[size + 1]))
    closed = close_family(flow_at, *at, weights / metric.length(along), neighbour=known)
    return Point(closed, direction(closed, along, metric))


def direction(closed: Closed, along: Array, metric: Metric) -> Array:
    """The branch's tangent at `closed`, oriented as `along`: the change of (x, T, p) that keeps the motion closed."""
    size = closed.velocity.size
    border = np.zeros((2, size + 2))
    border[0, :size] = closed.velocity
    border[1] = metric.weights(size) * along
    border /= np.abs(border).max(axis=1, keepdims=True)  # the metric's unit is not to make the matrix look singular
    matrix = np.vstack([np.column_stack([closed.monodromy - np.eye(size), closed.velocity, closed.drift]), border])
    try:
        tangent = scipy.linalg.solve(matrix, np.append(np.zeros(size + 1), 1.0))
    except np.linalg.LinAlgError:
        raise NumericsError("the branch has no unique direction here") from None
    return np.asarray(tangent / metric.length(tangent))
