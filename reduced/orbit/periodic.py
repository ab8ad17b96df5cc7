"""A periodic orbit with its figures, their errors from two meshes, and its stability."""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

from reduced.orbit.closing import Closed, close
from reduced.orbit.figures import amplitude, figures_of
from reduced.orbit.multipliers import Multipliers, multipliers
from slipwave.errors import NumericsError
from slipwave.observe.orbit import Estimate, Orbit
from slipwave.observe.pieces import Array
from slipwave.step.flow import Flow

FINER = 1.5
"""Ratio of the steps of two meshes whose figures are compared."""

_MOST_MESHES = 6
_ROUNDING = 1e-13  # relative error below which two meshes agree by chance
_LEAST_AMPLITUDE = 1e-3  # of ln v; smaller orbits are steady sliding up to the accuracy that is asked for


@dataclass(frozen=True)
class PeriodicOrbit:
    """An orbit as `closed` on the finer of two meshes: its figures with their estimated errors, its multipliers, and `settled`:
    whether the errors are below the requested ones."""

    closed: Closed
    orbit: Orbit
    multipliers: Multipliers
    settled: bool


def periodic_orbit(
    flow: Flow, state: Array, period: float, tolerance: float = 1e-8, progress: Callable[[str], None] | None = None
) -> PeriodicOrbit:
    """The orbit near `state` and `period` (transits) with relative errors of all figures below `tolerance`.

    The mesh is refined by `FINER` until two of them agree. A finer mesh of s nodes in a step has at least an order s, so that its
    error is estimated by the difference over FINER^s - 1.

    Raises NumericsError if no orbit is found, or if the one found is steady sliding.
    """
    fine = _moving(close(flow, state, period))
    for mesh in range(_MOST_MESHES):
        if progress is not None:
            progress(f"mesh {mesh + 2}, {fine.flow.size} values of the state")
        finer, start = fine.flow.remeshed(fine.cycle, FINER)
        coarse, fine = fine, _moving(close(finer, start, fine.cycle.period))
        orbit = _estimates(coarse, fine)
        settled = relative_error(orbit) < tolerance
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


def _estimates(coarse: Closed, fine: Closed) -> Orbit:
    before, now = figures_of(coarse), figures_of(fine)
    share = FINER**fine.flow.nodes.size - 1.0
    return Orbit(
        **{name: Estimate(value, max(abs(value - before[name]) / share, _ROUNDING * abs(value))) for name, value in now.items()}
    )


def relative_error(orbit: Orbit) -> float:
    """The largest relative error of its figures."""
    estimates: list[Estimate] = [getattr(orbit, field.name) for field in fields(orbit)]
    return max(one.error / abs(one.value) for one in estimates)
