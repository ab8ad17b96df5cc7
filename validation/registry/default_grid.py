"""The error of a full wave on its default grid, which nobody chose: estimated after the run and told with its result."""

from typing import TYPE_CHECKING

from slipwave.errors import SceneError
from slipwave.observe import Solver
from slipwave.observe.snapshot import FieldSolver
from slipwave.scene import Scene
from slipwave.scene.start import StartKind
from validation.registry.build import build_full_wave

if TYPE_CHECKING:
    from fullwave.adapt import Choice

TOO_COARSE = 1e-2
"""Estimated error above which the reader is told to choose a grid."""

_COARSER = 1.5


def judged(solver: Solver, cfl: float | None = None) -> "Choice | None":
    """The default grid of `solver` with its estimated error, by fresh solvers; None for models without a grid and for a start on
    the orbit, which depends on a march of its own."""
    if not isinstance(solver, FieldSolver) or solver.scene.start.kind is StartKind.ORBIT:
        return None
    from fullwave.adapt import judge_grid

    coarse = _coarser(solver.scene, solver.model, solver.cells, cfl)
    fine = build_full_wave(solver.model, solver.scene, solver.cells, cfl)
    return judge_grid(solver.cells, fine, coarse)


def note_on(choice: "Choice") -> list[str]:
    """What the reader must know of a default grid; nothing if it is good enough."""
    if choice.error_estimate <= TOO_COARSE:
        return []
    told = (
        f"{choice.error_estimate:.1e}" if choice.error_estimate < float("inf") else "unknown, a coarser grid finds other cycles"
    )
    return [
        f"the default grid of {choice.cells} cells is too coarse for this scene: estimated error {told}; give --tol or --cells"
    ]


def _coarser(scene: Scene, model: str, cells: int, cfl: float | None) -> FieldSolver:
    """Two thirds of the cells, or as few more as the family can make of the scene."""
    for fewer in range(max(1, int(cells / _COARSER)), cells):
        try:
            return build_full_wave(model, scene, fewer, cfl)
        except SceneError as refusal:
            if "cells" not in str(refusal):
                raise
    return build_full_wave(model, scene, cells, cfl)
