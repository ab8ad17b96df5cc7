"""Stability boundaries in any two parameters: pseudo-arclength continuation of D(i omega; p_1, p_2) = 0."""

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from reduced.stability.characteristic import Characteristic, characteristic
from reduced.stability.crossing import between
from reduced.stability.spectrum import leading_roots, unstable_count
from slipwave.errors import NumericsError, SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene

_LINES = (0.005, 0.125, 0.375, 0.625, 0.875, 0.995)  # of each scaled parameter, on which boundaries are searched
_STEP = 0.02  # of the rectangle's side
_ROUNDS = 12
_FAST = 0.1  # of the change before, at most, with an old matrix
_DIFFERENCE = 1e-6
_APART = 0.05  # of a step: distance in the scaled parameters of points there that are kept
_ASIDE = 1e-4  # distance in the scaled parameters from a boundary at which the other roots are counted
_UNCOUNTED = 8  # points of a curve between two counts, at most
_STILL = 1e-4  # change of the scaled parameters over that of ln omega, at most, where the frequency falls to 0


@dataclass(frozen=True)
class Boundary:
    """One curve on which a pair of roots is neutral, or a single root at s = 0: values of the `first` and `second` parameter,
    `omega` (1/(L/V*); 0 of a single root), and how many other roots are `growing` there: none where steady sliding loses its
    stability. `vanishing`: which of its ends (0, -1) are where the pair meets at s = 0."""

    first: Array
    second: Array
    omega: Array
    growing: Array
    vanishing: tuple[int, ...] = ()


def boundary(
    scene_at: Callable[[float, float], Scene],
    model: str,
    ranges: tuple[tuple[float, float], tuple[float, float]],
    single: bool = False,
) -> list[Boundary]:
    """The stability boundaries under `model` of the scenes at two parameters, found in the rectangle `ranges` of these: those of
    pairs of roots, with `single` also those of single roots, which cross at s = 0 where no face has a spring.

    A curve is found where the certified number of unstable roots changes along one of a few lines per parameter, two of which lie
    beside the edges, by which most curves leave. It is followed both ways until it leaves the rectangle, closes, comes to where
    there is no scene, or its frequency falls to 0: without a spring it ends where a single root crosses.
    """
    pairs = _Plane(scene_at, model, np.array(ranges, dtype=float))
    boundaries = list[Boundary]()
    for plane in (pairs, replace(pairs, is_single=True)) if single else (pairs,):
        curves: list[Array] = []
        for start in _seeds(plane):
            apart = (np.linalg.norm(curve[:, 1:] - start[1:], axis=1) + 0.2 * np.abs(curve[:, 0] - start[0]) for curve in curves)
            if all(distances.min() > 2.0 * _STEP for distances in apart):
                forward = _march(plane, start, 1.0)
                is_closed = len(forward) > 3 and np.linalg.norm(forward[-1] - start) < 1.5 * _STEP
                curves.append(np.array(forward if is_closed else _march(plane, start, -1.0)[:0:-1] + forward))
        for curve in curves:
            both = ((0, 1), (-1, -2)) if len(curve) > 1 else ()
            ends = tuple(end for end, inside in both if _falls(curve[end] - curve[inside], 2.0 * _STILL))
            kept = _thinned(curve) if ends else curve
            first, second = plane.values(kept[:, 1:]).T
            omega = np.zeros(len(kept)) if plane.is_single else np.exp(kept[:, 0])
            boundaries.append(Boundary(first, second, omega, _growing(plane, kept), ends))
    return boundaries


@dataclass(frozen=True)
class _Plane:
    """Unknowns x = (ln omega, u_1, u_2) with the parameters u scaled to [0, 1]; of a single root, whose omega is 0, x = (0, u_1,
    u_2)."""

    scene_at: Callable[[float, float], Scene]
    model: str
    ranges: Array
    is_single: bool = False

    def values(self, u: Array) -> Array:
        """The two parameters at the scaled point u of [0, 1]^2."""
        return self.ranges[:, 0] + u * (self.ranges[:, 1] - self.ranges[:, 0])

    def problem(self, u: Array) -> Characteristic:
        """Characteristic function of the scene with these parameters."""
        return characteristic(self.scene_at(*self.values(u).tolist()), self.model)

    def at_rest(self, u: Array) -> float:
        """The imbalance at s = 0, which is real."""
        return complex(self.problem(u).imbalance(0.0)).real

    def residual(self, x: Array) -> Array:
        """(Re, Im) of the imbalance at x = (ln omega, u); of a single root the first unknown, and the imbalance at s = 0."""
        if self.is_single:
            return np.array([x[0], self.at_rest(x[1:])])
        value = complex(self.problem(x[1:]).imbalance(1j * math.exp(x[0])))
        return np.array([value.real, value.imag])

    def corrected(self, x: Array, tangent: Array) -> Array | None:
        """Newton orthogonal to `tangent`; None if it does not converge or leads where there is no scene. The Jacobian,
        which costs six residuals, is recomputed only if the last change was not much smaller than the one before."""
        matrix, size = None, math.inf
        for _ in range(_ROUNDS):
            try:
                if matrix is None:
                    matrix = np.vstack([_central_differences(self.residual, x), tangent])
                change = np.linalg.solve(matrix, np.append(-self.residual(x), 0.0))
            except (np.linalg.LinAlgError, SceneError):
                return None
            before, size = size, float(np.linalg.norm(change))
            if not size <= 1.0:
                return None
            x = x + change
            falls = size < _FAST * before
            if size < 1e-11 and not (falls and size > 1e-15):  # as far as rounding lets it
                return x
            matrix = matrix if falls else None
        return None


def _seeds(plane: _Plane) -> list[Array]:
    """Points on the boundary: on lines across the rectangle, where the count of unstable roots, or for single roots the sign of
    the imbalance at s = 0, changes between samples."""
    points = []
    samples = np.linspace(0.0, 1.0, 41)
    for axis in (0, 1):
        for fixed in _LINES:
            at = [np.insert(np.array([fixed]), axis, moving) for moving in samples]
            values = [np.sign(plane.at_rest(u)) if plane.is_single else _count(plane.problem(u)) for u in at]
            for i in np.flatnonzero(np.diff(values)):
                fewer, more = (i, i + 1) if values[i] < values[i + 1] else (i + 1, i)
                points += _crossings(plane, at[fewer], at[more], int(values[more]))
    return points


def _count(problem: Characteristic) -> int:
    try:
        return unstable_count(problem)
    except NumericsError:  # a root on the contour: this differs from the neighbours' counts
        return -1


def _crossings(plane: _Plane, low: Array, high: Array, growing: int) -> list[Array]:
    """The point between `low` and `high` at which a single root crosses, or a pair of the `growing` roots of `high`; empty if
    none does."""
    from scipy.optimize import brentq

    if plane.is_single:
        share = brentq(lambda share: plane.at_rest(low + share * (high - low)), 0.0, 1.0, xtol=1e-13)
        return [np.array([0.0, *(low + share * (high - low))])]

    def problem(share: float) -> Characteristic:
        return plane.problem(low + share * (high - low))

    for root in leading_roots(problem(1.0), growing)[::-1]:  # the last is the most likely to have crossed last
        with contextlib.suppress(NumericsError):
            share, omega = between(problem, 0.0, 1.0, complex(root))
            if omega > 0.0:  # no single root, which crosses at s = 0
                return [np.concatenate([[math.log(omega)], low + share * (high - low)])]
    return []


def _growing(plane: _Plane, curve: Array) -> Array:
    """How many roots grow at each point of the curve beside those that are neutral there: counted at a few points, and at more
    where the number changes."""
    known = dict[int, int]()

    def fill(first: int, last: int) -> None:
        """All numbers from the point `first` to `last`."""
        for at in (first, last):
            if at not in known:
                known[at] = _least_count(plane, curve[at, 1:])
        if last - first <= _UNCOUNTED and known[first] == known[last]:
            known.update(dict.fromkeys(range(first + 1, last), known[first]))
        elif last - first > 1:
            fill(first, (first + last) // 2)
            fill((first + last) // 2, last)

    fill(0, len(curve) - 1)
    return np.array([known[at] for at in range(len(curve))])


def _least_count(plane: _Plane, u: Array) -> int:
    """The least number of roots that grow beside the point u of a boundary."""
    counts = list[int]()
    for aside in _ASIDE * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]):
        with contextlib.suppress(SceneError):  # beside the end of what a scene allows
            counts.append(_count(plane.problem(u + aside)))
    return min((count for count in counts if count >= 0), default=0)


def _thinned(curve: Array) -> Array:
    """The curve without most of the points where its frequency falls to 0 and the parameters hardly change."""
    kept = [curve[0]]
    for point in curve[1:-1]:
        if np.linalg.norm(point[1:] - kept[-1][1:]) > _APART * _STEP:
            kept.append(point)
    return np.array([*kept, curve[-1]])


def _march(plane: _Plane, start: Array, direction: float) -> list[Array]:
    """Points (ln omega, u_1, u_2) of the curve from `start` one way."""
    points, size = [start], _STEP
    tangent = direction * _tangent(_central_differences(plane.residual, start), None)
    while len(points) < 4000:
        trial = plane.corrected(points[-1] + size * tangent, tangent)
        if trial is None or np.linalg.norm(trial - points[-1]) > 3.0 * size:
            size *= 0.5
            if size < 1e-6 * _STEP:
                break
            continue
        points.append(trial)
        if np.any(trial[1:] < 0.0) or np.any(trial[1:] > 1.0):
            break
        if len(points) > 10 and np.linalg.norm(trial - start) < 0.75 * size:
            break
        try:
            tangent = _tangent(_central_differences(plane.residual, trial), tangent)
        except SceneError:  # at the end of what a scene allows
            break
        if _falls(tangent):
            break
        size = min(_STEP, 1.5 * size)
    return points


def _falls(step: Array, still: float = _STILL) -> bool:
    """Whether the frequency falls over a `step` in which the parameters hardly change."""
    return bool(np.linalg.norm(step[1:]) < -still * step[0])


def _tangent(jacobian: Array, before: Array | None) -> Array:
    """Null vector of the 2 x 3 Jacobian, in the direction of `before`."""
    vector = np.cross(jacobian[0], jacobian[1])
    vector = vector / np.linalg.norm(vector)
    return np.asarray(-vector if before is not None and vector @ before < 0.0 else vector)


def _central_differences(residual: Callable[[Array], Array], x: Array) -> Array:
    """The Jacobian of `residual` at x."""
    shifts = _DIFFERENCE * np.eye(x.size)
    return np.column_stack([(residual(x + d) - residual(x - d)) / (2.0 * _DIFFERENCE) for d in shifts])
