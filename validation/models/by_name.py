"""Every family of models by its name on the command line: its options, the scenes it can compute, and the construction of its
solvers. A family whose module is not part of this installation is not listed. Solvers are imported when one is built.
"""

import string
from collections.abc import Collection
from functools import cache
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict, Unpack

from fullwave.families import FAMILIES as WITH_GRID
from fullwave.families import FullWave, facts_of
from reduced.families import DELAY as DELAY
from reduced.families import FAMILIES as WITHOUT_GRID
from reduced.families import REDUCTIONS
from slipwave.errors import SceneError
from slipwave.family import Exact, Family, features_of, in_words
from slipwave.input.wording import nearest, shorten
from slipwave.packages import load_from_packages

if TYPE_CHECKING:
    from fullwave.adapt import Choice
    from slipwave.scene import Scene
    from slipwave.solve import Solver

GRIDS = WITH_GRID
"""The full waves; those of other packages and files are appended."""

FAMILIES: list[Family] = [*WITHOUT_GRID, *WITH_GRID]
"""Cheapest first; `auto` takes the first that is exact. Families of other packages and files are appended."""

_part = cache(find_spec)

OPTIONS = tuple(dict.fromkeys(option for family in reversed(FAMILIES) for option in family.options))
"""The numerical options that a family may take."""


class Options(TypedDict, total=False):
    """The numerical options of a model; it chooses those that are None or missing: `cells`, `cfl` and `time` are for full-wave
    models, `tolerance` for those that take one. On a grid of given cells `tolerance` is that of the steps of the exact march."""

    cells: int | None
    cfl: float | None
    tolerance: float | None
    time: str | None


def given(options: Options, *names: str) -> dict[str, Any]:
    """The options among `names` that were set, as keyword arguments."""
    return {name: value for name in names if (value := options.get(name)) is not None}


class BuiltSolver(NamedTuple):
    """A solver, the grid that was chosen for a tolerance (`choice`), and `why` `auto` took its model."""

    solver: "Solver"
    choice: "Choice | None" = None
    why: str = ""


def add_family(family: object, label: str) -> None:
    """Register a family for every command. Raises SceneError, which begins with `label`, if it is no `Family` or its name is
    taken."""
    if not isinstance(family, Family):
        raise SceneError(f"{label}: is no slipwave.family.Family")
    if family.name == "auto" or family_of(family.name):
        raise SceneError(f"{label}: the name {family.name!r} is taken by another family of models")
    FAMILIES.append(family)
    if isinstance(family, FullWave):
        GRIDS.append(family)
    else:
        REDUCTIONS.append(family)


def family_of(model: str) -> Family | None:
    """The family of a full name, as `modal:2`; None if unknown."""
    return next((family for family in FAMILIES if family.name == model.partition(":")[0]), None)


def one_port_of(model: str) -> str:
    """The model whose slab impedance `model` uses: the exact one for every model that is exact."""
    family = family_of(model)
    exact = model == "auto" or (family is not None and family.exact is not Exact.NEVER)
    return DELAY.name if exact else model


def grid_of(model: str) -> tuple[FullWave, int]:
    """The full wave of a full name, as `dg:7`, and its number (0 if it has none). Raises KeyError for any other name."""
    name, _, number = model.partition(":")
    return facts_of(name), int(number or 0)


def explicit_time(model: str) -> str | None:
    """Value of the option `time` for explicit steps, None for a full wave with one march only. Explicit steps share neither step
    nor friction solve with the delay system, and so check it independently."""
    return "explicit" if "time" in grid_of(model)[0].options else None


def families() -> list[Family]:
    """The families of this installation, cheapest first."""
    return [family for family in FAMILIES if _part(family.module) is not None]


def honouring(scene: "Scene") -> list[Family]:
    """The families of this installation that can compute `scene`."""
    return [family for family in families() if family.is_installed and not family.refusal(scene)]


def resolve(model: str, scene: "Scene", among: Collection[Family] = FAMILIES) -> tuple[str, str]:
    """(model, why): `auto` becomes the cheapest exact model for the scene `among` some families; any other name is returned
    without reason."""
    if model != "auto":
        return model, ""
    ordered = sorted(families(), key=lambda family: family.exact is Exact.NEVER)  # exact ones first, each as they were
    best = next((family for family in ordered if family in among and not family.refusal(scene) and family.is_installed), None)
    if best is None:
        raise SceneError(f"model = 'auto': no model of this installation can do {in_words(features_of(scene))}")
    if best is DELAY:
        return best.example, "exact for this scene"
    return best.example, f"the delay system cannot do {DELAY.refusal(scene) or 'it is not part of this installation'}"


def made(model: str, scene: "Scene", **options: Unpack[Options]) -> BuiltSolver:
    """The solver called `model` for `scene`, at the beginning of it, and what was chosen for it; a grid's degree may be left out
    of its name and is then chosen (`dg` for `dg:P`).

    Raises SceneError for an unknown model (naming the nearest), a number out of range after the colon, an option the model does
    not take, and a scene it cannot do (naming the models that can).
    """
    model, why = resolve(model, scene)
    return make(*requested(model, scene, **options))._replace(why=why)


def requested(model: str, scene: "Scene", **options: Unpack[Options]) -> tuple[Family, "Scene", int | None, Options]:
    """The arguments of `make` for a full name: its family, the scene, the number after the colon, and the options. Raises
    SceneError as `made` does."""
    family, number = parse(model)
    for name, value in given(options, *OPTIONS).items():
        if name not in family.options:
            takers = ", ".join(other.pattern for other in families() if name in other.options)
            raise SceneError(f"{name} = {value}: model {model} takes no {name}; models that do: {takers}")
    cfl, tolerance = options.get("cfl"), options.get("tolerance")
    if options.get("time") == "exact" and cfl is not None:
        raise SceneError(f"cfl = {cfl:g}: the exact march has no step limit; leave it out, or choose --time explicit")
    least, most = family.tolerances
    if tolerance is not None and not least <= tolerance <= most:
        raise SceneError(f"tolerance = {tolerance:g}: must lie in [{least:g}, {most:g}] for model {model}")
    if number is None:
        number = family.chosen(options.get("tolerance"))
    refusal = family.refusal(scene)
    if refusal:
        able = ", ".join(other.pattern for other in honouring(scene)) or "none of this installation"
        raise SceneError(f"model = {model!r}: cannot do {refusal} (scene {scene.name!r}); models that can: {able}")
    return family, scene, number, options


def parse(model: str) -> tuple[Family, int | None]:
    """Family and number of a model's name, None for a number to be chosen or a family without numbers. Raises SceneError for
    unknown names and wrong numbers."""
    name, colon, number = model.partition(":")
    family = family_of(name)
    if family is None or family not in families():
        known = ", ".join(["auto", *(family.pattern for family in families())])
        guess, rest = nearest(name, [family.name for family in families()]), name.lstrip(string.ascii_letters)
        meant = (
            f"{guess}:{rest}"
            if rest.isdigit() and any(family.name == guess and family.numbers for family in families())
            else guess
        )
        hint = f'; did you mean "{meant}"?' if guess else ""
        raise SceneError(f"model = {shorten(model)}: must be one of {known}{hint}")
    if not colon and family.suited is not None:
        return family, None
    if not family.numbers:
        if colon:
            raise SceneError(f"model = {shorten(model)}: {name} takes no number")
        return family, None
    if not (number.isascii() and number.isdigit() and len(number) < 9 and int(number) in family.numbers):
        numbers = family.numbers
        if isinstance(numbers, range):
            choice = f"a whole number from {numbers.start} to {numbers.stop - 1}"
        else:
            choice = f"one of {', '.join(map(str, numbers))}"
        raise SceneError(f"model = {shorten(model)}: must be {family.pattern} with {choice}")
    return family, int(number)


def make(family: Family, scene: "Scene", number: int | None, options: Options) -> BuiltSolver:
    """A solver of the member of `family` with this number after the colon; SceneError for an option out of range or a scene it
    cannot compute."""
    if family in GRIDS:
        return _on_a_grid(family, scene, number, options)
    if family is DELAY:
        return BuiltSolver(family.maker()(scene, **given(options, "tolerance")))
    from reduced.impedance import reduction_of
    from reduced.ode.slabs import ReducedModel

    return BuiltSolver(ReducedModel(scene, reduction_of(scene, family.called(number)), **given(options, "tolerance")))


def _on_a_grid(family: Family, scene: "Scene", number: int | None, options: Options) -> BuiltSolver:
    """A full wave on the requested grid, for which a tolerance only sets the steps, or else on a grid fine enough for the
    tolerance."""
    numbers = () if number is None else (number,)

    def member(scene: "Scene", **options: Any) -> Any:
        """The member with its number, on a grid of its own or with its options."""
        return family.maker(number)(scene, *numbers, **options)

    tolerance, cells = options.get("tolerance"), options.get("cells")
    if tolerance is None:
        return BuiltSolver(member(scene, **given(options, "cells", "cfl", "time")))
    if cells is not None:
        steps = {"resolution": tolerance} if "time" in family.options else {}
        solver = member(scene, **steps, **given(options, "cells", "cfl", "time"))
        if "resolution" not in solver.settings:
            raise SceneError(f"tolerance = {tolerance:g}: chooses the cells itself; leave out cells = {cells}")
        return BuiltSolver(solver)
    from fullwave.adapt import resolution_for, to_tolerance

    steps = {"resolution": resolution_for(tolerance)} if "time" in family.options else {}
    facts = facts_of(family.name)
    order, at_best = (declared(number or 0) for declared in (facts.order_interface, facts.order_at_best or facts.order_interface))
    return BuiltSolver(*to_tolerance(scene, tolerance, member, order, at_best, **steps, **given(options, "cfl", "time")))


load_from_packages("slipwave.families", add_family)
