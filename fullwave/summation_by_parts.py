"""Finite differences with the summation-by-parts property: order 2, 4 or 6 inside, characteristic penalties at the ends.

D = H^-1 Q with Q + Q^T = diag(-1, 0, ..., 0, 1), so that the discrete energy, of norm H, changes through the ends only. Inside, D
is the central difference of order 2m. Near each end 2m + 1 rows (one for order 2) have order 2m - 1, but the solution is of order
2m up to the ends. A diagonal H would be simpler, but would reduce orders 4 and 6 by one and two in the fields (measured 3.2 and
4.1). It is not needed, because media are uniform within a block. Strand, J. Comput. Phys. 110 (1994); penalties in characteristic
variables: Kozdon, Dunham and Nordstrom, J. Sci. Comput. 50 (2012).

A layer is one block; two layers are coupled through upwind states, as are slab and interface. Energy never grows, because the
penalties dissipate.

The end rows: H and Q are computed together, not copied from a table. The conditions are Q p = H p' for all polynomials p of
degree 2m - 1 or less, linear in both. D = H^-1 Q is then of order 2m - 1 in the end rows, and the solution keeps the order 2m of
the interior. This requires a full norm matrix for the 2m + 1 end nodes. The end node itself is coupled to no other in H (Strand's
restricted full norm), so that a penalty acts on one node. The conditions leave three entries free for order 4 and four for order
6; these are chosen to minimise the residual Q p - H p' of degree 2m (sum of squares). Order 2 needs one row: the trapezoidal
rule. Strand, J. Comput. Phys. 110 (1994); Carpenter, Nordstrom and Gottlieb, J. Comput. Phys. 148 (1999).

The conditions depend on each other (rank 18 of 20, 39 of 42), so they are solved by least squares. The true singular values lie
above 3e-4 of the largest; the others are rounding. H is positive definite; rounding changes its entries by some 1e-11 at order 6,
but Q stays skew and the conditions hold to rounding (tests/fullwave/test_operators.py).
"""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np
import scipy.sparse
from numpy.polynomial import Legendre
from numpy.typing import NDArray

from fullwave.families import BY_PARTS
from fullwave.lines.blocks import Block, BlockGrid, Section, padded_half
from fullwave.lines.march import MethodOfLines
from fullwave.lines.system import apply
from slipwave.observe.pieces import Array

_Pairs: TypeAlias = tuple[NDArray[np.intp], NDArray[np.intp]]
"""Index pairs (i, j) of the unknown entries: i <= j in H, i < j in Q."""

_DEPENDENT = 1e-12  # singular values below this share of the largest belong to conditions that follow from others

_SAMPLE_CELLS = 56  # of the longest line from which a step limit is computed; twice as many cells lower it by 0.2 per cent


def _central_coefficients(order: int) -> Array:
    """c_k of u'(0) = sum c_k (u_k - u_-k), k = 1..3 (zero beyond order/2), h = 1: exact for x, x^3, .., x^(order - 1)."""
    half = order // 2
    powers = 2 * np.arange(half) + 1
    offsets = np.arange(1, half + 1)
    known = np.zeros(half)
    known[0] = 0.5
    return np.concatenate((np.linalg.solve(offsets[None, :] ** powers[:, None].astype(float), known), np.zeros(3 - half)))


@cache
def _boundary_closure(order: int) -> tuple[Array, Array]:
    """(H, D) near an end, h = 1: norm (rows, rows) of the end nodes, and their rows of D, shape (rows, rows + order/2)."""
    rows = 1 if order == 2 else order + 1
    upper = np.triu_indices(rows)
    alone = (upper[0] > 0) | (upper[1] == 0)
    of_norm, of_skew = (upper[0][alone], upper[1][alone]), np.triu_indices(rows, 1)
    exact = [_condition(order, rows, of_norm, of_skew, degree) for degree in range(order)]
    matrix, known = (np.concatenate(parts) for parts in zip(*exact, strict=True))
    solution, _, rank, _ = np.linalg.lstsq(matrix, known, rcond=_DEPENDENT)
    free = np.linalg.svd(matrix)[2][rank:].T
    beyond, wanted = _condition(order, rows, of_norm, of_skew, order)
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
    central = _central_coefficients(order)
    part = np.zeros((rows, order // 2))
    for i in range(rows):
        for j in range(order // 2):
            if 0 < rows + j - i <= order // 2:
                part[i, j] = central[rows + j - i - 1]
    return part


def _condition(order: int, rows: int, of_norm: _Pairs, of_skew: _Pairs, degree: int) -> tuple[Array, Array]:
    """The linear system, one row per end node, that makes D exact for a polynomial of `degree`; columns: entries of H, then of Q.

    It uses Legendre polynomials over these nodes; powers of x would be equivalent but twenty times more sensitive to rounding."""
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


class _Differences(NamedTuple):
    """`first` (blocks + 1,): node at which each block begins; `scale` 1/h per block; central coefficients (3,); end rows (rows,
    columns) of D at h = 1. The slot of w at node i is i, that of s is `half` + i."""

    first: NDArray[np.int64]
    scale: Array
    central: Array
    closure: Array
    half: int


@apply.register(_Differences)
def _apply(operator, state, rates, at):  # type: ignore[no-untyped-def]
    firsts, scales, central, closure = operator.first, operator.scale, operator.central, operator.closure
    rows, columns = closure.shape
    half = operator.half
    for block in range(scales.size):
        scale = scales[block]
        c1, c2, c3 = scale * central[0], scale * central[1], scale * central[2]
        for source, target in ((0, at + half), (half, at)):
            begin, end = source + firsts[block], source + firsts[block + 1]
            shift = target - source
            for i in range(begin + rows, end - rows):
                rates[i + shift] = c1 * (state[i + 1] - state[i - 1])
            if c2 != 0.0:
                for i in range(begin + rows, end - rows):
                    rates[i + shift] += c2 * (state[i + 2] - state[i - 2])
            if c3 != 0.0:
                for i in range(begin + rows, end - rows):
                    rates[i + shift] += c3 * (state[i + 3] - state[i - 3])
            for i in range(rows):
                near = far = 0.0
                for j in range(columns):
                    near += closure[i, j] * state[begin + j]
                    far -= closure[i, j] * state[end - 1 - j]
                rates[begin + i + shift] = scale * near
                rates[end - 1 - i + shift] = scale * far


class SummationByParts(MethodOfLines):
    """`scene` by differences whose order is the number: 2, 4 or 6."""

    family = BY_PARTS
    most_sampled = _SAMPLE_CELLS

    @property
    def fewest(self) -> int:
        """As `MethodOfLines`: with fewer the rows of both ends would overlap."""
        return sum(_boundary_closure(self.number)[1].shape) - 1

    def grid_of(self, sections: Sequence[Section]) -> BlockGrid:
        """As `MethodOfLines`."""
        norm, closure = _boundary_closure(self.number)
        first = np.cumsum([0] + [section.cells + 1 for section in sections])
        half = padded_half(int(first[-1]))
        blocks = []
        for start, section in zip(first, sections, strict=False):
            h = section.length / section.cells
            slots = start + np.arange(section.cells + 1)
            lift = 1.0 / (h * norm[0, 0])
            depth = section.start + h * (slots - start)
            inside = scipy.sparse.eye_array(section.cells + 1 - 2 * norm.shape[0])
            weights = h * scipy.sparse.block_diag((norm, inside, norm[::-1, ::-1]), format="csr")
            blocks.append(Block(section, slots, half + slots, depth, weights, (lift, lift)))
        scale = np.array([section.cells / section.length for section in sections])
        return BlockGrid(_Differences(first, scale, _central_coefficients(self.number), closure, half), 2 * half, tuple(blocks))
