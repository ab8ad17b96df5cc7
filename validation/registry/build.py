"""Makes the solver of a model for a scene, by the model's name on the command line."""

import math
from typing import TYPE_CHECKING, Any, Unpack

from slipwave.errors import SceneError
from slipwave.family import Family
from slipwave.scene import Scene
from slipwave.scene.start import StartKind
from slipwave.solve import FieldSolver, Solver, State
from validation.registry.choice import parse, requested, resolve
from validation.registry.families import OPTIONS, Built, Options, given, make

if TYPE_CHECKING:
    from fullwave.adapt import Choice

TOO_COARSE = 1e-2
"""Estimated error above which the user is advised to choose a grid."""

_COARSER = 1.5


def build(model: str, scene: Scene, **options: Unpack[Options]) -> Solver:
    """The solver of `prepare`."""
    return prepare(model, scene, **options).solver


def build_full_wave(model: str, scene: Scene, **options: Unpack[Options]) -> FieldSolver:
    """As `build`; SceneError for a model without a grid."""
    solver = build(model, scene, **options)
    if not isinstance(solver, FieldSolver):
        raise SceneError(f"model = {model!r}: has no grid; use a full-wave model")
    return solver


def prepare(model: str, scene: Scene, resumed: bool = False, **options: Unpack[Options]) -> Built:
    """The solver called `model` for `scene`, and what was chosen for it; a grid's degree may be left out of its name and is then
    chosen (`dg` for `dg:P`).

    Raises SceneError for an unknown model (naming the nearest), a number out of range after the colon, an option the model does
    not take, and a scene it cannot do (naming the models that can). A start on the orbit marches the model there first, unless
    the run is `resumed` from a checkpoint.
    """
    model, why = resolve(model, scene)
    built = make(*requested(model, scene, **options))._replace(why=why)
    if scene.start.kind is not StartKind.ORBIT:
        return built
    from validation.registry.orbit_start import on_orbit

    orbiting = on_orbit(built.solver)
    if not resumed:
        orbiting.begin()
    return built._replace(solver=orbiting)


def build_all(models: str, scene: Scene, **options: Unpack[Options]) -> list[Solver]:
    """The solvers of a comma-separated list of models; each is given the options it takes, and one of them must take each.

    Raises SceneError as `build` does, and for an empty or repeated name.
    """
    names = [resolve(name.strip(), scene)[0] for name in models.split(",")]
    repeated = [name for name in names if names.count(name) > 1]
    if repeated:
        raise SceneError(f"models = {models!r}: {repeated[0]} is named more than once")
    found = [parse(name)[0] for name in names]
    known = given(options, *OPTIONS)
    for option, value in known.items():
        if not any(option in family.options for family in found):
            raise SceneError(f"{option} = {value}: none of the models {models} takes it")
    return [
        build(name, scene, **{option: value for option, value in known.items() if _takes(family, option, known)})
        for name, family in zip(names, found, strict=True)
    ]


def _takes(family: Family, option: str, known: dict[str, Any]) -> bool:
    """Whether this one of several models is given the option. With cells given, a tolerance is for those without."""
    return option in family.options and not (option == "tolerance" and "cells" in known and "cells" in family.options)


def judged_grid(solver: Solver, start: State, cfl: float | None = None, time: str | None = None) -> "Choice | None":
    """The default grid of `solver` with its estimated error, from its own state at the `start` and another grid; None for
    models without a grid and for a start on the orbit, which depends on a march of its own. `solver` is left as it is."""
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
