"""The facts of every full wave, cheapest first. To add a discretisation, write its file and add its entry here.

The class of a full wave is called as (scene, number, cells=, cfl=), without a number if its name has none. Orders hold for a
smooth start; with a jump every grid is of order 1 only.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from fullwave.options import require_whole
from slipwave.errors import SceneError
from slipwave.family import ANYTHING, Exact, Family, PlotStyle


class Rungs(NamedTuple):
    """Grids that measure a member's order: the `first` (coarsest) and the `most` cells per slab; a bound of the `finest` errors;
    the least order `promised`, if not the declared one; the Courant number, if not that of the family."""

    first: int
    most: int
    finest: float
    promised: float | None = None
    cfl: float | None = None


class AttackCells(NamedTuple):
    """Cells for the study stability-attacks: a `coarse` grid for long marches (step limits do not depend on it), and a `fine` one
    for comparisons with the delay system."""

    coarse: int
    fine: int


def _degree_for(tolerance: float) -> int:
    """Cheapest degree of elements near `tolerance`, measured on the paper's scene at log10 r = -2.68, -2.6 and -2.3: 5 at 1e-4,
    one more for every two digits."""
    return max(3, math.floor(3.5 - 0.5 * math.log10(tolerance)))


@dataclass(frozen=True)
class FullWave(Family):
    """A family on a grid; functions take the number after the colon (0 if there is none).

    `order_bulk` is the order of the fields inside a slab, `order_interface` that of every output at the interface (for elements a
    lower bound), `order_at_best` its upper bound (default: the same); `points` is the number of nodes in a cell. `number_is`:
    what messages call the number. `implicit_state`: friction's state does not limit the step. `conserves`: the energy balance
    closes to rounding, otherwise the scheme dissipates at its order. `cells` and `cfl` are defaults; `cfl`, at most 1, is in
    units of `step`. `attacks` and `ladder`, by number: the members in the studies of stability and of orders."""

    honours: frozenset[str] = ANYTHING
    exact: Exact = Exact.ON_FINE_GRIDS
    options: tuple[str, ...] = ("cells", "cfl", "time", "tolerance")
    tolerances: tuple[float, float] = (1e-12, 0.1)  # below, rounding hides the differences between grids
    order_bulk: Callable[[int], int] = lambda p: 2
    order_interface: Callable[[int], int] = lambda p: 2
    order_at_best: Callable[[int], int] | None = None
    points: Callable[[int], int] = lambda p: 1
    number_is: str = "degree"
    implicit_state: bool = False
    conserves: bool = False
    cells: int = 16
    cfl: float = 0.9
    step: str = "the longest stable step"
    attacks: Mapping[int, AttackCells] = field(default_factory=dict)
    ladder: Mapping[int, Rungs] = field(default_factory=dict)

    @property
    def usual(self) -> int:
        """The default number; 0 if names have none."""
        return self.default or 0

    def require_number(self, number: object) -> None:
        """Raises SceneError, which names the number by `number_is`, unless there is a member with it."""
        if isinstance(self.numbers, range):
            require_whole(self.number_is, number, self.numbers[0], self.numbers[-1])
        elif self.numbers and number not in self.numbers:
            raise SceneError(f"{self.number_is} = {number!r}: must be one of {', '.join(map(str, self.numbers))}")

    def order_in_time(self, number: int) -> int:
        """Order of the Runge-Kutta method that does not limit the order of the scheme.

        Second-order schemes use the classical method of order 4; the order-8 method would cost them 50 % more. All others use
        order 8: elements of order P + 1 give the interface's outputs at up to order 2 P + 1, and differences of order 4 would
        lose a factor of five in accuracy with order 4 in time."""
        return 4 if self.order_interface(number) <= 2 else 8


_OF_ELEMENTS = {
    1: Rungs(24, 280, 5e-5),
    2: Rungs(2, 100, 1e-8),
    3: Rungs(2, 60, 1e-9),
    4: Rungs(2, 50, 1e-9),
    5: Rungs(2, 40, 1e-9),
    6: Rungs(2, 30, 1e-9),
    7: Rungs(2, 24, 1e-9),
}

LEAPFROG = FullWave(
    "fd",
    "fullwave.finite_difference:Leapfrog",
    "full wave: staggered leapfrog",
    "h^2",
    grids=(16, 32, 64),
    styles={None: PlotStyle("#d55e00", (0, (1, 2.2)), "s", 2.0)},
    implicit_state=True,
    conserves=True,
    options=("cells", "cfl", "tolerance"),
    cells=64,
    cfl=1.0,
    step="dx / c",
    attacks={0: AttackCells(12, 64)},
    ladder={0: Rungs(24, 280, 5e-5, cfl=0.5)},
)
BY_PARTS = FullWave(
    "sbp:P",
    "fullwave.summation_by_parts:SummationByParts",
    "full wave: summation-by-parts differences of order P",
    "h^P",
    numbers=(2, 4, 6),
    number_is="order",
    default=6,
    suited=lambda tolerance: 6,
    grids=(16, 32, 64),
    styles={None: PlotStyle("#0072b2", "-", "D")},
    order_bulk=lambda p: p,
    order_interface=lambda p: p,
    cells=32,
    attacks={2: AttackCells(12, 64), 4: AttackCells(12, 32), 6: AttackCells(16, 32)},
    ladder={2: Rungs(24, 280, 5e-5, 1.95), 4: Rungs(16, 260, 1e-8, 3.9), 6: Rungs(17, 170, 1e-9)},
)
ELEMENTS = FullWave(
    "fem:P",
    "fullwave.finite_element:FiniteElement",
    "full wave: continuous finite elements of degree P",
    "h^(P+1) or better at the interface",
    numbers=range(1, 17),
    default=4,
    suited=_degree_for,
    grids=(2, 4, 8),
    extra="fem",
    styles={None: PlotStyle("#009e73", "-", "^")},
    order_bulk=lambda p: p + p % 2,
    order_interface=lambda p: p + 1,
    order_at_best=lambda p: 2 * p,
    points=lambda p: p,
    cells=8,
    attacks={1: AttackCells(12, 64), 4: AttackCells(3, 8)},
    ladder=_OF_ELEMENTS,
)
GALERKIN = FullWave(
    "dg:P",
    "fullwave.discontinuous:DiscontinuousGalerkin",
    "full wave: discontinuous Galerkin elements of degree P",
    "h^(P+1) or better",
    numbers=range(1, 25),
    default=7,
    suited=_degree_for,
    grids=(1, 2, 4),
    styles={None: PlotStyle("#a6761d", "-", "P")},
    order_bulk=lambda p: p + 1,
    order_interface=lambda p: p + 1,
    order_at_best=lambda p: 2 * p,
    points=lambda p: p + 1,
    cells=4,
    cfl=0.75,
    attacks={3: AttackCells(3, 8), 4: AttackCells(2, 8), 7: AttackCells(2, 4)},
    ladder=_OF_ELEMENTS,
)
FAMILIES: list[FullWave] = [
    LEAPFROG,
    BY_PARTS,
    ELEMENTS,
    GALERKIN,
]
"""The built-in families; those of other packages and files are appended (`validation.models.own`)."""


def facts_of(name: str) -> FullWave:
    """The family called `name`, without colon and number. Raises KeyError if there is none."""
    return {family.name: family for family in FAMILIES}[name]
