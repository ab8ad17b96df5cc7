"""Vector fitting, with passivity enforced by linear constraints.

Poles: the relocation of Gustavsen and Semlyen (1999), f(s) ~ sum c_k/(s - a_k) + d + h s, in real arithmetic; unstable poles are
reflected.
Residues: for fixed poles Re Z(i omega) is linear in the coefficients, so least squares under Re Z >= 0 on a grid is a quadratic
programme. It is solved as Lawson and Hanson's least distance problem by non-negative least squares.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from reduced.impedance.transmission_line import Complex
from slipwave.observe.pieces import Array

_REAL_POLE = 1e-9
_AT_REST = 1e-6
_ROUNDS = 12


def partial_fractions(s: Complex, pairs: Complex, reals: Array) -> Complex:
    """Columns 1/(s - a) for real poles, then (s, 1)/(s^2 + 2 g s + w^2) for every pair: real coefficients span all residues."""
    bottom = s[:, None] ** 2 - 2.0 * pairs.real * s[:, None] + np.abs(pairs) ** 2
    return np.column_stack([1.0 / (s[:, None] - reals), s[:, None] / bottom, 1.0 / bottom])


def _stack(rows: NDArray[Any]) -> Array:
    return np.concatenate([rows.real, rows.imag])


def _companion(pairs: Complex, reals: Array, sigma: Array) -> Array:
    """A - b c~^T, whose eigenvalues are the zeros of sigma; a pair is the block [[2 g, -w^2], [1, 0]], with b = (1, 0)."""
    n, m = reals.size, pairs.size
    matrix = np.zeros((n + 2 * m, n + 2 * m))
    matrix[range(n), range(n)] = reals
    drive = np.zeros(n + 2 * m)
    drive[: n + m] = 1.0
    first, second = np.arange(n, n + m), np.arange(n + m, n + 2 * m)
    matrix[first, first] = 2.0 * pairs.real
    matrix[first, second] = -(np.abs(pairs) ** 2)
    matrix[second, first] = 1.0
    return matrix - np.outer(drive, sigma)


def fit_poles(s: Complex, values: Complex, weight: Array, pairs: Complex, reals: Array) -> tuple[Complex, Array]:
    """One of each conjugate pair, and the real poles, after a few steps of vector fitting from the given start, until they no
    longer change. In a step the poles become the zeros of the fitted sigma(s) = 1 + sum c~_k/(s - a_k)."""
    for _ in range(_ROUNDS):
        before = np.sort_complex(np.concatenate([pairs, reals]))
        basis = partial_fractions(s, pairs, reals)
        rows = np.column_stack([basis, np.ones_like(s), s, -values[:, None] * basis]) * weight[:, None]
        matrix = _stack(rows)
        scale = np.linalg.norm(matrix, axis=0)
        coefficients = np.linalg.lstsq(matrix / scale, _stack(np.asarray(values * weight)), rcond=None)[0] / scale
        new = np.linalg.eigvals(_companion(pairs, reals, coefficients[basis.shape[1] + 2 :]))
        poles = -np.abs(new.real) + 1j * new.imag
        real = np.abs(poles.imag) <= _REAL_POLE * np.abs(poles)
        pairs, reals = poles[(poles.imag > 0.0) & ~real], poles[real].real
        after = np.sort_complex(np.concatenate([pairs, reals]))
        if after.shape == before.shape and np.all(np.abs(after - before) < _AT_REST * np.abs(after)):
            break
    return pairs, reals


def passive_coefficients(matrix: Array, right: Array, constraints: Array, floors: Array) -> Array:
    """x that minimises |matrix x - right| under constraints x >= floors.

    With matrix = Q R and z = R x - Q^T right this is the least distance problem min |z|, G z >= h. Its solution follows from the
    residual of non-negative least squares (Lawson and Hanson, chapter 23). Raises ArithmeticError if no x satisfies
    them, and for rows that are not finite.
    """
    from scipy.linalg import solve_triangular
    from scipy.optimize import nnls

    if not (np.isfinite(matrix).all() and np.isfinite(constraints).all()):
        raise ArithmeticError("one is undamped, at a frequency that is fitted")
    scale = np.linalg.norm(matrix, axis=0)
    q, r = np.linalg.qr(matrix / scale)
    free = q.T @ right
    g = solve_triangular(r, (constraints / scale).T, trans="T").T
    h = floors - g @ free
    size = np.maximum(np.linalg.norm(g, axis=1), 1e-300)
    g, h = g / size[:, None], h / size
    if np.all(h <= 0.0):
        return np.asarray(solve_triangular(r, free) / scale)
    stretch = np.abs(h).max()
    dual, _ = nnls(np.vstack([g.T, h / stretch]), np.append(np.zeros(g.shape[1]), 1.0), maxiter=100 * len(h))
    residual = np.vstack([g.T, h / stretch]) @ dual - np.append(np.zeros(g.shape[1]), 1.0)
    if abs(residual[-1]) < 1e-14:
        raise ArithmeticError("no coefficients satisfy the constraints")
    z = -residual[:-1] / residual[-1] * stretch
    return np.asarray(solve_triangular(r, free + z) / scale)
