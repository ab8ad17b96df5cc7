"""What each family's operator must satisfy: accuracy, summation by parts, the elements of scikit-fem."""

import numpy as np
import pytest

from fullwave.finite_element import assemble_layer
from fullwave.operators.closure import boundary_closure, closure_rows
from fullwave.summation_by_parts import difference_matrix


@pytest.mark.parametrize("order", [2, 4, 6])
def test_differences_are_exact_to_their_order(order):
    """x^k for k < order everywhere (order 2: k <= 1), for k <= order inside."""
    matrix, _ = difference_matrix(order, 24)
    x = np.linspace(0.0, 1.0, 25)
    rows = closure_rows(order)
    for k in range(order + 1):
        error = np.abs(matrix @ x**k - k * x ** max(k - 1, 0))
        assert error[rows:-rows].max() < 1e-11
        if k < order:
            assert error.max() < 2e-11
        else:
            assert error.max() > 1e-6  # the ends are one order lower


@pytest.mark.parametrize("order", [2, 4, 6])
def test_differences_sum_by_parts(order):
    matrix, norm = difference_matrix(order, 30)
    q = norm @ matrix
    ends = np.zeros_like(q)
    ends[0, 0], ends[-1, -1] = -1.0, 1.0
    np.testing.assert_allclose(q + q.T, ends, atol=1e-11)
    dense = norm.toarray()
    np.testing.assert_array_equal(dense, dense.T)
    assert np.linalg.eigvalsh(dense).min() > 0.0
    assert dense.sum() == pytest.approx(1.0, rel=1e-12)
    assert not dense[0, 1:].any()  # a penalty acts on the end node alone


@pytest.mark.parametrize(("order", "first"), [(4, 2839 / 13230), (6, 1581317 / 11215260)])
def test_free_entries_of_the_norm_are_those_of_least_residual(order, first):
    """The first one, as rational arithmetic gives it."""
    assert boundary_closure(order)[0][0, 0] == pytest.approx(first, abs=1e-10)


@pytest.mark.parametrize("degree", [1, 2, 3, 7, 12])
def test_elements_sum_by_parts(degree):
    depth, mass, slope = assemble_layer(3, degree)
    assert (np.diff(depth) > 0.0).all()
    ends = np.zeros(slope.shape)
    ends[0, 0], ends[-1, -1] = -1.0, 1.0
    np.testing.assert_allclose((slope + slope.T).toarray(), ends, atol=1e-12)
    derivative = slope.toarray() / mass[:, None]
    for k in range(degree):
        np.testing.assert_allclose(derivative @ depth**k, k * depth ** max(k - 1, 0), atol=1e-9)
