"""The response of a reduction within one collocation step, tabulated for every step length of the integrator.

Collocation turns the linear network of a `Reduction` (its module gives the states) into a stage impedance: with u = v - V at the
s nodes of a step of length h, the collocation matrix A and c = A 1, mode k responds with

    tau = W (tau_0 1 + h p_0 c - (residue h A + offset h^2 A^2) u),     W = (1 + 2 decay h A + omega^2 h^2 A^2)^-1,

the spring with  -spring h A u,  damping with  -damping u,  and mass m with  -(m/h) A^-1 (v - v_0 1).  The sum of all factors of u
is one s x s matrix K(h), so the cost of a Newton iteration does not depend on the number of modes. Everything is relative to
epsilon, on the transit clock.
"""

from typing import NamedTuple

import numpy as np

from reduced.ode.reduction import Reduction
from reduced.step.collocation import Collocation
from slipwave.observe.pieces import Array, interpolation_matrix, lagrange_basis

LONGEST = 2.0
"""Longest step (transits); level l has length longest / 2^l."""


class Tables(NamedTuple):
    """Per level: `length` (L,); `impedance` K (L, s, s) with mass, and `elastic` (L, s, s) without; `inertia` m A^-1 1 / h, (L,
    s); `free` (L, N, 2, s): response to tau_0 and p_0; `forced` (L, N, s, s): response to -u. Per mode: `offset`,
    `omega_squared`."""

    length: Array
    impedance: Array
    elastic: Array
    inertia: Array
    free: Array
    forced: Array
    offset: Array
    omega_squared: Array
    spring: float


def step_tables(reduction: Reduction, rule: Collocation, levels: int, longest: float = LONGEST) -> Tables:
    """Tables of `reduction` for `levels` step lengths, of which `longest` (transits) is the first."""
    residue, offset, decay2, omega2 = _terms(reduction)
    length = np.ldexp(longest, -np.arange(levels))
    a, one = rule.integral, np.ones(rule.nodes.size)
    ha = length[:, None, None] * a
    ha2 = ha @ ha
    by_mode = (slice(None), None)
    response = np.linalg.inv(np.eye(one.size) + decay2[:, None, None] * ha[by_mode] + omega2[:, None, None] * ha2[by_mode])
    forced = response @ (residue[:, None, None] * ha[by_mode] + offset[:, None, None] * ha2[by_mode])
    free = np.stack([response @ one, np.einsum("lnij,lj->lni", response, ha @ one)], axis=2)
    elastic = reduction.spring * ha + forced.sum(axis=1)
    inverse = rule.inverse / length[:, None, None]
    impedance = elastic + reduction.damping * np.eye(one.size) + reduction.mass * inverse
    inertia = reduction.mass * inverse @ one
    return Tables(
        length, impedance, elastic + reduction.damping * np.eye(one.size), inertia, free, forced, offset, omega2, reduction.spring
    )


def impedance_at(reduction: Reduction, s: Array) -> Array:
    """Z(s)/epsilon for real s > 0 (1/transit)."""
    residue, offset, decay2, omega2 = (term[:, None] for term in _terms(reduction))
    modes = (residue * s + offset) / (s * s + decay2 * s + omega2)
    return np.asarray(reduction.spring / s + reduction.mass * s + reduction.damping + modes.sum(axis=0))


def _terms(reduction: Reduction) -> tuple[Array, Array, Array, Array]:
    """residue, offset, 2 decay, omega^2 of all terms; a relaxation is a mode without inertia (p = 0)."""
    extra = len(reduction.relaxations)
    residue = np.array([*reduction.residues, *(strength for strength, _ in reduction.relaxations)], dtype=float)
    offset = np.array([*reduction.offsets, *[0.0] * extra], dtype=float)
    decay2 = np.array([*(2.0 * d for d in reduction.decays), *(rate for _, rate in reduction.relaxations)], dtype=float)
    omega2 = np.array([*(w * w for w in reduction.frequencies), *[0.0] * extra], dtype=float)
    return residue, offset, decay2, omega2


def prediction_tables(rule: Collocation, ratios: tuple[float, ...]) -> tuple[Array, Array]:
    """Matrices that extrapolate to the nodes of a next step `ratio` times as long: (R, s, s) from nodal values, (R, s, s + 1)
    from these and the value at the left end."""
    nodal, with_left = lagrange_basis(rule.nodes), lagrange_basis(np.r_[0.0, rule.nodes])
    return (
        np.array([interpolation_matrix(nodal, 1.0 + ratio * rule.nodes) for ratio in ratios]),
        np.array([interpolation_matrix(with_left, 1.0 + ratio * rule.nodes) for ratio in ratios]),
    )
