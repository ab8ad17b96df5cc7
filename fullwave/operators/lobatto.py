"""Gauss-Lobatto nodes and weights: where discontinuous and continuous elements hold their values."""

import numpy as np
from numpy.polynomial import legendre

from slipwave.observe.pieces import Array


def gauss_lobatto(degree: int) -> tuple[Array, Array]:
    """Nodes and weights (degree + 1,) of the Gauss-Lobatto rule on [-1, 1], exact to degree 2 degree - 1."""
    last = np.eye(degree + 1)[degree]
    slope = legendre.legder(last)
    inner = np.sort(legendre.legroots(slope).real)
    for _ in range(3):  # polish: the companion matrix loses digits
        inner = inner - legendre.legval(inner, slope) / legendre.legval(inner, legendre.legder(slope))
    nodes = np.concatenate(([-1.0], inner, [1.0]))
    nodes = 0.5 * (nodes - nodes[::-1])
    return nodes, 2.0 / (degree * (degree + 1) * legendre.legval(nodes, last) ** 2)
