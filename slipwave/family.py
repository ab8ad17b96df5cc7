"""A family of models as facts: stated once, in `reduced/families.py` or `fullwave/families.py`, and read by all who need them.

`auto`, refusals, help texts, the tables of the README, pens, benchmarks and studies ask a family and nobody else. Importing facts
is light: a solver's module is named here and imported only when one is built.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from slipwave.features import FEATURES, features_of

if TYPE_CHECKING:
    from slipwave.scene import Scene

NOTHING = frozenset[str]()
ANYTHING = frozenset(FEATURES)
"""Features that a family honours: none, so that it is for two alike homogeneous elastic slabs behind rigid faces; or all."""


class Exact(StrEnum):
    """Where a family's answer is that of the wave physics, in every scene that it honours."""

    TO_TOLERANCE = "to the tolerance"
    ON_FINE_GRIDS = "in the limit of a fine grid"
    NEVER = "never"


class Pen(NamedTuple):
    """How a model's curve looks everywhere; `dashes` as matplotlib takes them."""

    label: str
    color: str
    dashes: Any
    marker: str
    width: float = 1.3


@dataclass(frozen=True)
class Family:
    """`pattern` is the name as shown (`modal:N`), `made_by` the "module:name" of what makes a member, `error` how far it is from
    the wave physics. `numbers` may stand after the colon, `default` is taken for examples; where the name may be given without
    one, `suited` chooses it for a tolerance. `tolerances` are the least and the largest that may be asked for. `pens` are by
    number, or None for all others. `grids` are the cells per slab that a benchmark tries."""

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
    pens: Mapping[int | None, Pen] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The word before the colon."""
        return self.pattern.partition(":")[0]

    @property
    def module(self) -> str:
        """The module that makes its members."""
        return self.made_by.partition(":")[0]

    @property
    def example(self) -> str:
        """A name that `build` accepts."""
        return self.called(self.default)

    def called(self, number: int | None) -> str:
        """The full name of the member with `number`, which counts for nothing where names have none."""
        return f"{self.name}:{number}" if self.numbers and number is not None else self.name

    def chosen(self, tolerance: float | None) -> int | None:
        """The number after the colon where the user left it open."""
        return self.default if tolerance is None or self.suited is None else self.suited(tolerance)

    def maker(self) -> Callable[..., Any]:
        """What makes a member; imports the solver."""
        made: Callable[..., Any] = getattr(import_module(self.module), self.made_by.partition(":")[2])
        return made

    def refusal(self, scene: "Scene") -> str:
        """Why this family cannot do `scene`; empty if it can."""
        missing = features_of(scene) - self.honours
        return " and ".join(phrase for feature, phrase in FEATURES.items() if feature in missing)
