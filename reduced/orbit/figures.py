"""The figures of a closed cycle (MODEL.md section 6) from its polynomials, and whether it is a shorter one, several times."""

import numpy as np

from reduced.orbit.closing import Closed
from slipwave.friction import Law, rate_of
from slipwave.observe.extrema import extrema
from slipwave.observe.pieces import Array, lagrange_basis, values_at
from slipwave.step.collocation import highest_coefficient
from slipwave.step.flow import Cycle

# of the highest Legendre coefficient of a step: what is taken for the first one that is left out; a tenth on average
_NEXT = 0.25
_ROUNDING = 1e-14  # of a stress, relative
_SAMPLES, _SAME = 200, 1e-6  # of a part of a cycle, and differences of ln v and psi in two parts that are none
_NAMES = ("period", "stress_drop", "elastic_stress_drop", "v_max", "v_min")


def figures_of(closed: Closed) -> dict[str, float]:
    """The `figures` of a closed cycle."""
    return cycle_figures(closed.flow.scene.law, closed.cycle, closed.flow.nodes)


def cycle_figures(law: Law, cycle: Cycle, nodes: Array) -> dict[str, float]:
    """period (transits), stress_drop and elastic_stress_drop (largest less smallest value in the cycle, in units of the normal
    stress), v_max and v_min (V*)."""
    basis, pieces = lagrange_basis(nodes), cycle.pieces
    (mu_max, mu_min), (y_max, y_min), (z_max, z_min) = (extrema(basis, rows) for rows in (pieces.mu, pieces.y, pieces.z))
    values = cycle.period, mu_max - mu_min, y_max - y_min, rate_of(law, z_max), rate_of(law, z_min)
    return dict(zip(_NAMES, values, strict=True))


def unresolved(closed: Closed) -> dict[str, float]:
    """What the polynomials of steps leave out of the `figures` that they have an extremum for: where in its step an extremum lies
    changes its error by chance, from mesh to mesh, but not the highest coefficient of the steps there."""
    law, pieces = closed.flow.scene.law, closed.cycle.pieces
    tail = _NEXT * highest_coefficient(closed.flow.nodes)
    (mu_max, mu_min), (y_max, y_min), (z_max, z_min) = (_left_out(rows, tail) for rows in (pieces.mu, pieces.y, pieces.z))
    rounding = _ROUNDING * float(np.abs(pieces.mu).max())
    high, low = float(pieces.z.max()), float(pieces.z.min())
    rates = rate_of(law, high + z_max) - rate_of(law, high), rate_of(law, low + z_min) - rate_of(law, low)
    return dict(zip(_NAMES, (0.0, mu_max + mu_min + rounding, y_max + y_min + rounding, *rates), strict=True))


def _left_out(rows: Array, tail: Array) -> tuple[float, float]:
    """By the step of the largest nodal value and by that of the smallest, with their neighbours: one may lie on an end."""
    at = (int(rows.max(axis=1).argmax()), int(rows.min(axis=1).argmin()))
    largest, smallest = (float(np.abs(rows.take((k - 1, k, k + 1), axis=0, mode="wrap") @ tail).max()) for k in at)
    return largest, smallest


def amplitude(cycle: Cycle) -> float:
    """Largest less smallest rate unknown z at the nodes."""
    return float(np.ptp(cycle.pieces.z))


def difference_of_parts(cycle: Cycle, nodes: Array, parts: int) -> float:
    """Largest difference of z and psi between the first of so many equal `parts` of a closed cycle and the second."""
    basis, length = lagrange_basis(nodes), cycle.period / parts
    times = np.linspace(0.0, length, _SAMPLES, endpoint=False)[1:]
    first, second = (np.array(values_at(cycle.pieces, basis, times + shift)[:2]) for shift in (0.0, length))
    return float(np.abs(second - first).max())


def repeats_sooner(cycle: Cycle, nodes: Array, cycles: int) -> bool:
    """Whether a closed cycle of so many slip events is one of fewer, several times."""
    divisors = [parts for parts in range(2, cycles + 1) if cycles % parts == 0]
    return any(difference_of_parts(cycle, nodes, parts) < _SAME for parts in divisors)
