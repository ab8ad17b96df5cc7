"""The figures of a closed cycle (MODEL.md section 6) from its polynomials."""

import numpy as np

from reduced.orbit.closing import Closed
from slipwave.friction import Law, rate_of
from slipwave.observe.extrema import extrema
from slipwave.observe.pieces import Array, lagrange_basis
from slipwave.step.flow import Cycle


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


def amplitude(cycle: Cycle) -> float:
    """Largest less smallest rate unknown z at the nodes."""
    return float(np.ptp(cycle.pieces.z))
