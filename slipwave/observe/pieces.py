"""The output of every solver: consecutive polynomial pieces of the interface's motion, on the transit clock.

Piece k covers (time[k], time[k] + length[k]] and holds values at time[k] + nodes * length[k]. Observers receive nothing else from
a solver, so one event detector works for collocation (Radau nodes) and for grids (groups of equispaced steps).

Where a piece begins later than the one before it ends, there is a gap: the motion was not computed there (`Leaping`). Only
observers that say so (`slipwave.solve.Spanning`) are given pieces with gaps.
"""

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

Array = NDArray[np.float64]

SAME = 1e-9
"""Transits; two times that differ by less are equal."""


@register_jitable  # type: ignore[untyped-decorator]
def slack(time: float) -> float:
    """As `SAME`, or, late in a run, a few roundings of `time` (transits), if that is more."""
    return max(SAME, 4e-16 * abs(time))


class Pieces(NamedTuple):
    """m pieces with n values each: time, length (m,); the others (m, n). A quantity of degree n - 1 is represented exactly.

    `z` is the law's rate unknown (usually ln v), `psi` the state, `mu` the friction stress, `y` the elastic stress, where
    y' = stiffness (V - v) on the t~ clock.
    """

    time: Array
    length: Array
    z: Array
    psi: Array
    mu: Array
    y: Array

    def part(self, which: slice | NDArray[np.bool_]) -> "Pieces":
        """Some of them."""
        return Pieces(*(values[which] for values in self))

    @staticmethod
    def joined(parts: "Iterable[Pieces]") -> "Pieces":
        """Those of all `parts`, at least one, in order."""
        return Pieces(*map(np.concatenate, zip(*parts, strict=True)))


def empty_pieces(count: int, nodes: int) -> Pieces:
    """Uninitialised arrays for `count` pieces of `nodes` values each."""
    return Pieces(np.empty(count), np.empty(count), *(np.empty((count, nodes)) for _ in range(4)))


class Basis(NamedTuple):
    """Lagrange basis on the pieces' nodes in [0, 1]: barycentric weights and the matrix that differentiates nodal values."""

    nodes: Array
    weights: Array
    derivative: Array


def lagrange_basis(nodes: Array) -> Basis:
    """Barycentric weights and differentiation matrix of `nodes` (Berrut and Trefethen 2004); computed once for the same nodes."""
    return _basis(tuple(np.asarray(nodes, dtype=float).tolist()))


@lru_cache(maxsize=64)
def _basis(points: tuple[float, ...]) -> Basis:
    nodes = np.array(points)
    gaps = nodes[:, None] - nodes[None, :]
    np.fill_diagonal(gaps, 1.0)
    weights = barycentric_weights(nodes)
    derivative = weights[None, :] / weights[:, None] / gaps
    np.fill_diagonal(derivative, 0.0)
    np.fill_diagonal(derivative, -derivative.sum(axis=1))
    return Basis(nodes, weights, derivative)


def barycentric_weights(nodes: Array) -> Array:
    """Barycentric weights (n,) of distinct `nodes` (n,)."""
    gaps = nodes[:, None] - nodes
    np.fill_diagonal(gaps, 1.0)
    return np.asarray(1.0 / gaps.prod(axis=1))


def interpolation_matrix(basis: Basis, points: Array) -> Array:
    """Rows that evaluate the interpolating polynomial at `points` of [0, 1] from values at the nodes."""
    gaps = np.asarray(points, dtype=float)[:, None] - basis.nodes
    at_node = gaps == 0.0
    if at_node.any():
        terms = np.where(at_node.any(axis=1, keepdims=True), at_node, basis.weights / np.where(at_node, 1.0, gaps))
    else:
        terms = basis.weights / gaps
    return np.asarray(terms / terms.sum(axis=1, keepdims=True))
