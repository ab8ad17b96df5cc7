"""The end rows of the differences: the same problem solved in rational arithmetic, and what the floating-point solution keeps."""

from fractions import Fraction

import numpy as np
import pytest

from fullwave.operators import closure as module
from fullwave.operators.closure import boundary_closure, closure_rows

CENTRAL = {4: (Fraction(2, 3), Fraction(-1, 12)), 6: (Fraction(3, 4), Fraction(-3, 20), Fraction(1, 60))}


def reduced(matrix):
    """Reduced row echelon form of rows of Fractions, and its pivots' columns."""
    rows, pivots = [row[:] for row in matrix], []
    for column in range(len(rows[0])):
        here = len(pivots)
        chosen = next((i for i in range(here, len(rows)) if rows[i][column]), None)
        if chosen is None:
            continue
        rows[here], rows[chosen] = rows[chosen], rows[here]
        rows[here] = [value / rows[here][column] for value in rows[here]]
        for i, row in enumerate(rows):
            if i != here and row[column]:
                rows[i] = [a - row[column] * b for a, b in zip(row, rows[here], strict=True)]
        pivots.append(column)
    return rows[: len(pivots)], pivots


def pairs(order):
    """Entries (i, j) of the unknowns of H, then of Q, in the module's order."""
    unknowns = module._unknowns(closure_rows(order))
    return [[(int(i), int(j)) for i, j in zip(*which, strict=True)] for which in unknowns]


def conditions(order, degree):
    """Rows (matrix | known) that ask Q x^degree = degree H x^(degree - 1), in powers of the node's number."""
    rows, (norm, skew) = closure_rows(order), pairs(order)
    x = [Fraction(i) for i in range(rows + order // 2)]
    slope = [degree * at ** (degree - 1) if degree else Fraction(0) for at in x]
    system = [[Fraction(0)] * (len(norm) + len(skew) + 1) for _ in range(rows)]
    for k, (i, j) in enumerate(norm):
        system[i][k] -= slope[j]
        if i != j:
            system[j][k] -= slope[i]
    for k, (i, j) in enumerate(skew, len(norm)):
        system[i][k] += x[j] ** degree
        system[j][k] -= x[i] ** degree
    system[0][-1] += x[0] ** degree / 2
    for i in range(rows):
        for k, coefficient in enumerate(CENTRAL[order], 1):
            if i + k >= rows:
                system[i][-1] -= coefficient * x[i + k] ** degree
    return system


def exact_closure(order):
    """(H, D) of the end rows in Fractions, ranks and all."""
    exact, pivots = reduced([row for degree in range(order) for row in conditions(order, degree)])
    count = len(exact[0]) - 1
    assert count not in pivots
    free = [column for column in range(count) if column not in pivots]
    particular, null = [Fraction(0)] * count, [[Fraction(int(k == column)) for k in range(count)] for column in free]
    for row, pivot in zip(exact, pivots, strict=True):
        particular[pivot] = row[-1]
        for column, vector in zip(free, null, strict=True):
            vector[pivot] = -row[column]
    beyond = conditions(order, order)
    effect = [[sum(a * b for a, b in zip(row, vector, strict=False)) for vector in null] for row in beyond]
    left = [row[-1] - sum(a * b for a, b in zip(row, particular, strict=False)) for row in beyond]
    normal = [
        [sum(row[a] * row[b] for row in effect) for b in range(len(free))]
        + [sum(row[a] * rest for row, rest in zip(effect, left, strict=True))]
        for a in range(len(free))
    ]
    chosen, determined = reduced(normal)
    assert determined == list(range(len(free)))  # the least residual is taken in one place only
    solution = [
        value + sum(row[-1] * vector[k] for row, vector in zip(chosen, null, strict=True)) for k, value in enumerate(particular)
    ]
    return _matrices(order, solution), len(pivots)


def _matrices(order, solution):
    rows, (norm_pairs, skew_pairs) = closure_rows(order), pairs(order)
    norm, q = ([[Fraction(0)] * width for _ in range(rows)] for width in (rows, rows + order // 2))
    for value, (i, j) in zip(solution, norm_pairs, strict=False):
        norm[i][j] = norm[j][i] = value
    for value, (i, j) in zip(solution[len(norm_pairs) :], skew_pairs, strict=True):
        q[i][j], q[j][i] = value, -value
    q[0][0] = Fraction(-1, 2)
    for i in range(rows):
        for k, coefficient in enumerate(CENTRAL[order], 1):
            if i + k >= rows:
                q[i][i + k] = coefficient
    closure, _ = reduced([left + right for left, right in zip(norm, q, strict=True)])
    return norm, [row[rows:] for row in closure]


@pytest.mark.parametrize(("order", "rank", "first"), [(4, 18, Fraction(2839, 13230)), (6, 39, Fraction(1581317, 11215260))])
def test_closure_is_that_of_rational_arithmetic(order, rank, first):
    (norm, rows), found_rank = exact_closure(order)
    assert (found_rank, norm[0][0]) == (rank, first)
    found_norm, found_rows = boundary_closure(order)
    np.testing.assert_allclose(found_norm, np.array(norm, dtype=float), rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(found_rows, np.array(rows, dtype=float), rtol=0.0, atol=1e-10)
