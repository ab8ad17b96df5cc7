"""The figures of a closed cycle (MODEL.md section 6) from its polynomials."""

import numpy as np

from reduced.orbit.closing import Closed
from slipwave.friction import Law, rate_of
from slipwave.observe.extrema import extrema
from slipwave.observe.pieces import Array, lagrange_basis
from slipwave.step.collocation import highest_coefficient
from slipwave.step.flow import Cycle

_NEXT = 0.25
"""Of the highest Legendre coefficient of a step: what is taken for the first one that is left out; a tenth on average."""

_ROUNDING = 1e-14  # of a stress, relative


def figures_of(closed: Closed) -> dict[str, float]:
    """The `figures` of a closed cycle."""
    return figures(closed.flow.scene.law, closed.cycle, closed.flow.nodes)


def figures(law: Law, cycle: Cycle, nodes: Array) -> dict[str, float]:
    """period (transits), stress_drop and elastic_stress_drop (largest less smallest value in the cycle, in units of the normal
    stress), v_max and v_min (V*)."""
    basis, pieces = lagrange_basis(nodes), cycle.pieces
    (mu_max, mu_min), (y_max, y_min), (z_max, z_min) = (extrema(basis, rows) for rows in (pieces.mu, pieces.y, pieces.z))
    return {
        "period": cycle.period,
        "stress_drop": mu_max - mu_min,
        "elastic_stress_drop": y_max - y_min,
        "v_max": rate_of(law, z_max),
        "v_min": rate_of(law, z_min),
    }


def unresolved(closed: Closed) -> dict[str, float]:
    """What the polynomials of steps leave out of the `figures` that they have an extremum for: where in its step an extremum lies
    changes its error by chance, from mesh to mesh, but not the highest coefficient of the steps there."""
    law, pieces = closed.flow.scene.law, closed.cycle.pieces
    tail = _NEXT * highest_coefficient(closed.flow.nodes)
    (mu_max, mu_min), (y_max, y_min), (z_max, z_min) = (_left_out(rows, tail) for rows in (pieces.mu, pieces.y, pieces.z))
    rounding = _ROUNDING * float(np.abs(pieces.mu).max())
    rates = (_change(law, float(pieces.z.max()), z_max), _change(law, float(pieces.z.min()), z_min))
    return {
        "period": 0.0,
        "stress_drop": mu_max + mu_min + rounding,
        "elastic_stress_drop": y_max + y_min + rounding,
        "v_max": rates[0],
        "v_min": rates[1],
    }


def _left_out(rows: Array, tail: Array) -> tuple[float, float]:
    """By the step of the largest nodal value and by that of the smallest, with their neighbours: one may lie on an end."""
    at = (int(rows.max(axis=1).argmax()), int(rows.min(axis=1).argmin()))
    largest, smallest = (float(np.abs(rows.take((k - 1, k, k + 1), axis=0, mode="wrap") @ tail).max()) for k in at)
    return largest, smallest


def _change(law: Law, z: float, by: float) -> float:
    """Of the slip rate by a change of its unknown."""
    return rate_of(law, z + by) - rate_of(law, z)


def amplitude(cycle: Cycle) -> float:
    """Largest less smallest rate unknown z at the nodes."""
    return float(np.ptp(cycle.pieces.z))
