"""The error of a full wave on its default grid, which nobody chose: estimated after the run and told with its result."""

from typing import TYPE_CHECKING, Any

from slipwave.errors import SceneError
from slipwave.observe import Solver
from slipwave.scene import Scene
from slipwave.scene.start import StartKind
from validation.registry.build import build

if TYPE_CHECKING:
    from fullwave.adapt import Choice

TOO_COARSE = 1e-2
"""Estimated error above which the reader is told to choose a grid."""

_COARSER = 1.5


def judged(solver: Solver, cfl: float | None = None) -> "Choice | None":
    """The default grid of `solver` with its estimated error, by fresh solvers; None for models without a grid and for a start on
    the orbit, which depends on a march of its own."""
    if not hasattr(solver, "snapshot") or solver.scene.start.kind is StartKind.ORBIT:
        return None
    from fullwave.adapt import judge_grid

    cells = _cells(solver)
    coarse = _coarser(solver.scene, solver.model, cells, cfl)
    fine: Any = build(solver.model, solver.scene, cells, cfl)
    return judge_grid(cells, fine, coarse)


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


def _cells(solver: Any) -> int:
    return int(solver.cells if hasattr(solver, "cells") else solver.sections[0].asked)


def _coarser(scene: Scene, model: str, cells: int, cfl: float | None) -> Any:
    """Two thirds of the cells, or as few more as the family can make of the scene."""
    for fewer in range(max(1, int(cells / _COARSER)), cells):
        try:
            return build(model, scene, fewer, cfl)
        except SceneError as refusal:
            if "cells" not in str(refusal):
                raise
    return build(model, scene, cells, cfl)
