"""The response of a reduction within one collocation step, tabulated for every step length of the integrator.

Collocation turns the linear network of a `Reduction` (its module gives the states) into a stage impedance: with u = v - V at the
s nodes of a step of length h, the collocation matrix A and c = A 1, mode k responds with

    tau = W (tau_0 1 + h p_0 c - (residue h A + offset h^2 A^2) u),     W = (1 + 2 decay h A + omega^2 h^2 A^2)^-1,

the spring with  -spring h A u,  damping with  -damping u,  and mass m with  -(m/h) A^-1 (v - v_0 1).  The sum of all factors of u
is one s x s matrix K(h), so the cost of a Newton iteration does not depend on the number of modes. A `Reduction` is relative to
epsilon, on the transit clock.
"""

import numpy as np

from reduced.ode.port import ReducedPort
from reduced.ode.reduction import Reduction
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Collocation


def step_port(reduction: Reduction, epsilon: float, rule: Collocation, levels: int, longest: float) -> ReducedPort:
    """The port of `reduction` of slabs with `epsilon` for `levels` step lengths, of which `longest` (transits) is the first. It
    remembers zeros."""
    residue, offset, decay2, omega2 = _terms(reduction)
    length = np.ldexp(longest, -np.arange(levels))
    a, one = rule.integral, np.ones(rule.nodes.size)
    ha = length[:, None, None] * a
    ha2 = ha @ ha
    by_mode = (slice(None), None)
    response = np.linalg.inv(np.eye(one.size) + decay2[:, None, None] * ha[by_mode] + omega2[:, None, None] * ha2[by_mode])
    forced = response @ (residue[:, None, None] * ha[by_mode] + offset[:, None, None] * ha2[by_mode])
    free = np.stack([response @ one, np.einsum("lnij,lj->lni", response, ha @ one)], axis=2)
    elastic = reduction.spring * ha + forced.sum(axis=1) + reduction.damping * np.eye(one.size)
    inertia = reduction.mass * rule.inverse / length[:, None, None]
    return ReducedPort(
        length,
        epsilon * (elastic + inertia),
        epsilon * elastic,
        epsilon * inertia @ one,
        free,
        epsilon * forced,
        np.ones(levels, dtype=np.bool_),
        epsilon * offset,
        omega2,
        epsilon * reduction.spring,
        np.zeros((offset.size, 2)),
        np.zeros(2),
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
