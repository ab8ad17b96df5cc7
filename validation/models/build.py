"""Makes the solver of a model for a scene, by the model's name on the command line, where the scene starts; and the estimated
error of the default grid of a full wave."""

from typing import TYPE_CHECKING, Any, Unpack

from slipwave.errors import SceneError
from slipwave.family import Family
from slipwave.scene import Scene
from slipwave.scene.drive import StartKind
from slipwave.solve import FieldSolver, Solver, State
from validation.models.by_name import OPTIONS, BuiltSolver, Options, given, made, parse, resolve

if TYPE_CHECKING:
    from fullwave.adapt import Choice


def build(model: str, scene: Scene, **options: Unpack[Options]) -> Solver:
    """The solver of `prepare`."""
    return prepare(model, scene, **options).solver


def build_full_wave(model: str, scene: Scene, **options: Unpack[Options]) -> FieldSolver:
    """As `build`; SceneError for a model without a grid."""
    solver = build(model, scene, **options)
    if not isinstance(solver, FieldSolver):
        raise SceneError(f"model = {model!r}: has no grid; use a full-wave model")
    return solver


def prepare(model: str, scene: Scene, resumed: bool = False, **options: Unpack[Options]) -> BuiltSolver:
    """The solver of `made` at the scene's start. For a start on the orbit the model is first marched there, unless the run is
    `resumed` from a checkpoint. Raises as `made`."""
    built = made(model, scene, **options)
    if scene.start.kind is not StartKind.ORBIT:
        return built
    from validation.models.orbit_start import FieldsOnOrbit, OnOrbit

    orbiting = FieldsOnOrbit(built.solver) if isinstance(built.solver, FieldSolver) else OnOrbit(built.solver)
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
    families = [parse(name)[0] for name in names]
    known = given(options, *OPTIONS)
    for option, value in known.items():
        if not any(option in family.options for family in families):
            raise SceneError(f"{option} = {value}: none of the models {models} takes it")
    return [
        build(name, scene, **{option: value for option, value in known.items() if _takes(family, option, known)})
        for name, family in zip(names, families, strict=True)
    ]


def _takes(family: Family, option: str, known: dict[str, Any]) -> bool:
    """Whether a model of `family`, among several, is given the option. With cells given, a tolerance is for models without
    cells."""
    return option in family.options and not (option == "tolerance" and "cells" in known and "cells" in family.options)


def judged_grid(solver: Solver, start: State, cfl: float | None = None, time: str | None = None) -> "Choice | None":
    """The default grid of `solver` with its estimated error, from its own state at the `start` and another grid; None for models
    without a grid and for a start on the orbit, which needs a march of its own. `solver` is not changed."""
    if not isinstance(solver, FieldSolver) or solver.scene.start.kind is StartKind.ORBIT:
        return None
    from fullwave.adapt import judge_grid, on_another_grid

    model, scene, end = solver.model, solver.scene, solver.state()
    try:
        solver.restore(start)
        other = on_another_grid(solver, lambda cells: build_full_wave(model, scene, cells=cells, cfl=cfl, time=time))
        return judge_grid(solver.cells, solver, other) if other else None
    finally:
        solver.restore(end)
