"""Chooses degree, cells and step of a full wave for a requested tolerance, by an error estimate from successive grids.

The scene is run from its own start until 400 transits after the last knot of its drive (or to its end, if that is earlier) on
grids of 3/2 of the cells of the one before. In layers, whose cells are whole numbers and at least the family's fewest, that may
leave cells as long as they are; then their number increases until they are so much shorter that d still bounds the error. Let d
be the largest relative difference, between two successive grids, of any complete cycle's period or stress drop, and g the
factor by which d falls from one refinement to the next. The error of the finer grid is estimated as the rest of the geometric
series, d / (g - 1), but never as less than d. Grids are refined until the estimate is below the tolerance, or until too many
cells would be needed even if d fell at the scheme's order from there on: on coarse grids it may fall later. If no cycle is
complete, ln v and psi at the end of the probe are compared instead.

All grids have nearly the same steps of an exact march, whose error cancels in d. It is about ten times their resolution in
regular motion, and up to 5000 times their resolution in irregular motion, which amplifies it equally on every grid. Therefore it
is measured, by finer steps on the last grid but one, and the steps become finer until it fits the tolerance.

The estimate holds for the length of the probe. In a chaotic run it becomes invalid at the rate at which nearby motions diverge. A
start with a jump is of order 1 in every scheme, needs many cells, and is refused if these are too many. With a ramped drive the
convergence of explicit steps is only of second order and irregular, because kinks fall at different points within the steps of
each grid; so is that of second-order differences for unlike slabs. One difference may be small by chance: no refinement is
credited with more than the scheme's order p (1 where fronts are), i.e. the estimate is at least that of the previous grid divided
by 1.5^p.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from itertools import chain
from typing import Any, TypeAlias, TypeVar, cast

import numpy as np

from fullwave.families import GALERKIN
from fullwave.lines.blocks import sections_of
from fullwave.lines.exact import EXACT_TOLERANCE
from fullwave.lines.march import MethodOfLines
from fullwave.options import MOST_CELLS, CellsRefused
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.drive import StartKind
from slipwave.solve import FieldSolver, Solver, follow
from slipwave.solve.follow import require_time

Solved = TypeVar("Solved")
Probed: TypeAlias = tuple[str, Array]
"""What a probe compares: "cycles" with their periods and stress drops, in order, or "final state", ln v and psi at its end."""

MOST_TRIED_CELLS = 400
PROBE = 400.0
"""Transits of a probe after the last knot of the drive, unless the scene ends earlier."""

GRID_MARGIN = 1.5
"""Times the change of a figure from one grid to the next, at order 2: on 109 scenes, alike, unlike and layered, 5 errors exceed
that change and none this multiple of it."""

_MUCH_COARSER, _MUCH_FINER = math.sqrt(1.0 + 1.0 / GRID_MARGIN), math.sqrt(GRID_MARGIN / (GRID_MARGIN - 1.0))
"""Least ratios of the cells of a coarser and of a finer grid, at which that multiple is the error at order 2."""

_AT_FRONTS = 10.0  # instead of it where fronts are, of order 1: of 159 errors 54 exceed the other and 11 this one
_RATIO = 1.5
_STEPS_SHARE = 0.02  # of the tolerance: resolution of the steps of an exact march
_STEPS_ERROR = 10.0  # times that resolution; on 18 scenes of regular motion, from 1e-3 to 1e-12, 12 at most
_FINER = 8.0  # times, from one resolution of the steps to the next
_LEAST_GAIN = 0.25  # smallest g - 1 used: rounding makes differences stagnate although the error is small
_MOST_OUTLOOK = math.log(1e6)  # largest logarithm of the growth in cells to which a trend is extrapolated
_IRREGULAR = 2  # order up to which one small difference proves nothing, as it may not at the first two grids that agree
_MOST_NEEDED = 40  # cells that every family accepts
_SETTLED = 24  # cells from which the gain is assumed to continue


@dataclass(frozen=True)
class Choice:
    """The chosen grid and its accuracy: the `quantity` compared ("cycles" or "final state"), its relative `error_estimate`, and
    the grids tried as (cells, estimate). `step` is the length of a step, or the longest if it adapts."""

    cells: int
    step: float
    quantity: str
    error_estimate: float
    tried: tuple[tuple[int, float], ...]
    adapts: bool = False


def to_tolerance(
    scene: Scene,
    tolerance: float,
    kind: Callable[..., MethodOfLines],
    order: float,
    credited: float = math.inf,
    **options: Any,
) -> tuple[MethodOfLines, Choice]:
    """A solver of `scene`, at its start, whose estimated relative error in period and stress drop is below `tolerance`, and the
    `Choice` of its grid. `kind` makes it with `cells` and `options`; its outputs converge at the `order` or faster, but no
    refinement is credited with a higher order than `credited`.

    Raises SceneError for a tolerance outside [1e-12, 0.1], NumericsError if 400 cells, or as many as the march allows, are not
    enough, or the shortest steps.
    """
    least, most = GALERKIN.tolerances
    if not isinstance(cast(object, tolerance), int | float) or not least <= tolerance <= most:
        raise SceneError(f"tolerance = {tolerance!r}: must lie in [{least:g}, {most:g}]")
    coarsest = _first_accepted(lambda cells: kind(scene, cells=cells, **options), range(2, _MOST_NEEDED))
    cells = coarsest.cells if coarsest else _MOST_NEEDED
    tried: list[tuple[int, float]] = []
    credited = min(credited, 1.0 if _has_fronts(scene) else _IRREGULAR if _kinked(scene) else math.inf)
    slowest = _RATIO ** min(order, credited)
    before, last_cells, difference, needed, outlook = None, cells, math.inf, 0.0, ""
    while max(cells, needed) <= MOST_TRIED_CELLS:
        try:
            solver = kind(scene, cells=cells, **options)
        except SceneError as refusal:
            if not tried:
                raise
            outlook = f"; {refusal}"
            break
        now = _probe(solver)
        last, difference = difference, _difference_of(before, now)
        gain = last / difference if 0.0 < difference < math.inf else math.inf
        estimate, resolution = _grid_error(last, difference, gain, credited), solver.settings.get("resolution", 0.0)
        by_steps = _STEPS_ERROR * resolution
        fine = now is not None and estimate + by_steps <= tolerance
        if fine:
            coarser = partial(kind, scene, **options | {"cells": last_cells})
            resolution, by_steps = _steps_within(tolerance - estimate, coarser, resolution, before)
        tried.append((cells, estimate + by_steps))
        if now and fine and estimate + by_steps <= tolerance:
            fresh = kind(scene, cells=cells, **options | ({"resolution": resolution} if resolution else {}))
            return fresh, Choice(cells, fresh.step, now[0], tried[-1][1], tuple(tried), math.isnan(fresh.transits_per_piece))
        if fine:
            outlook = "; its steps are as short as they can be"
            break
        needed = _needed(cells, tried[-1][1] / tolerance, max(gain, slowest)) if cells >= _SETTLED else 0.0
        before, last_cells, cells = now, cells, _refined(solver)
    if needed > MOST_TRIED_CELLS:
        outlook = f"; by its trend it needs about {float(f'{needed:.2g}'):,.0f} cells, but at most {MOST_TRIED_CELLS} are tried"
    raise NumericsError(
        f"{solver.model}: tolerance {tolerance:g} not reached with {tried[-1][0]} cells: estimated error {tried[-1][1]:.2g}"
        f"{outlook} (scene {scene.name!r})"
    )


def _grid_error(last: float, difference: float, gain: float, credited: float) -> float:
    """The estimated error of a grid from its `difference` from the one before and the `last` difference, `gain` times as
    large."""
    most: float = _RATIO**credited
    estimate = difference / min(1.0, max(min(gain, most) - 1.0, _LEAST_GAIN))
    if credited <= _IRREGULAR or last < math.inf:
        estimate = max(estimate, last / most / min(1.0, most - 1.0))
    return estimate * (GRID_MARGIN if credited <= _IRREGULAR else 1.0)


def _steps_within(
    allowed: float, make: Callable[..., FieldSolver], resolution: float, before: Probed | None
) -> tuple[float, float]:
    """The resolution of steps with an error of at most `allowed`, or the finest, and that error: the change of the probe `before`
    of the grid that `make` makes, whose steps had the given `resolution`, with finer ones."""
    error = _STEPS_ERROR * resolution
    while resolution > EXACT_TOLERANCE:
        finer = _probe(make(resolution=resolution / _FINER))
        error = max(_STEPS_ERROR * resolution, GRID_MARGIN * _difference_of(before, finer))
        if error <= allowed:
            break
        resolution, error, before = resolution / _FINER, error / _FINER, finer
    return resolution, error


def _widths(solver: FieldSolver, cells: int | None = None) -> list[float]:
    """Length of the cells (transits of travel time) in each layer on the grid of `solver`, or of its scene and family with so
    many `cells`. Raises CellsRefused if the family does not accept them."""
    if not isinstance(cast(object, solver), MethodOfLines):
        return [1.0 / (cells or solver.cells)]  # up to a factor: the cells of the leapfrog follow its step, in layers too
    sections = cast(MethodOfLines, solver).sections
    if cells is not None:
        sections = tuple(sections_of(solver.scene, cells, sections[0].fewest))
    return [section.length / section.cells for section in sections]


def _is_finer(fine: list[float], coarse: list[float], factor: float) -> bool:
    """Whether cells are shorter by `factor` in each layer, those much finer than the longest left out: their error is small."""
    longest = max(fine)
    return all(factor * one <= other or _RATIO * one <= longest for one, other in zip(fine, coarse, strict=True))


def _refined(solver: FieldSolver) -> int:
    """Number of cells of the next grid: 3/2 of those of `solver`, or the fewest more at which cells are shorter in each layer."""
    here, numbers = _widths(solver), range(math.ceil(_RATIO * solver.cells), MOST_TRIED_CELLS + 1)
    finer = (cells for cells in numbers if _is_finer(_widths(solver, cells), here, _MUCH_COARSER))
    return next(finer, MOST_TRIED_CELLS + 1)


def resolution_for(tolerance: float) -> float:
    """Resolution of the steps of an exact march for figures to `tolerance`. All grids have nearly the same steps, whose error
    cancels in differences of grids and is therefore added to the estimate."""
    return _STEPS_SHARE * tolerance


def judge_grid(cells: int, judged: FieldSolver, other: FieldSolver) -> Choice:
    """The accuracy of a default grid of `cells`, from fresh solvers on it (`judged`) and on an `other` grid with 2/3 of its
    cells, or 3/2 where no coarser one is possible. From order 2 on (3 for the finer one), the difference of their probes, with a
    margin for the pre-asymptotic range and the error of their common steps, exceeds the error; where fronts make the order 1, ten
    times that difference. The estimate is infinite if the probes differ in their cycles.
    """
    theirs, ours = _probe(other), _probe(judged)
    margin = _AT_FRONTS if _has_fronts(judged.scene) else GRID_MARGIN
    estimate = margin * _difference_of(theirs, ours) + _STEPS_ERROR * judged.settings.get("resolution", 0.0)
    return Choice(cells, judged.step, ours[0] if ours else "final state", estimate, (), math.isnan(judged.transits_per_piece))


def _needed(cells: int, factor: float, gain: float) -> float:
    """Number of cells that reduces the error by `factor` if every refinement gains `gain`; 0 if there is no estimate."""
    if not 1.0 < gain < math.inf or not math.isfinite(factor):
        return 0.0
    return cells * math.exp(min(_MOST_OUTLOOK, math.log(factor) * math.log(_RATIO) / math.log(gain)))


def _first_accepted(make: Callable[[int], Solved], numbers: Iterable[int]) -> Solved | None:
    """The solver that `make` builds on the first of the `numbers` of cells that its family accepts; None if there is none."""
    for cells in numbers:
        try:
            return make(cells)
        except CellsRefused:
            continue
    return None


def on_another_grid(solver: FieldSolver, make: Callable[[int], FieldSolver]) -> FieldSolver | None:
    """The solver that `make` makes on a grid of two thirds of the cells of `solver`, or the fewest more that its family accepts,
    or else of 3/2 or more, whose cells differ by so much in each layer that GRID_MARGIN times the change of a figure of order 2
    exceeds its error; None if there is none."""
    here, fewer, more = _widths(solver), max(1, int(solver.cells / _RATIO)), math.ceil(_RATIO * solver.cells)

    def another(cells: int) -> FieldSolver:
        """The solver with so many cells."""
        there = _widths(solver, cells)
        finer = _is_finer(here, there, _MUCH_COARSER) if cells < solver.cells else _is_finer(there, here, _MUCH_FINER)
        if not finer:
            raise CellsRefused(f"cells = {cells}: hardly another grid")
        return make(cells)

    return _first_accepted(another, chain(range(fewer, solver.cells), range(more, MOST_CELLS + 1)))


def _probed_until(scene: Scene) -> float:
    """End of a probe (transits), after the drive's last knot, so that errors made before and after it are included."""
    probed = PROBE + (scene.drive.times[-1] if _kinked(scene) else 0.0)
    return probed if scene.until is None else min(probed, scene.until)


def _has_fronts(scene: Scene) -> bool:
    """Whether the start or the drive makes waves with steep fronts, after which every grid is of order 1."""
    return scene.start.kind is StartKind.JUMP or 0.0 in np.diff(scene.drive.times)


def _kinked(scene: Scene) -> bool:
    """Whether the drive changes after the start."""
    return not scene.drive.is_constant and scene.drive.times[-1] > 0.0


def _probe(solver: Solver) -> Probed | None:
    """The result of a probe with a fresh `solver`; None if the grid is too coarse to march."""
    events = EventObserver(solver.scene, solver.nodes)
    require_time(solver, _probed_until(solver.scene))
    try:
        final = follow(solver, _probed_until(solver.scene), [events])
    except NumericsError:
        return None
    cycles = events.events()
    if cycles.period.size:
        return "cycles", np.concatenate((cycles.period, cycles.stress_drop))
    return "final state", np.array([final.ln_v if final.v > 0.0 else final.mu, final.psi])


def _difference_of(before: Probed | None, now: Probed | None) -> float:
    """Largest relative difference of two probes, infinite unless both have the same cycles."""
    if before is None or now is None or before[0] != now[0] or before[1].size != now[1].size:
        return math.inf
    (_, values), (_, earlier) = now, before
    worst = float((np.abs(values - earlier) / np.maximum(np.abs(values), 1e-3)).max())
    return worst if math.isfinite(worst) else math.inf
