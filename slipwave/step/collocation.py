"""Radau IIA collocation on the unit step, shared by the delay system and the ODE reductions."""

from functools import cache
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.polynomial import legendre

from slipwave.observe.pieces import Array, Basis, interpolation_matrix, lagrange_basis

Nodes: TypeAlias = tuple[float, ...]
"""Nodes as a tuple, from which compiled code knows their number."""

_POLISHED = 2  # Newton steps that take the roots of a companion matrix to half an ulp
_ROUNDING = 1e-13  # rounding error of the stability function as computed here


class Collocation(NamedTuple):
    """s nodes in (0, 1] (the last is 1); `integral` A (s, s): A_ij = integral of Lagrange polynomial j from 0 to node i;
    `inverse` A^-1."""

    nodes: Array
    integral: Array
    inverse: Array


RATIOS = (0.25, 0.5, 1.0, 2.0)
"""Ratios of a step's length to that of the step before for which `Rule` extrapolates a guess."""

EQUAL = 2
"""Index of the ratio 1."""


class Rule(NamedTuple):
    """Collocation matrices, transposed so that loops over nodes are contiguous: `integral` (s, s); the row `tail` (s,) gives the
    highest Legendre coefficient. A step's polynomials extended to the nodes of the next one, for all RATIOS: `predict` (4, s, s)
    from nodal values, `predict_state` (4, s + 1, s) from these and the value at the left end, which comes first. `basis` of the
    nodes."""

    integral: Array
    tail: Array
    predict: Array
    predict_state: Array
    basis: Basis


@cache
def radau(stages: int) -> Collocation:
    """Radau IIA rule with `stages` nodes: order 2 stages - 1 at the step's end, L-stable (Hairer and Wanner II, IV.5)."""
    if not 1 <= stages <= 12:
        raise ValueError(f"stages = {stages}: must be in 1..12")
    # right Radau points on (0, 1]: the end, and the roots of Jacobi's P^(1,0) of stages - 1, shifted
    difference = legendre.Legendre.basis(stages - 1) - legendre.Legendre.basis(stages)  # (1 - x) P^(1,0), up to a factor
    slope, points = difference.deriv(), np.sort(difference.roots().real)[:-1]
    for _ in range(_POLISHED):
        points = points - difference(points) / slope(points)
    nodes = np.append(0.5 * (points + 1.0), 1.0)
    gauss, weights = legendre.leggauss(stages + 2)
    basis = lagrange_basis(nodes)
    rows = [0.5 * x * weights @ interpolation_matrix(basis, 0.5 * x * (gauss + 1.0)) for x in nodes]
    integral = np.array(rows)
    return Collocation(nodes, integral, np.linalg.inv(integral))


@cache
def rule_of(stages: int) -> tuple[Collocation, Rule, Nodes]:
    """The Radau rule, its form for compiled marches, and its nodes as a tuple."""
    rule = radau(stages)
    nodal, with_left = lagrange_basis(rule.nodes), lagrange_basis(np.r_[0.0, rule.nodes])
    predict, predict_state = (
        np.array([interpolation_matrix(basis, 1.0 + ratio * rule.nodes).T for ratio in RATIOS]) for basis in (nodal, with_left)
    )
    compiled = Rule(rule.integral.T.copy(), highest_coefficient(rule.nodes), predict, predict_state, nodal)
    return rule, compiled, tuple(float(x) for x in rule.nodes)


@cache
def growth_limit(stages: int, tolerance: float) -> float:
    """Largest growth per step, z = (growth rate) * length, that Radau IIA of `stages` nodes reproduces to `tolerance`.

    |R(z) e^-z - 1| <= tolerance up to this z, with the stability function R (Hairer and Wanner II, IV.3). Beyond z = 38 with 6
    nodes, 61 with 8, |R| is below 1: a growing motion seems to decay smoothly, and no test of the polynomial's resolution detects
    it.
    """
    growth = np.linspace(0.0, 12.0, 1201)[1:]
    systems = np.eye(stages) - growth[:, None, None] * radau(stages).integral
    amplified = np.linalg.solve(systems, np.ones((growth.size, stages, 1)))[:, -1, 0]
    wrong = np.abs(amplified * np.exp(-growth) - 1.0) > max(tolerance, _ROUNDING)
    return float(growth[max(0, int(wrong.argmax()) - 1)])


def highest_coefficient(nodes: Array) -> Array:
    """Row (s,) that gives the highest Legendre coefficient of a polynomial from its nodal values, a measure of its resolution."""
    return np.asarray(np.linalg.inv(legendre.legvander(2.0 * nodes - 1.0, nodes.size - 1))[-1]).copy()


def from_moments(nodes: Array) -> Array:
    """(s, s): values at `nodes` in [0, 1] of the L2 projection with given Legendre moments."""
    values: Array = legendre.legvander(2.0 * nodes - 1.0, nodes.size - 1) * (2.0 * np.arange(nodes.size) + 1.0)
    return values
