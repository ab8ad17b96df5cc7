"""On which grids the full-wave families show their orders: one table, for the tests and for the report.

Interface outputs of elements converge up to twice as fast as declared and are at rounding after few grids. Two scenes keep enough
grids between the first ones that resolve the waves and rounding: both at V = 2000 V*, where a cycle lasts some four transits, so
that a short run holds many. The rougher one is for the declared orders from five on, the gentler one for the others.
"""

from dataclasses import dataclass
from functools import cache

import slipwave
from fullwave.families import FAMILIES, FullWave, Rungs
from slipwave.scene import Scene


@dataclass(frozen=True)
class Course:
    """What every grid of a ladder runs: the paper's material at V = 2000 V* from the smooth start, for `until` transits.

    The final state is that of the last `window` transits. `floor` is the relative error below which the reference is not trusted,
    `density` the number of grids per doubling of the cells, `slack` by how much the order of a single output may be fitted too
    low: on many grids 0.05 (0.03 was seen), on few ones 0.75 (0.55 was seen; with 1 an order less would pass)."""

    log10_r: float
    until: float
    window: float
    density: int
    slack: float
    floor: float = 2e-11

    @property
    def scene(self) -> Scene:
        """The scene to be run."""
        return _scene(self.log10_r)


@cache
def _scene(log10_r: float) -> Scene:
    return slipwave.read("paper", [f"slab.log10_r={log10_r}", "drive.velocity=2000"])


GENTLE = Course(-2.77, until=60.0, window=8.0, density=4, slack=0.05)
ROUGH = Course(-2.59, until=120.0, window=16.0, density=8, slack=0.75)
_ROUGH_FROM = 5.0  # declared order


@dataclass(frozen=True)
class GridLadder:
    """A family, the order `declared` in every output at the interface, the least order `promised` (elements: the declared one).

    Grids: `first` is the coarsest, `most` the most cells a slab worth trying; `finest` bounds the smallest relative errors."""

    model: str
    declared: float
    promised: float
    course: Course
    first: int
    most: int
    finest: float
    cfl: float | None = None

    def levels(self) -> list[int]:
        """Cells a slab from `first` to `most`, the course's `density` per doubling as far as whole numbers go."""
        cells = [self.first]
        while (finer := max(cells[-1] + 1, round(2 ** (1 / self.course.density) * cells[-1]))) <= self.most:
            cells.append(finer)
        return cells


def _ladder(family: FullWave, number: int, rungs: Rungs) -> GridLadder:
    declared = float(family.order_interface(number))
    course = ROUGH if declared >= _ROUGH_FROM else GENTLE
    first, most, finest, promised, cfl = rungs
    return GridLadder(family.called(number), declared, promised or declared, course, first, most, finest, cfl)


_ALL = [_ladder(family, number, rungs) for family in FAMILIES for number, rungs in family.ladder.items()]
LADDERS = {ladder.model: ladder for ladder in _ALL}
"""By the model's name on the command line. Leapfrog runs at CFL 0.5, where it is no rewriting of the delay system."""
