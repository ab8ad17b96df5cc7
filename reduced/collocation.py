"""Radau IIA collocation on the unit step, shared by the delay system and the ladder of ODE reductions."""

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.polynomial import legendre

from scene.observe.pieces import Array, interpolation_matrix, lagrange_basis

Nodes: TypeAlias = tuple[float, ...]
"""Nodes as a tuple: compiled code then knows their number."""


class Collocation(NamedTuple):
    """s nodes in (0, 1] (the last is 1); `integral` A (s, s): A_ij = integral of Lagrange polynomial j from 0 to node i;
    `inverse` A^-1; `predict` (s, s): values one step further on of the polynomial through s nodal values;
    `predict_state` (s, s + 1): the same for a polynomial that also knows its value at the left end (first column)."""

    nodes: Array
    integral: Array
    inverse: Array
    predict: Array
    predict_state: Array


def radau(stages: int) -> Collocation:
    """Radau IIA of `stages` nodes: order 2 stages - 1 at the step's end, L-stable (Hairer and Wanner II, IV.5)."""
    if not 1 <= stages <= 12:
        raise ValueError(f"stages = {stages}: must be in 1..12")
    nodes = radau_nodes(stages)
    gauss, weights = legendre.leggauss(stages + 2)
    basis = lagrange_basis(nodes)
    rows = [0.5 * x * weights @ interpolation_matrix(basis, 0.5 * x * (gauss + 1.0)) for x in nodes]
    integral = np.array(rows)
    with_left = lagrange_basis(np.r_[0.0, nodes])
    return Collocation(
        nodes,
        integral,
        np.linalg.inv(integral),
        interpolation_matrix(basis, 1.0 + nodes),
        interpolation_matrix(with_left, 1.0 + nodes),
    )


def highest_coefficient(nodes: Array) -> Array:
    """Row (s,) that gives the highest Legendre coefficient of a polynomial from its nodal values: how well a step resolves it."""
    return np.asarray(np.linalg.inv(legendre.legvander(2.0 * nodes - 1.0, nodes.size - 1))[-1]).copy()


def radau_nodes(stages: int) -> Array:
    """Right Radau points on (0, 1]: roots of P_s - P_(s-1), shifted."""
    coefficients = np.zeros(stages + 1)
    coefficients[stages], coefficients[stages - 1] = 1.0, -1.0
    nodes = np.asarray((np.sort(legendre.legroots(coefficients).real) + 1.0) / 2.0)
    nodes[-1] = 1.0
    return nodes
