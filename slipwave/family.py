"""The facts about a family of models, stated once, in `reduced/families.py` or `fullwave/families.py`.

`auto`, refusals, help texts, the README's tables, plot styles, benchmarks and studies all read them from there. Importing the
facts is light: a solver's module is only named, and is imported when a solver is built.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from slipwave.extras import missing, require

if TYPE_CHECKING:
    from slipwave.scene import Scene
    from slipwave.scene.slab import Slab

FEATURES = {
    "unlike": "unlike slabs",
    "grip": "a grip at the outer face",
    "reflection": "an outer face without a spring (a reflection coefficient below 1, a stiffness of 0)",
    "mass": "a mass on the outer face",
    "layers": "layers",
    "kelvin-voigt": "Kelvin-Voigt viscosity",
    "standard-linear": "standard-linear viscosity",
}
"""Name of every feature, with the phrase that describes it."""

NOTHING = frozenset[str]()
ANYTHING = frozenset(FEATURES)
"""All features; a family that honours none computes only two alike homogeneous elastic slabs with rigid faces."""


class Exact(StrEnum):
    """When a family's result is that of the wave physics in every scene that it honours."""

    TO_TOLERANCE = "to the tolerance"
    ON_FINE_GRIDS = "in the limit of a fine grid"
    NEVER = "never"


class PlotStyle(NamedTuple):
    """Colour, dashes (as in matplotlib), marker and line width of a model's curves in all figures; their label is its name."""

    color: str
    dashes: Any
    marker: str
    width: float = 1.3


@dataclass(frozen=True)
class Family:
    """`pattern` is the name as shown (`modal:N`), `made_by` the "module:name" of the function that makes a member, `error` the
    distance from the wave physics in words. `numbers` are allowed after the colon, and `default` is used in examples. If the name
    may be given without a number, `suited` chooses one for a tolerance. `tolerances` are the least and the largest allowed one.
    `styles` are keyed by number, None for all others. `grids` are the cells per slab that a benchmark tries. `extra` installs the
    libraries that it needs, if a light install leaves them out (`slipwave.extras`)."""

    pattern: str
    made_by: str
    title: str
    error: str = "of the model"
    honours: frozenset[str] = NOTHING
    exact: Exact = Exact.NEVER
    numbers: range | tuple[int, ...] = ()
    default: int | None = None
    suited: Callable[[float], int] | None = None
    options: tuple[str, ...] = ("tolerance",)
    tolerances: tuple[float, float] = (1e-14, 0.1)
    grids: tuple[int, ...] = ()
    extra: str = ""
    styles: Mapping[int | None, PlotStyle] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The part of the name before the colon."""
        return self.pattern.partition(":")[0]

    @property
    def module(self) -> str:
        """Name of the module that makes the members."""
        return self.made_by.partition(":")[0]

    @property
    def example(self) -> str:
        """A name that `build` accepts."""
        return self.called(self.default)

    def called(self, number: int | None) -> str:
        """The full name of the member with `number`, which is ignored if the family's names have no numbers."""
        return f"{self.name}:{number}" if self.numbers and number is not None else self.name

    def chosen(self, tolerance: float | None) -> int | None:
        """The number after the colon if the user gave none."""
        return self.default if tolerance is None or self.suited is None else self.suited(tolerance)

    def maker(self, number: int | None = None) -> Callable[..., Any]:
        """The function that makes members; imports the solver. Raises SceneError, which names the member with `number`, if a
        library of `extra` is missing."""
        if self.extra:
            require(self.extra, f"model = {self.called(self.default if number is None else number)!r}")
        made: Callable[..., Any] = getattr(import_module(self.module), self.made_by.partition(":")[2])
        return made

    @property
    def is_installed(self) -> bool:
        """Whether the libraries of `extra` are installed."""
        return not (self.extra and missing(self.extra))

    def refusal(self, scene: "Scene") -> str:
        """Why this family cannot compute `scene`; empty if it can."""
        return in_words(features_of(scene) - self.honours)


def features_of(scene: "Scene") -> frozenset[str]:
    """The features of `scene` (keys of FEATURES)."""
    unlike = set[str]() if scene.alike else {"unlike"}
    return frozenset(unlike.union(*map(_slab_features, scene.slabs)))


def in_words(features: frozenset[str]) -> str:
    """Phrases for `features`, joined; empty if there are none."""
    return " and ".join(phrase for feature, phrase in FEATURES.items() if feature in features)


def _slab_features(slab: "Slab") -> set[str]:
    held, solid = slab.termination, slab.rheology
    kinds = {
        "grip": held.spring > 0.0,
        "reflection": held.has_dead_load,
        "mass": held.mass > 0.0,
        "layers": len(slab.layers) > 1,
        "kelvin-voigt": solid.blocks_fast_waves,
        "standard-linear": solid.relaxation > 0.0,
    }
    return {kind for kind, present in kinds.items() if present}
