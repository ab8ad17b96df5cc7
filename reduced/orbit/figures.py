"""The figures of a closed cycle (MODEL.md section 6) from its polynomials, and whether it repeats a shorter one."""

import numpy as np

from reduced.orbit.closing import Closed
from slipwave.friction import allows_rest, rate_of, resampled
from slipwave.observe.extrema import extrema
from slipwave.observe.history import values_at
from slipwave.observe.pieces import Array, lagrange_basis
from slipwave.step.collocation import highest_coefficient
from slipwave.step.flow import Cycle

# of the highest Legendre coefficient of a step: what is taken for the first one that is left out; a tenth on average
_NEXT = 0.25
_ROUNDING = 1e-14  # of a stress, relative
_SAMPLES, _SAME = 200, 1e-6  # of a part of a cycle, and differences of ln v and psi in two parts that are none
_NAMES = ("period", "stress_drop", "elastic_stress_drop", "v_max", "v_min")


def figures_of(closed: Closed) -> dict[str, float]:
    """The figures of a closed cycle: name -> period (transits), stress_drop and elastic_stress_drop (maximum minus minimum over
    the cycle, in units of the normal stress), v_max and v_min (V*)."""
    law, basis, pieces = closed.flow.scene.law, lagrange_basis(closed.flow.nodes), closed.cycle.pieces
    (mu_max, mu_min), (y_max, y_min), (z_max, z_min) = (extrema(basis, rows) for rows in (pieces.mu, pieces.y, pieces.z))
    if allows_rest(law):
        each = resampled(law, pieces.z, pieces.psi, lambda z: np.array([extrema(basis, row[None]) for row in z]))
        z_max, z_min = float(each[:, 0].max()), float(each[:, 1].min())
    values = closed.cycle.period, mu_max - mu_min, y_max - y_min, rate_of(law, z_max), rate_of(law, z_min)
    return dict(zip(_NAMES, values, strict=True))


def unresolved(closed: Closed) -> dict[str, float]:
    """Estimated truncation error of the figures that are extrema, from the highest coefficients of the steps there: the actual
    error depends on where in its step an extremum happens to lie."""
    law, pieces = closed.flow.scene.law, closed.cycle.pieces
    tail = _NEXT * highest_coefficient(closed.flow.nodes)
    (mu_max, mu_min), (y_max, y_min), (z_max, z_min) = (_left_out(rows, tail) for rows in (pieces.mu, pieces.y, pieces.z))
    rounding = _ROUNDING * float(np.abs(pieces.mu).max())
    high, low = float(pieces.z.max()), float(pieces.z.min())
    rates = rate_of(law, high + z_max) - rate_of(law, high), rate_of(law, low + z_min) - rate_of(law, low)
    return dict(zip(_NAMES, (0.0, mu_max + mu_min + rounding, y_max + y_min + rounding, *rates), strict=True))


def _left_out(rows: Array, tail: Array) -> tuple[float, float]:
    """Truncation errors of the maximum and of the minimum: of the step with that nodal value and its neighbours, since it may lie
    on an end."""
    at = (int(rows.max(axis=1).argmax()), int(rows.min(axis=1).argmin()))
    largest, smallest = (float(np.abs(rows.take((k - 1, k, k + 1), axis=0, mode="wrap") @ tail).max()) for k in at)
    return largest, smallest


def amplitude(cycle: Cycle) -> float:
    """Maximum minus minimum of the rate unknown z at the nodes."""
    return float(np.ptp(cycle.pieces.z))


def difference_of_parts(cycle: Cycle, nodes: Array, parts: int) -> float:
    """Largest difference of z and psi between the first and the second of `parts` equal parts of a closed cycle."""
    basis, length = lagrange_basis(nodes), cycle.period / parts
    times = np.linspace(0.0, length, _SAMPLES, endpoint=False)[1:]
    first, second = (np.array(values_at(cycle.pieces, basis, times + shift)[:2]) for shift in (0.0, length))
    return float(np.abs(second - first).max())


def repeats_sooner(cycle: Cycle, nodes: Array, cycles: int) -> bool:
    """Whether a closed cycle of `cycles` slip events repeats a shorter one."""
    divisors = [parts for parts in range(2, cycles + 1) if cycles % parts == 0]
    return any(difference_of_parts(cycle, nodes, parts) < _SAME for parts in divisors)
