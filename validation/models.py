"""Every model by its command-line name: who computes it, what it takes, which scenes it honours. `build` makes the solver.

A family whose module is not part of this installation is not listed. Solver modules are imported only when one is built.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, NamedTuple

from scene.errors import SceneError
from scene.observe import Solver
from scene.scene import Scene
from validation.features import FEATURES, features_of


class Request(NamedTuple):
    """What a builder is given: the number after the colon and the numerical options, None where left to the model."""

    parameter: int | None = None
    cells: int | None = None
    cfl: float | None = None
    tolerance: float | None = None

    def given(self, *names: str) -> dict[str, Any]:
        """The options among `names` that were set, as keyword arguments."""
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}


@dataclass(frozen=True)
class Family:
    """One row of the registry. `pattern` is the name as shown (`modal:N`), `parameters` the numbers allowed after the colon,
    `options` the numerical options it takes, `honours` the scene features it can do (keys of FEATURES)."""

    pattern: str
    module: str
    title: str
    make: Callable[[Scene, str, Request], Solver]
    honours: frozenset[str]
    options: tuple[str, ...]
    parameters: range | tuple[int, ...] = ()
    default: int | None = None

    @property
    def name(self) -> str:
        """The word before the colon."""
        return self.pattern.partition(":")[0]

    @property
    def room(self) -> str:
        """`reduced` or `fullwave`."""
        return self.module.partition(".")[0]

    @property
    def example(self) -> str:
        """A name that `build` accepts."""
        return self.name if self.default is None else f"{self.name}:{self.default}"

    def refusal(self, scene: Scene) -> str:
        """Why this family cannot do `scene`; empty if it can."""
        missing = [feature for feature in FEATURES if feature in features_of(scene) - self.honours]
        return " and ".join(FEATURES[feature] for feature in missing)


def _delay(scene: Scene, model: str, request: Request) -> Solver:
    from reduced.delay import Delay

    return Delay(scene, **request.given("tolerance"))


def _ladder(scene: Scene, model: str, request: Request) -> Solver:
    from reduced.ladder import Ladder
    from reduced.reduction import reduction_of

    return Ladder(scene, reduction_of(scene, model), **request.given("tolerance"))


def _leapfrog(scene: Scene, model: str, request: Request) -> Solver:
    from fullwave.finite_difference import Leapfrog

    return Leapfrog(scene, **request.given("cells", "cfl"))


_OPTIONS = ("cells", "cfl", "tolerance")
_ODE = ("tolerance",)
_GRID = ("cells", "cfl")
_PLAIN = frozenset({"ramp"})
_RIGID = _PLAIN | {"unlike", "incommensurate"}
_LOSSLESS = _RIGID | {"layers"}
_ANY = frozenset(FEATURES) - {"orbit"}
_SPRUNG = _ANY - {"reflection"}

_FAMILIES = (
    Family("delay", "reduced.delay", "the exact wave physics of elastic slabs as a delay system", _delay, _PLAIN, _ODE),
    Family("quasistatic", "reduced.ladder", "no waves, no inertia: runs away when unstable", _ladder, _SPRUNG, _ODE),
    Family("quasidynamic", "reduced.ladder", "no waves, radiation damping", _ladder, _SPRUNG, _ODE),
    Family("block8", "reduced.ladder", "spring and block of mass rho h/8", _ladder, _RIGID, _ODE),
    Family("block12", "reduced.ladder", "spring and block of mass rho h/12", _ladder, _LOSSLESS, _ODE),
    Family("kelvin-voigt", "reduced.ladder", "the paper's ODE, one Kelvin-Voigt element", _ladder, _RIGID, _ODE),
    Family("modal:N", "reduced.ladder", "the slabs' first N exact modes", _ladder, _LOSSLESS, _ODE, range(65), 2),
    Family("fitted:N", "reduced.ladder", "passive rational fit of the exact impedance", _ladder, _ANY, _ODE, range(65), 4),
    Family("fd", "fullwave.finite_difference", "full wave: staggered leapfrog", _leapfrog, _ANY, _GRID),
)


def families() -> list[Family]:
    """The families of this installation, cheapest first."""
    return [family for family in _FAMILIES if find_spec(family.module) is not None]


def honouring(scene: Scene) -> list[Family]:
    """The families that can do `scene`."""
    return [family for family in families() if not family.refusal(scene)]


def resolve(model: str, scene: Scene) -> tuple[str, str]:
    """(model, why): `auto` becomes the cheapest model that is exact for the scene; any other name is returned with no reason."""
    if model != "auto":
        return model, ""
    chosen = honouring(scene)
    if not chosen:
        raise SceneError(f"model = 'auto': no model of this installation can do {_asked(scene)}")
    best = next((family for family in chosen if family.name == "delay" or family.room == "fullwave"), chosen[0])
    why = "exact for this scene" if best.name == "delay" else f"the delay system cannot do {_delay_refusal(scene)}"
    return best.example, why


def build(model: str, scene: Scene, cells: int | None = None, cfl: float | None = None, tolerance: float | None = None) -> Solver:
    """The solver called `model` for `scene`; `cells` and `cfl` are for full-wave models, `tolerance` for those that take one.

    Raises SceneError for an unknown model (naming the nearest), a number out of range after the colon, an option the model does
    not take, and a scene it cannot do (naming the models that can).
    """
    model, _ = resolve(model, scene)
    family, parameter = _parse(model)
    request = Request(parameter, cells, cfl, tolerance)
    _require_options(model, family, request)
    refusal = family.refusal(scene)
    if refusal:
        able = ", ".join(other.pattern for other in honouring(scene)) or "none of this installation"
        raise SceneError(f"model = {model!r}: cannot do {refusal} (scene {scene.name!r}); models that can: {able}")
    solver = family.make(scene, model, request)
    solver.model = model
    return solver


def build_all(
    models: str, scene: Scene, cells: int | None = None, cfl: float | None = None, tolerance: float | None = None
) -> list[Solver]:
    """The solvers of a comma-separated list of models; each is given the options it takes, and one of them must take each.

    Raises SceneError as `build` does, and for an empty or repeated name.
    """
    names = [resolve(name.strip(), scene)[0] for name in models.split(",")]
    repeated = [name for name in names if names.count(name) > 1]
    if repeated:
        raise SceneError(f"models = {models!r}: {repeated[0]} is named more than once")
    found = [_parse(name)[0] for name in names]
    given = Request(None, cells, cfl, tolerance).given(*_OPTIONS)
    for option, value in given.items():
        if not any(option in family.options for family in found):
            raise SceneError(f"{option} = {value:g}: none of the models {models} takes it")
    return [
        build(name, scene, **{option: value for option, value in given.items() if option in family.options})
        for name, family in zip(names, found, strict=True)
    ]


def _parse(model: str) -> tuple[Family, int | None]:
    from scene.input.wording import nearest, shorten

    name, colon, number = model.partition(":")
    family = next((family for family in families() if family.name == name), None)
    if family is None:
        known = ", ".join(["auto", *(family.pattern for family in families())])
        guess = nearest(name, [family.name for family in families()])
        hint = f'; did you mean "{guess}"?' if guess else ""
        raise SceneError(f"model = {shorten(model)}: must be one of {known}{hint}")
    if not family.parameters:
        if colon:
            raise SceneError(f"model = {shorten(model)}: {name} takes no number")
        return family, None
    if not (number.isascii() and number.isdigit() and len(number) < 9 and int(number) in family.parameters):
        raise SceneError(f"model = {shorten(model)}: must be {family.pattern} with {_numbers(family.parameters)}")
    return family, int(number)


def _numbers(allowed: range | tuple[int, ...]) -> str:
    if isinstance(allowed, range):
        return f"a whole number from {allowed.start} to {allowed.stop - 1}"
    return f"one of {', '.join(str(number) for number in allowed)}"


def _require_options(model: str, family: Family, request: Request) -> None:
    for name in _OPTIONS:
        value = getattr(request, name)
        if value is not None and name not in family.options:
            takers = ", ".join(other.pattern for other in families() if name in other.options)
            raise SceneError(f"{name} = {value:g}: model {model} takes no {name}; models that do: {takers}")
    if request.tolerance is not None and not 1e-14 <= request.tolerance <= 1e-1:
        raise SceneError(f"tolerance = {request.tolerance:g}: must be a number from 1e-14 to 0.1")


def _asked(scene: Scene) -> str:
    found = features_of(scene)
    return " and ".join(phrase for feature, phrase in FEATURES.items() if feature in found)


def _delay_refusal(scene: Scene) -> str:
    delay = next(family for family in _FAMILIES if family.name == "delay")
    return delay.refusal(scene) or "it is not part of this installation"
