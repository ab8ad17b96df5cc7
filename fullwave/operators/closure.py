"""The end rows of summation-by-parts differences, computed from their accuracy conditions.

H and Q are computed together, not copied from a table. The conditions are Q p = H p' for all polynomials p of degree 2m - 1 or
less, linear in both. D = H^-1 Q is then of order 2m - 1 in the end rows, and the solution keeps the order 2m of the interior.
This requires a full norm matrix for the 2m + 1 end nodes. The end node itself is coupled to no other in H (Strand's restricted
full norm), so that a penalty acts on one node. The conditions leave three entries free for order 4 and four for order 6; these
are chosen to minimise the residual Q p - H p' of degree 2m (sum of squares). Order 2 needs one row: the trapezoidal rule. Strand,
J. Comput. Phys. 110 (1994); Carpenter, Nordstrom and Gottlieb, J. Comput. Phys. 148 (1999).

The conditions depend on each other (rank 18 of 20, 39 of 42), so they are solved by least squares. The true singular values lie
above 3e-4 of the largest; the others are rounding. H is positive definite; rounding changes its entries by some 1e-11 at order 6,
but Q stays skew and the conditions hold to rounding (tests/fullwave/test_operators.py).
"""

from functools import cache
from typing import TypeAlias

import numpy as np
from numpy.polynomial import Legendre
from numpy.typing import NDArray

from slipwave.observe.pieces import Array

_Pairs: TypeAlias = tuple[NDArray[np.intp], NDArray[np.intp]]
"""Index pairs (i, j) of the unknown entries: i <= j in H, i < j in Q."""

_DEPENDENT = 1e-12  # singular values below this share of the largest belong to conditions that follow from others


def central_coefficients(order: int) -> Array:
    """c_k of u'(0) = sum c_k (u_k - u_-k), k = 1..3 (zero beyond order/2), h = 1: exact for x, x^3, .., x^(order - 1)."""
    half = order // 2
    powers = 2 * np.arange(half) + 1
    offsets = np.arange(1, half + 1)
    known = np.zeros(half)
    known[0] = 0.5
    return np.concatenate((np.linalg.solve(offsets[None, :] ** powers[:, None].astype(float), known), np.zeros(3 - half)))


def closure_rows(order: int) -> int:
    """Number of nodes at each end whose rows differ from those of the interior."""
    return 1 if order == 2 else order + 1


@cache
def boundary_closure(order: int) -> tuple[Array, Array]:
    """(H, D) near an end, h = 1: norm (rows, rows) of the end nodes, and their rows of D, shape (rows, rows + order/2)."""
    rows = closure_rows(order)
    upper = np.triu_indices(rows)
    alone = (upper[0] > 0) | (upper[1] == 0)
    of_norm, of_skew = (upper[0][alone], upper[1][alone]), np.triu_indices(rows, 1)
    exact = [_condition(order, of_norm, of_skew, degree) for degree in range(order)]
    matrix, known = (np.concatenate(parts) for parts in zip(*exact, strict=True))
    solution, _, rank, _ = np.linalg.lstsq(matrix, known, rcond=_DEPENDENT)
    free = np.linalg.svd(matrix)[2][rank:].T
    beyond, wanted = _condition(order, of_norm, of_skew, order)
    solution = solution + free @ np.linalg.lstsq(beyond @ free, wanted - beyond @ solution, rcond=None)[0]
    norm, skew = np.zeros((rows, rows)), np.zeros((rows, rows))
    count = of_norm[0].size
    norm[of_norm] = norm.T[of_norm] = solution[:count]
    skew[of_skew] = solution[count:]
    skew -= skew.T
    skew[0, 0] = -0.5
    closure = np.linalg.solve(norm, np.hstack((skew, _known_part(order, rows))))
    return norm, np.asarray(closure, dtype=np.float64)


def _known_part(order: int, rows: int) -> Array:
    """The part of Q that couples the end rows to the interior; it follows from skew symmetry."""
    central = central_coefficients(order)
    part = np.zeros((rows, order // 2))
    for i in range(rows):
        for j in range(order // 2):
            if 0 < rows + j - i <= order // 2:
                part[i, j] = central[rows + j - i - 1]
    return part


def _condition(order: int, of_norm: _Pairs, of_skew: _Pairs, degree: int) -> tuple[Array, Array]:
    """The linear system, one row per end node, that makes D exact for a polynomial of `degree`; columns: entries of H, then of Q.

    It uses Legendre polynomials over these nodes; powers of x would be equivalent but twenty times more sensitive to rounding."""
    rows = closure_rows(order)
    points = np.arange(rows + order // 2, dtype=float)
    polynomial = Legendre.basis(degree, domain=[points[0], points[-1]])
    values, slopes = polynomial(points), polynomial.deriv()(points)
    count, columns = of_norm[0].size, np.arange(of_norm[0].size + of_skew[0].size)
    matrix = np.zeros((rows, columns.size))
    i, j = of_norm
    matrix[j, columns[:count]] = -slopes[i]
    matrix[i, columns[:count]] = -slopes[j]
    i, j = of_skew
    matrix[i, columns[count:]] = values[j]
    matrix[j, columns[count:]] = -values[i]
    known = -_known_part(order, rows) @ values[rows:]
    known[0] += 0.5 * values[0]
    return matrix, known
