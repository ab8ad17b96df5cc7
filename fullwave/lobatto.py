"""Gauss-Lobatto nodes and weights, at which discontinuous and continuous elements store their values."""

import numpy as np
from numpy.polynomial import Legendre

from slipwave.observe.pieces import Array


def gauss_lobatto(degree: int) -> tuple[Array, Array]:
    """Nodes and weights (degree + 1,) of the Gauss-Lobatto rule on [-1, 1], exact up to degree 2 degree - 1. The inner nodes are
    the roots of the Jacobi polynomial P^(1,1) of degree - 1."""
    from scipy.special import roots_jacobi  # not needed by the other families

    nodes = np.array([-1.0, 1.0])
    if degree > 1:
        nodes = np.insert(nodes, 1, roots_jacobi(degree - 1, 1.0, 1.0)[0])
    return nodes, 2.0 / (degree * (degree + 1) * Legendre.basis(degree)(nodes) ** 2)
