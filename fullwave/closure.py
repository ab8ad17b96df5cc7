"""The end rows of summation-by-parts differences, from their accuracy conditions.

They are not copied from a table but solved for: H and Q together from the conditions Q x^k = k H x^(k-1), k = 0..m, linear in
both. What they leave free at order 2m = 6 (one number) makes the error of x^(m+1) least. The norms are those of Strand (1994).
"""

from functools import cache

import numpy as np

from scene.observe.pieces import Array


def central_coefficients(order: int) -> Array:
    """c_k of u'(0) = sum c_k (u_k - u_-k), k = 1..3 (zero beyond order/2), h = 1."""
    half = order // 2
    powers = 2 * np.arange(half) + 1
    offsets = np.arange(1, half + 1)
    known = np.zeros(half)
    known[0] = 0.5
    return np.concatenate((np.linalg.solve(offsets[None, :] ** powers[:, None].astype(float), known), np.zeros(3 - half)))


@cache
def boundary_closure(order: int) -> tuple[Array, Array]:
    """(H, D) near an end, h = 1: norm of the first `rows` nodes, and those rows of D, shape (rows, rows + order/2)."""
    rows = 1 if order == 2 else order
    unknowns, matrix, known = _accuracy_conditions(order, rows)
    found, _, rank, _ = np.linalg.lstsq(matrix, known, rcond=1e-11)
    solution: Array = np.asarray(found, dtype=np.float64)
    free = np.linalg.svd(matrix)[2][rank:].T
    if free.size:
        _, beyond, wanted = _accuracy_conditions(order, rows, (order // 2 + 1,))
        solution += free @ np.linalg.lstsq(beyond @ free, wanted - beyond @ solution, rcond=None)[0]
    norm: Array = solution[:rows]
    skew = np.zeros((rows, rows))
    for value, (i, j) in zip(solution[rows:], unknowns, strict=True):
        skew[i, j], skew[j, i] = value, -value
    skew[0, 0] = -0.5
    closure: Array = np.hstack((skew, _known_part(order, rows))) / norm[:, None]
    return norm, closure


def _known_part(order: int, rows: int) -> Array:
    """The part of Q that couples the end rows to the interior: its skew symmetry fixes it."""
    central = central_coefficients(order)
    part = np.zeros((rows, order // 2))
    for i in range(rows):
        for j in range(order // 2):
            if 0 < rows + j - i <= order // 2:
                part[i, j] = central[rows + j - i - 1]
    return part


def _accuracy_conditions(
    order: int, rows: int, degrees: tuple[int, ...] | None = None
) -> tuple[list[tuple[int, int]], Array, Array]:
    """Pairs (i, j) of the unknown q_ij, and the linear system in (h_0.., q_ij) that makes D exact for x^k, k in `degrees`."""
    pairs = [(i, j) for i in range(rows) for j in range(i + 1, rows)]
    points = np.arange(rows + order // 2, dtype=float)
    known_part = _known_part(order, rows)
    equations, right = [], []
    for degree in range(order // 2 + 1) if degrees is None else degrees:
        powers = points**degree
        slope = degree * points ** max(degree - 1, 0)
        for i in range(rows):
            row = np.zeros(rows + len(pairs))
            row[i] = -slope[i]
            for q, (a, b) in enumerate(pairs):
                row[rows + q] = powers[b] * (a == i) - powers[a] * (b == i)
            equations.append(row)
            right.append(-float(known_part[i] @ powers[rows:]) + 0.5 * powers[0] * (i == 0))
    return pairs, np.array(equations), np.array(right)
