"""The registry's rows: every family of models, what builds it, what it takes and which scenes it honours.

Adding a model means adding its row to FAMILIES and, unless it shares one, its builder. Solver modules are imported only when one
is built.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from slipwave.errors import SceneError
from slipwave.observe import Solver
from slipwave.scene import Scene
from validation.registry.features import FEATURES, features_of

OPTIONS = ("cells", "cfl", "tolerance")
"""The numerical options that a family may take."""


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
    `options` the numerical options it takes, `honours` the scene features it can do (keys of FEATURES), `grids` the cells per
    slab that a benchmark tries, `suited` the number after the colon for a tolerance, where the name may be given without one."""

    pattern: str
    module: str
    title: str
    make: Callable[[Scene, str, Request], Solver]
    honours: frozenset[str]
    options: tuple[str, ...]
    parameters: range | tuple[int, ...] = ()
    default: int | None = None
    grids: tuple[int, ...] = ()
    suited: Callable[[float], int] | None = None

    def chosen(self, tolerance: float | None) -> int | None:
        """The number after the colon where the user left it open."""
        return self.default if tolerance is None or self.suited is None else self.suited(tolerance)

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
    from reduced.delay.system import delay_system

    return delay_system(scene, **request.given("tolerance"))


def _ladder(scene: Scene, model: str, request: Request) -> Solver:
    from reduced.impedance import reduction_of
    from reduced.ode.march import ReducedModel

    return ReducedModel(scene, reduction_of(scene, model), **request.given("tolerance"))


def _leapfrog(scene: Scene, model: str, request: Request) -> Solver:
    from fullwave.finite_difference import Leapfrog

    return _grid(Leapfrog, scene, request)


def _by_parts(scene: Scene, model: str, request: Request) -> Solver:
    from fullwave.summation_by_parts import SummationByParts

    return _grid(SummationByParts, scene, request, order=_number(request))


def _elements(scene: Scene, model: str, request: Request) -> Solver:
    from fullwave.finite_element import FiniteElement

    return _grid(FiniteElement, scene, request, degree=_number(request))


def _galerkin(scene: Scene, model: str, request: Request) -> Solver:
    from fullwave.discontinuous import DiscontinuousGalerkin

    return _grid(DiscontinuousGalerkin, scene, request, degree=_number(request))


def _grid(kind: Callable[..., Any], scene: Scene, request: Request, **shape: int) -> Solver:
    """A full wave on the grid asked for, or on one fine enough for the tolerance: then `choice` tells which and how good."""
    if request.tolerance is None:
        solver: Solver = kind(scene, **shape, **request.given("cells", "cfl"))
        return solver
    if request.cells is not None:
        raise SceneError(f"tolerance = {request.tolerance:g}: chooses the cells itself; leave out cells = {request.cells}")
    from fullwave.adapt import to_tolerance

    chosen, choice = to_tolerance(scene, request.tolerance, kind, **shape, **request.given("cfl"))
    chosen.choice = choice  # type: ignore[attr-defined]
    return chosen


def _number(request: Request) -> int:
    assert request.parameter is not None
    return request.parameter


def _degree_for(tolerance: float) -> int:
    from fullwave.adapt import degree_for

    return degree_for(tolerance)


def _highest_order(tolerance: float) -> int:
    return 6


_ODE = ("tolerance",)
_GRID = ("cells", "cfl", "tolerance")
_RIGID = frozenset({"unlike"})
_LOSSLESS = _RIGID | {"layers"}
_ELASTIC = _LOSSLESS | {"grip", "reflection"}
_ANY = frozenset(FEATURES)
_SPRUNG = _ANY - {"reflection"}

FAMILIES = (
    Family("delay", "reduced.delay.system", "the exact wave physics of elastic slabs as a delay system", _delay, _ELASTIC, _ODE),
    Family("quasistatic", "reduced.ode.march", "no waves, no inertia: runs away when unstable", _ladder, _SPRUNG, _ODE),
    Family("quasidynamic", "reduced.ode.march", "no waves, radiation damping", _ladder, _SPRUNG, _ODE),
    Family("block8", "reduced.ode.march", "spring and block of mass rho h/8", _ladder, _RIGID, _ODE),
    Family("block12", "reduced.ode.march", "spring and block of mass rho h/12", _ladder, _LOSSLESS, _ODE),
    Family("kelvin-voigt", "reduced.ode.march", "the paper's ODE, one Kelvin-Voigt element", _ladder, _RIGID, _ODE),
    Family("modal:N", "reduced.ode.march", "the slabs' first N exact modes", _ladder, _LOSSLESS, _ODE, range(65), 2),
    Family("fitted:N", "reduced.ode.march", "passive rational fit of the exact impedance", _ladder, _ANY, _ODE, range(65), 4),
    Family("fd", "fullwave.finite_difference", "full wave: staggered leapfrog", _leapfrog, _ANY, _GRID, grids=(16, 32, 64)),
    Family(
        "sbp:P",
        "fullwave.summation_by_parts",
        "full wave: summation by parts",
        _by_parts,
        _ANY,
        _GRID,
        (2, 4, 6),
        default=6,
        grids=(16, 32, 64),
        suited=_highest_order,
    ),
    Family(
        "fem:P",
        "fullwave.finite_element",
        "full wave: finite elements",
        _elements,
        _ANY,
        _GRID,
        range(1, 17),
        default=4,
        grids=(2, 4, 8),
        suited=_degree_for,
    ),
    Family(
        "dg:P",
        "fullwave.discontinuous",
        "full wave: discontinuous Galerkin",
        _galerkin,
        _ANY,
        _GRID,
        range(1, 25),
        default=7,
        grids=(1, 2, 4),
        suited=_degree_for,
    ),
)
"""Cheapest first; `auto` takes the first that is exact."""
