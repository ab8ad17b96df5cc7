"""A full wave to a requested tolerance: degree, cells and step chosen by comparing grids, with an a-posteriori error estimate.

The scene is run from its own start for 400 transits (or all it asks for) on two grids whose cells differ by the factor 3/2. The
largest relative difference of any complete cycle's period or stress drop is taken for the finer one's error (a bound as long as
the refinement gains a factor of two; orders 4 and more gain five and more); grids are refined until it is below the tolerance.
Where no cycle closes, ln v and psi at the end of the probe stand in.

The estimate holds for the length of the probe. A chaotic run loses it at the rate at which its neighbours part; a start with a
jump (order 1 in every scheme) costs many cells and may be refused.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fullwave.discontinuous import MOST_DEGREE, DiscontinuousGalerkin
from fullwave.march import March
from scene.errors import NumericsError, SceneError
from scene.observe import EventObserver, follow
from scene.observe.pieces import Array
from scene.scene import Scene

MOST_TRIED_CELLS = 400
PROBE = 400.0
"""Transits of a probe, unless the scene asks for less."""

_RATIO = 1.5


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


def degree_for(tolerance: float) -> int:
    """Degree of discontinuous Galerkin elements that is cheapest around `tolerance`, as raced on the paper's scene: 4 at 1e-4,
    one more per two digits."""
    return min(MOST_DEGREE, max(3, round(2 - 0.5 * math.log10(tolerance) + 0.5)))


def to_tolerance(
    scene: Scene, tolerance: float, kind: Callable[..., March] = DiscontinuousGalerkin, **options: Any
) -> tuple[March, Choice]:
    """A solver of `scene`, at its start, whose error in period and stress drop is estimated below `tolerance` (relative), and
    the `Choice` made. `kind` and `options` fix the family (by default discontinuous Galerkin of a degree chosen by `tolerance`).

    Raises SceneError for a tolerance outside [1e-12, 0.1], NumericsError if 400 cells are not enough.
    """
    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not 1e-12 <= tolerance <= 0.1:
        raise SceneError(f"tolerance = {tolerance!r}: must lie in [1e-12, 0.1]")
    if kind is DiscontinuousGalerkin:
        options = {"degree": degree_for(tolerance)} | options
    cells = _fewest(scene, kind, options)
    tried: list[tuple[int, float]] = []
    before = None
    while cells <= MOST_TRIED_CELLS:
        solver = kind(scene, cells=cells, **options)
        now = _probe(solver)
        estimate = _estimate(before, now)
        tried.append((cells, estimate))
        if now is not None and estimate <= tolerance:
            fresh = kind(scene, cells=cells, **options)
            return fresh, Choice(cells, fresh.step, now.quantity, estimate, tuple(tried))
        before, cells = now, math.ceil(_RATIO * cells)
    raise NumericsError(
        f"{solver.model}: tolerance {tolerance:g} not reached with {tried[-1][0]} cells: estimated error {tried[-1][1]:.2g} "
        f"(scene {scene.name!r})"
    )


def _fewest(scene: Scene, kind: Callable[..., March], options: dict[str, Any]) -> int:
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


def _probe(solver: March) -> _Found | None:
    """None if the grid was too coarse to march."""
    events = EventObserver(solver.scene, solver.nodes)
    try:
        final = follow(solver, min(PROBE, solver.scene.until), [events])
    except NumericsError:
        return None
    found = events.events
    if found.period.size:
        return _Found("cycles", np.concatenate((found.period, found.stress_drop)))
    return _Found("final state", np.array([final.ln_v, final.psi]))


def _estimate(before: _Found | None, now: _Found | None) -> float:
    """Largest relative error of `now`, infinite unless both probes found the same cycles."""
    if before is None or now is None or before.quantity != now.quantity or before.values.size != now.values.size:
        return math.inf
    worst = float((np.abs(now.values - before.values) / np.maximum(np.abs(now.values), 1e-3)).max())
    return worst if math.isfinite(worst) else math.inf
