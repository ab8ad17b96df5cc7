"""A full wave to a requested tolerance: degree, cells and step chosen by comparing grids, with an a-posteriori error estimate.

The scene is run from its own start until 400 transits after the last knot of its drive (or all it asks for) on grids whose cells
grow by the factor 3/2. d, the largest relative difference between two successive grids of any complete cycle's period or stress
drop, gains a factor g from one refinement to the next; the finer grid's error is estimated as the rest of that geometric series,
d / (g - 1), but never as less than d. Grids are refined until the estimate is below the tolerance, or until the gain shows that
too many would be needed. Where no cycle closes, ln v and psi at the end of the probe stand in.

The estimate holds for the length of the probe. A chaotic run loses it at the rate at which its neighbours part; a start with a
jump (order 1 in every scheme) costs many cells and is refused when they are out of reach. The kinks of a ramped drive leave no
more than order 2 and fall at another place within the steps of each grid, so that one small difference may be luck: there the
estimate is never less than the difference before, lowered by that order's gain.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.families import GALERKIN, degree_for
from fullwave.lines.march import MethodOfLines
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver, follow
from slipwave.observe.foresight import require_time
from slipwave.observe.pieces import Array
from slipwave.observe.snapshot import FieldSolver
from slipwave.scene import Scene

MOST_TRIED_CELLS = 400
PROBE = 400.0
"""Transits of a probe once the drive has come to rest, unless the scene asks for less."""

_RATIO = 1.5
_LEAST_GAIN = 0.25  # of one refinement beyond 1: rounding makes differences stagnate without the error being large
_MOST_OUTLOOK = math.log(1e6)  # of the growth in cells that a trend is extended to
_KINKED_GAIN = _RATIO**2  # what a refinement gains at order 2
_SETTLED = 24  # cells from which the gain is trusted to go on


@dataclass(frozen=True)
class Choice:
    """What was chosen and how good it is: `quantity` judged ("cycles" or "final state"), the relative `error_estimate` in it, and
    the grids tried as (cells, estimate there)."""

    cells: int
    step: float
    quantity: str
    error_estimate: float
    tried: tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class _Found:
    """What a probe saw: periods and stress drops of its cycles, in order, else ln v and psi at its end."""

    quantity: str
    values: Array


def to_tolerance(
    scene: Scene, tolerance: float, kind: Callable[..., MethodOfLines] = DiscontinuousGalerkin, **options: Any
) -> tuple[MethodOfLines, Choice]:
    """A solver of `scene`, at its start, whose error in period and stress drop is estimated below `tolerance` (relative), and
    the `Choice` made. `kind` and `options` fix the family (by default discontinuous Galerkin of a degree chosen by `tolerance`).

    Raises SceneError for a tolerance outside [1e-12, 0.1], NumericsError if 400 cells are not enough.
    """
    least, most = GALERKIN.tolerances
    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not least <= tolerance <= most:
        raise SceneError(f"tolerance = {tolerance!r}: must lie in [{least:g}, {most:g}]")
    if kind is DiscontinuousGalerkin:
        options = {"degree": degree_for(tolerance)} | options
    cells = _fewest(scene, kind, options)
    tried: list[tuple[int, float]] = []
    before, difference, needed = None, math.inf, 0.0
    while max(cells, needed) <= MOST_TRIED_CELLS:
        solver = kind(scene, cells=cells, **options)
        now = _probe(solver)
        last, difference = difference, _difference(before, now)
        gain = last / difference if 0.0 < difference < math.inf else math.inf
        estimate = difference / min(1.0, max(gain - 1.0, _LEAST_GAIN))
        if _kinked(scene):
            estimate = max(estimate, last / _KINKED_GAIN)
            gain = max(gain, _KINKED_GAIN) if gain > 1.0 else gain
        tried.append((cells, estimate))
        if now is not None and estimate <= tolerance:
            fresh = kind(scene, cells=cells, **options)
            return fresh, Choice(cells, fresh.step, now.quantity, estimate, tuple(tried))
        needed = _needed(cells, estimate / tolerance, gain) if cells >= _SETTLED else 0.0
        before, cells = now, math.ceil(_RATIO * cells)
    outlook = ""
    if needed > MOST_TRIED_CELLS:
        outlook = f"; its trend asks for some {float(f'{needed:.1g}'):,.0f} cells, {MOST_TRIED_CELLS} are the most tried"
    raise NumericsError(
        f"{solver.model}: tolerance {tolerance:g} not reached with {tried[-1][0]} cells: estimated error {tried[-1][1]:.2g}"
        f"{outlook} (scene {scene.name!r})"
    )


def judge_grid(cells: int, fine: FieldSolver, coarse: FieldSolver) -> Choice:
    """What a grid of `cells` that nobody asked for is worth, from fresh solvers on it and on one with two thirds of its cells.

    Their difference in a probe is more than the error of the finer, from order 2 on.

    The estimate is infinite where the two do not find the same cycles.
    """
    before, now = _probe(coarse), _probe(fine)
    return Choice(cells, fine.step, now.quantity if now else "final state", _difference(before, now), ())


def _needed(cells: int, factor: float, gain: float) -> float:
    """Cells that would bring the error down by `factor` if every refinement went on gaining `gain`; 0 if that cannot be told."""
    if not 1.0 < gain < math.inf or not math.isfinite(factor):
        return 0.0
    return cells * math.exp(min(_MOST_OUTLOOK, math.log(factor) * math.log(_RATIO) / math.log(gain)))


def _fewest(scene: Scene, kind: Callable[..., MethodOfLines], options: dict[str, Any]) -> int:
    """The smallest number of cells from 2 on that the family accepts."""
    for cells in range(2, 40):
        try:
            kind(scene, cells=cells, **options)
        except SceneError as refusal:
            if "cells" not in str(refusal):
                raise
        else:
            return cells
    return 40


def _probed_until(scene: Scene) -> float:
    """End of a probe (transits): an error made on the way to the drive's last knot, or after it, is seen."""
    return min(PROBE + (scene.drive.times[-1] if _kinked(scene) else 0.0), scene.until)


def _kinked(scene: Scene) -> bool:
    """Whether the drive changes after the start."""
    return not scene.drive.is_constant and scene.drive.times[-1] > 0.0


def _probe(solver: FieldSolver) -> _Found | None:
    """None if the grid was too coarse to march."""
    events = EventObserver(solver.scene, solver.nodes)
    require_time(solver, _probed_until(solver.scene))
    try:
        final = follow(solver, _probed_until(solver.scene), [events])
    except NumericsError:
        return None
    found = events.events()
    if found.period.size:
        return _Found("cycles", np.concatenate((found.period, found.stress_drop)))
    return _Found("final state", np.array([final.ln_v, final.psi]))


def _difference(before: _Found | None, now: _Found | None) -> float:
    """Largest relative difference of two probes, infinite unless both found the same cycles."""
    if before is None or now is None or before.quantity != now.quantity or before.values.size != now.values.size:
        return math.inf
    worst = float((np.abs(now.values - before.values) / np.maximum(np.abs(now.values), 1e-3)).max())
    return worst if math.isfinite(worst) else math.inf
