"""The grids on which the orders of full-wave families are measured: one table, for tests and report.

Interface outputs of elements converge up to twice as fast as declared and are at rounding after few grids. Two scenes leave
enough grids between the first one that resolves the waves and rounding. Both have V = 2000 V*, where a cycle lasts some four
transits and a short run holds many. The rougher scene is for declared orders from five on, the gentler one for the others. A
third one, steeper still, is for declared orders from seven on where the march has no error in time (`in_space`).
"""

from dataclasses import dataclass, replace
from functools import cache

import slipwave
from fullwave.families import FAMILIES, FullWave, Rungs
from slipwave.scene import Scene


@dataclass(frozen=True)
class LadderRun:
    """The run of every grid of a ladder: the paper's material at V = 2000 V* from the smooth start, for `until` transits.

    The final state is that of the last `window` transits. `floor`: relative error below which the reference is not trusted;
    `density`: number of grids per doubling of the cells; `slack`: by how much the fitted order of a single output may fall below
    the promised one: 0.05 on many grids (0.03 was measured), 0.75 on few (0.55 was measured; 1 would let an order less pass)."""

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


GENTLE = LadderRun(-2.77, until=60.0, window=8.0, density=4, slack=0.05)
ROUGH = LadderRun(-2.59, until=120.0, window=16.0, density=8, slack=0.75)
STEEP = LadderRun(-2.5, until=120.0, window=16.0, density=8, slack=0.75)
ROUGH_FROM, STEEP_FROM = 5.0, 7.0  # declared order
FLOOR_IN_SPACE = 5e-12
_UNDECLARED = 1e-2  # bound of the finest errors of a member without a ladder


@dataclass(frozen=True)
class GridLadder:
    """A family, the order `declared` in every output at the interface, the least order `promised` (elements: the declared one).

    Grids: `first` is the coarsest, `most` the most cells per slab to be tried; `finest` bounds the smallest relative errors."""

    model: str
    declared: float
    promised: float
    run: LadderRun
    first: int
    most: int
    finest: float
    cfl: float | None = None

    def levels(self) -> list[int]:
        """Cells per slab from `first` to `most`: `density` grids per doubling, or one cell more where that is less dense."""
        cells = [self.first]
        while (finer := max(cells[-1] + 1, round(2 ** (1 / self.run.density) * cells[-1]))) <= self.most:
            cells.append(finer)
        return cells


def in_space(ladder: GridLadder) -> GridLadder:
    """The ladder for a march without error in time, against a reference accurate to 1e-12: errors keep falling below those in
    time, at the full order of high degrees, which therefore need a steeper scene."""
    run = STEEP if ladder.declared >= STEEP_FROM else ladder.run
    return replace(ladder, run=replace(run, floor=FLOOR_IN_SPACE))


def _ladder(family: FullWave, number: int, rungs: Rungs) -> GridLadder:
    declared = float(family.order_interface(number))
    run = ROUGH if declared >= ROUGH_FROM else GENTLE
    first, most, finest, promised, cfl = rungs
    return GridLadder(family.called(number), declared, promised or declared, run, first, most, finest, cfl)


_ALL = [_ladder(family, number, rungs) for family in FAMILIES for number, rungs in family.ladder.items()]
LADDERS = {ladder.model: ladder for ladder in _ALL}
"""Name of a model -> its ladder. Leapfrog runs at CFL 0.5; at CFL 1 it is the delay system itself."""


def ladder_of(family: FullWave, number: int) -> GridLadder:
    """The ladder of any member: that of its family, else from half its usual cells to sixteen times as many."""
    usual = Rungs(max(2, family.cells // 2), 16 * family.cells, _UNDECLARED)
    return _ladder(family, number, family.ladder.get(number, usual))
