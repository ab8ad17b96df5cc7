"""Every model on its settled orbit, with one cycle of it."""

from typing import NamedTuple

import slipwave
from slipwave.observe.orbit import Orbit
from validation.measure.cycle import Cycle
from validation.measure.settle import Settled, one_cycle, settle
from validation.registry.build import build

LOG10_R = -2.68
CELLS, CFL = 128, 0.5


class CycleRun(NamedTuple):
    """A model on its orbit and one cycle of it."""

    settled: Settled
    cycle: Cycle

    @property
    def orbit(self) -> Orbit:
        """Its figures."""
        return self.settled.orbit


def error(own: CycleRun, exact: CycleRun, quantity: str) -> float:
    """Relative error of `quantity` (a field of Orbit)."""
    return own.orbit.values()[quantity] / exact.orbit.values()[quantity] - 1.0


def run_model(model: str) -> CycleRun:
    """Settle `model` on its orbit of the paper's scene, then follow one cycle."""
    scene = slipwave.read("paper")
    solver = build(model, scene, cells=CELLS, cfl=CFL) if model == "fd" else build(model, scene, tolerance=1e-10)
    settled = settle(solver, tolerance=1e-10)
    return CycleRun(settled, one_cycle(settled, before=4.0, after=4.0, per_piece=2 if model == "fd" else 12))
