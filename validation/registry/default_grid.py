"""The error of a full wave's grid: on the default one it is estimated after the run and reported with its result; on a given one
it is left to the user."""

from typing import TYPE_CHECKING

from slipwave.scene.start import StartKind
from slipwave.solve import FieldSolver, Solver
from validation.registry.build import build_full_wave

if TYPE_CHECKING:
    from fullwave.adapt import Choice

TOO_COARSE = 1e-2
"""Estimated error above which the user is advised to choose a grid."""

_COARSER = 1.5


def judged(solver: Solver, cfl: float | None = None, time: str | None = None) -> "Choice | None":
    """The default grid of `solver` with its estimated error, by fresh solvers; None for models without a grid and for a start on
    the orbit, which depends on a march of its own."""
    if not isinstance(solver, FieldSolver) or solver.scene.start.kind is StartKind.ORBIT:
        return None
    from fullwave.adapt import first_accepted, judge_grid

    model, scene, cells = solver.model, solver.scene, solver.cells
    fewer = range(max(1, int(cells / _COARSER)), cells)  # two thirds, or the fewest more that the family accepts

    def on_grid(number: int) -> FieldSolver:
        """The solver with so many cells."""
        return build_full_wave(model, scene, cells=number, cfl=cfl, time=time)

    return judge_grid(cells, on_grid(cells), first_accepted(on_grid, fewer) or on_grid(cells))


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
