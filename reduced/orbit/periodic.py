"""A periodic orbit with its figures, their errors from two meshes, and its stability."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from reduced.orbit.closing import Closed, close
from reduced.orbit.figures import amplitude, figures_of, unresolved
from reduced.orbit.multipliers import Multipliers, multipliers
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.step.flow import Flow

FINER = 1.5
"""Ratio of the steps of two meshes whose figures are compared."""

_MOST_MESHES = 6
_TO_ROUNDING = 0.0  # residual at which Newton's method ends, if it shrinks so far
_LEAST_GAIN = 4.0  # a mesh that is finer by FINER reduces the errors of a period at least so far; by 16 to 200 where smooth
_ROUNDING = 2e-12  # relative differences below this may be rounding errors, which no mesh reduces; 1.3e-12 occurs
_LEAST_ERROR = 1e-12  # relative; smaller differences are chance: in 200 random orbits rounding moved a period by up to 7e-13
_LEAST_AMPLITUDE = 1e-3  # of ln v; smaller orbits are steady sliding up to the accuracy that is asked for


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

    The mesh is refined by `FINER` until the figures of two meshes agree, each orbit solved to rounding errors (with a larger
    residual Newton's method may not move from the coarse orbit, and the difference would vanish). The error is estimated as a
    quarter of the difference, or twice a difference of the size of rounding. For extrema, whose difference may be small by
    chance, the truncation error (`unresolved`) is a second estimate.

    Raises NumericsError if no orbit is found, or if the one found is steady sliding.
    """
    fine = _moving(close(flow, state, period, _TO_ROUNDING))
    for mesh in range(_MOST_MESHES):
        if progress is not None:
            progress(f"mesh {mesh + 2}, {fine.flow.size} values of the state")
        finer, start = fine.flow.remeshed(fine.cycle, FINER)
        coarse, fine = fine, _moving(close(finer, start, fine.cycle.period, _TO_ROUNDING))
        before, now, left_out = figures_of(coarse), figures_of(fine), unresolved(fine)
        orbit = Orbit(**{name: Estimate(value, max(_error(value, before[name]), left_out[name])) for name, value in now.items()})
        settled = all(figure.error < tolerance * abs(figure.value) for figure in vars(orbit).values())
        if settled:
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
