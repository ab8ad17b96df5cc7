"""The declared orders of discontinuous Galerkin, finite elements and summation by parts in the fields, against an exact standing
wave. Interface outputs: test_interface_order.
"""

from functools import partial

import numpy as np
import pytest
from exact_waves import standing_error
from order import assert_order

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.families import ELEMENTS, GALERKIN
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts

CELLS = {
    1: (48, 64, 96, 128, 192),
    2: (32, 48, 64, 96, 128),
    3: (16, 24, 32, 48, 64),
    4: (12, 16, 24, 32, 48),
    5: (8, 12, 16, 24, 32),
    6: (6, 8, 12, 16, 24),
    7: (6, 8, 12, 16, 20),
}
FINEST = {1: 2e-2, 2: 2e-3, 3: 5e-5, 4: 2e-6, 5: 1e-7, 6: 3e-8, 7: 5e-10}


def require_order(kind, number, cells, order, tolerance=0.1, **given):
    """Of the fields of a `kind` of grid; `given` to `assert_order`."""
    errors = [standing_error(partial(kind, number=number, cells=n, time="explicit")) for n in cells]
    assert_order(errors, 1 / np.array(cells), order, tolerance, **given)


@pytest.mark.parametrize("degree", CELLS)
def test_discontinuous_fields_are_of_order_degree_plus_one(degree):
    require_order(DiscontinuousGalerkin, degree, CELLS[degree], GALERKIN.order_bulk(degree), 0.15, absolute=FINEST[degree])


@pytest.mark.parametrize("degree", CELLS)
def test_element_fields_are_of_the_odd_order(degree):
    """degree + 1 for odd degrees, degree for even ones: Galerkin for a first-order pair, measured and declared."""
    require_order(FiniteElement, degree, CELLS[degree], ELEMENTS.order_bulk(degree), absolute=FINEST[degree], at_least=True)


@pytest.mark.parametrize(
    ("order", "cells", "finest"),
    [(2, (48, 64, 96, 128), 2e-2), (4, (64, 96, 128, 192), 1e-5), (6, (64, 96, 128, 192, 256), 1e-8)],
)
def test_difference_fields_are_of_the_order_inside(order, cells, finest):
    require_order(SummationByParts, order, cells, order, absolute=finest, at_least=True)
