"""The default grid of a full wave: its estimated error, and notes on it for the user."""

import math
from typing import TYPE_CHECKING

from slipwave.scene.drive import StartKind
from slipwave.solve import FieldSolver, Solver, State
from validation.models.build import build_full_wave

if TYPE_CHECKING:
    from fullwave.adapt import Choice

TOO_COARSE = 1e-2
"""Estimated error above which the user is advised to choose a grid."""

_COARSER = 1.5


def judged_grid(solver: Solver, start: State, cfl: float | None = None, time: str | None = None) -> "Choice | None":
    """The default grid of `solver` with its estimated error, from its own state at the `start` and another grid; None for models
    without a grid and for a start on the orbit, which needs a march of its own. `solver` is not changed."""
    if not isinstance(solver, FieldSolver) or solver.scene.start.kind is StartKind.ORBIT:
        return None
    from fullwave.adapt import first_accepted, judge_grid
    from fullwave.options import CellsRefused

    model, scene, cells = solver.model, solver.scene, solver.cells
    fewer = range(max(1, int(cells / _COARSER)), cells)  # two thirds, or the fewest more that the family accepts
    more = range(math.ceil(_COARSER * cells), 2 * cells)

    def on_grid(number: int) -> FieldSolver:
        """The solver with so many cells, if that makes its grid another one: thin layers have the fewest cells already."""
        other = build_full_wave(model, scene, cells=number, cfl=cfl, time=time)
        if other.settings["cells"] == solver.settings["cells"]:
            raise CellsRefused(f"cells = {number}: the same grid")
        return other

    end = solver.state()
    try:
        solver.restore(start)
        other = first_accepted(on_grid, (*fewer, *more))
        return judge_grid(cells, solver, other) if other else None
    finally:
        solver.restore(end)


def grid_in_words(choice: "Choice") -> str:
    """Cells, steps and estimated error of a grid."""
    steps = f"steps of {'at most ' * choice.adapts}{choice.step:.4g}"
    return f"{choice.cells} cells, {steps}, estimated error of {choice.quantity} {choice.error_estimate:.1e}"


def note_on(choice: "Choice") -> list[str]:
    """A warning about a default grid that is too coarse; empty if it is good enough."""
    if choice.error_estimate <= TOO_COARSE:
        return []
    error = (
        f"{choice.error_estimate:.1e}" if choice.error_estimate < float("inf") else "unknown, a coarser grid finds other cycles"
    )
    return [
        f"the default grid of {choice.cells} cells is too coarse for this scene: estimated error {error}; give --tol or --cells"
    ]


def note_on_given(cells: int | None, tolerance: float | None) -> list[str]:
    """A note where cells are given with a tolerance, which then cannot choose them."""
    if cells is None or tolerance is None:
        return []
    return [f"tolerance {tolerance:g} is for the steps in time: cells are given, and the error of their grid is not estimated"]
