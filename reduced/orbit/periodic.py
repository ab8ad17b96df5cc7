"""A periodic orbit with its figures (MODEL.md section 6) from its polynomials, their errors from two meshes, and its stability;
and whether a cycle repeats a shorter one."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from reduced.orbit.closing import Closed, close
from reduced.orbit.multipliers import Multipliers, has_leading, multipliers
from slipwave.errors import NumericsError
from slipwave.friction import allows_rest, rate_of, resampled
from slipwave.observe.extrema import evaluate, extrema
from slipwave.observe.history import values_at
from slipwave.observe.pieces import Array, Basis, lagrange_basis
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.step.collocation import highest_coefficient
from slipwave.step.flow import Cycle, Flow

# of the highest Legendre coefficient of a step: what is taken for the first one that is left out; a tenth on average
_NEXT = 0.25
_STRESS_ROUNDING = 1e-14  # relative
_SAMPLES, _SAME = 200, 1e-6  # of a part of a cycle, and differences of ln v and psi in two parts that are none
_NAMES = ("period", "stress_drop", "elastic_stress_drop", "v_max", "v_min")

FINER = 1.5
"""Ratio of the steps of two meshes whose figures are compared."""

_MOST_MESHES = 6
_TO_ROUNDING = 0.0  # residual at which Newton's method ends, if it shrinks so far
_LEAST_GAIN = 4.0  # a mesh that is finer by FINER reduces the errors of a period at least so far; by 16 to 200 where smooth
_ROUNDING = 2e-12  # relative differences below this may be rounding errors, which no mesh reduces; 1.3e-12 occurs
_LEAST_ERROR = 1e-12  # relative; smaller differences are chance: in 200 random orbits rounding moved a period by up to 7e-13
_LEAST_AMPLITUDE = 1e-3  # of ln v; smaller orbits are steady sliding up to the accuracy that is asked for


def figures_of(closed: Closed) -> dict[str, float]:
    """The figures of a closed cycle: name -> period (transits), stress_drop and elastic_stress_drop (maximum minus minimum over
    the cycle, in units of the normal stress), v_max and v_min (V*)."""
    scene, basis, pieces = closed.flow.scene, lagrange_basis(closed.flow.nodes), closed.cycle.pieces
    law, drifts = scene.law, any(slab.termination.has_dead_load for slab in scene.slabs)
    elastic = _between_maxima(basis, closed.cycle) if drifts else pieces.y
    (mu_max, mu_min), (y_max, y_min), (z_max, z_min) = (extrema(basis, rows) for rows in (pieces.mu, elastic, pieces.z))
    if allows_rest(law):
        each = resampled(law, pieces.z, pieces.psi, lambda z: np.array([extrema(basis, row[None]) for row in z]))
        z_max, z_min = float(each[:, 0].max()), float(each[:, 1].min())
    values = closed.cycle.period, mu_max - mu_min, y_max - y_min, rate_of(law, z_max), rate_of(law, z_min)
    return dict(zip(_NAMES, values, strict=True))


def _between_maxima(basis: Basis, cycle: Cycle) -> Array:
    """Nodal values of the elastic stress from its maximum to the one a period later, as of a run's cycles. Behind faces without a
    spring each cycle begins higher or lower than the one before, so that the range of y depends on where a period begins."""
    y, time, period = cycle.pieces.y, cycle.pieces.time, cycle.period
    count = int(np.searchsorted(time, period))  # the last step may end later than the period
    last = count - 1
    drift = evaluate(basis, y[last], (period - time[last]) / cycle.pieces.length[last]) - evaluate(basis, y[0], 0.0)
    y = np.concatenate([y[:count] + k * drift for k in range(-1, 3)])
    tops, here = y.max(axis=1), np.arange(count, 2 * count)
    is_top = (tops[here] >= tops[here - 1]) & (tops[here] >= tops[here + 1])
    first = count + int(np.argmax(np.where(is_top, tops[here] - drift * time[:count] / period, -np.inf)))
    return y[first : first + count + 1]


def _unresolved(closed: Closed) -> dict[str, float]:
    """Estimated truncation error of the figures that are extrema, from the highest coefficients of the steps there: the actual
    error depends on where in its step an extremum happens to lie."""
    law, pieces = closed.flow.scene.law, closed.cycle.pieces
    tail = _NEXT * highest_coefficient(closed.flow.nodes)
    (mu_max, mu_min), (y_max, y_min), (z_max, z_min) = (_left_out(rows, tail) for rows in (pieces.mu, pieces.y, pieces.z))
    rounding = _STRESS_ROUNDING * float(np.abs(pieces.mu).max())
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


def difference_of_parts(closed: Closed, parts: int) -> float:
    """Largest difference of z and psi between the first and the second of `parts` equal parts of a closed cycle: 0 if that is a
    shorter one run several times."""
    basis, length = lagrange_basis(closed.flow.nodes), closed.cycle.period / parts
    times = np.linspace(0.0, length, _SAMPLES, endpoint=False)[1:]
    first, second = (np.array(values_at(closed.cycle.pieces, basis, times + shift)[:2]) for shift in (0.0, length))
    return float(np.abs(second - first).max())


def repeats_sooner(closed: Closed, cycles: int) -> bool:
    """Whether a closed cycle of `cycles` slip events repeats a shorter one."""
    divisors = [parts for parts in range(2, cycles + 1) if cycles % parts == 0]
    return any(difference_of_parts(closed, parts) < _SAME for parts in divisors)


@dataclass(frozen=True)
class PeriodicOrbit:
    """An orbit as `closed` on the finer of two meshes: figures with errors, multipliers, and whether the errors have
    `settled`."""

    closed: Closed
    orbit: Orbit
    multipliers: Multipliers
    settled: bool


def periodic_orbit(
    flow: Flow, state: Array, period: float, tolerance: float = 1e-8, progress: Callable[[str], None] | None = None
) -> PeriodicOrbit:
    """The orbit near `state` and `period` (transits) with relative errors of all figures below `tolerance`.

    The mesh is refined by `FINER` until the figures of two meshes agree, and their largest multipliers, each orbit solved to
    rounding errors (with a larger residual Newton's method may not move from the coarse orbit, and the difference would vanish).
    The error is estimated as a quarter of the difference, or twice a difference of the size of rounding. For extrema, whose
    difference may be small by chance, the truncation error (`_unresolved`) is a second estimate.

    Raises NumericsError if no orbit is found, or if the one found is steady sliding.
    """
    fine = _moving(close(flow, state, period, _TO_ROUNDING))
    for mesh in range(_MOST_MESHES):
        if progress is not None:
            progress(f"mesh {mesh + 2}, {fine.flow.size} values of the state")
        finer, start = fine.flow.remeshed(fine.cycle, FINER)
        coarse, fine = fine, _moving(close(finer, start, fine.cycle.period, _TO_ROUNDING))
        before, now, left_out = figures_of(coarse), figures_of(fine), _unresolved(fine)
        orbit = Orbit(**{name: Estimate(value, max(_error(value, before[name]), left_out[name])) for name, value in now.items()})
        settled = all(figure.error < tolerance * abs(figure.value) for figure in vars(orbit).values())
        if settled and has_leading(fine, coarse):
            break
    # an unstable multiplier magnifies the distance at which Newton's method took its derivative
    exact = replace(fine, monodromy=fine.flow.tangent(fine.cycle))
    return PeriodicOrbit(exact, orbit, multipliers(exact, coarse), settled)


def _moving(closed: Closed) -> Closed:
    if amplitude(closed.cycle) < _LEAST_AMPLITUDE:
        flow = closed.flow
        raise NumericsError(f"{flow.model}: Newton's method fell back onto steady sliding (scene {flow.scene.name!r})")
    return closed


def _error(value: float, before: float) -> float:
    difference, size = abs(value - before), abs(value)
    return max(difference / _LEAST_GAIN, min(2.0 * difference, _ROUNDING * size), _LEAST_ERROR * size)
