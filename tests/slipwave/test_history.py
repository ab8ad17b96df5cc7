"""Values between the nodes of pieces."""

import numpy as np
import pytest

from slipwave.observe.history import evaluated
from slipwave.observe.pieces import interpolation_matrix, lagrange_basis
from slipwave.step.collocation import radau


@pytest.mark.parametrize("rows", [1, 9], ids=["points of one piece", "a point of each piece"])
def test_compiled_values_are_those_in_plain_numpy(rows):
    """Also at a node. The third column is s^7, of the highest degree that 8 nodes represent. Measured: 5e-16."""
    basis, points = lagrange_basis(radau(8).nodes), np.linspace(0.02, 1.0, 9)
    columns = np.random.default_rng(1).normal(size=(4, rows, 8))
    columns[2] = basis.nodes**7
    weights = interpolation_matrix(basis, points)
    found = evaluated(columns, basis, points, None)
    for values, column in zip(found, columns, strict=True):
        assert values == pytest.approx((weights * column).sum(axis=1), abs=1e-14)
    assert found[2] == pytest.approx(points**7, abs=1e-14)
    assert found[0][-1] == columns[0, -1, -1]
