"""Residuals of the full wave's energy ledgers on each grid, and their entries over two cycles."""

from dataclasses import dataclass

import numpy as np

import slipwave
from slipwave.observe.pieces import Array
from slipwave.solve import Energy, FieldSolver, follow
from validation.measure.cycle import watch
from validation.measure.order_fit import Fit, fit_order
from validation.registry.build import build_full_wave
from validation.registry.families import explicit_time

ENTRIES = ("input", "friction", "stored", "radiated", "viscous")
"""Entries of the ledger, in the order in which they are shown."""

UNTIL = 200.0
"""Transits after which the residual is taken."""

_ROUNDING = 10.0
"""Residuals below 100 machine epsilons times this are rounding."""


LADDERS = {
    "fd": (6, 12, 24, 48, 96),
    "sbp:2": (24, 32, 48, 64, 96),
    "fem:1": (24, 32, 48, 64, 96),
    "fem:2": (4, 6, 8, 12, 16, 24),
    "dg:1": (8, 12, 16, 24, 32, 48),
    "dg:2": (4, 6, 8, 12, 16),
}
"""By model: cells per slab of the grids on which the residual is taken."""

ORDERS = {"sbp:2": 4.0, "fem:1": 4.0, "fem:2": 4.0, "dg:1": 3.0, "dg:2": 5.0}
"""The order at which the ledger of a model that does not conserve energy closes: that of the square of the jumps at its upwind
interfaces. Continuous fields jump at the slabs' ends only, by the error of the fields: order 2 in `sbp:2` and `fem:1`, and in
`fem:2` too (order P for even P). `dg:P` jumps by h^(P + 1) at each of 1/h faces: order 2 P + 1."""

HIGH = {"sbp:4": 48, "sbp:6": 48, "fem:4": 8, "dg:4": 8, "dg:7": 4}
"""Families of high degree and their cells."""

BOUNDARIES = {"rigid faces": "paper", "grips": "grip", "viscous": "viscous"}
"""By what takes the energy: gallery name of the scene."""


@dataclass(frozen=True)
class EnergyRun:
    """Entries of the ledger (sigma L) since the first moment of `time` (transits), over two periods."""

    period: float
    time: Array
    entries: dict[str, Array]

    def total(self, entry: str) -> float:
        """What `entry` grew by over the two cycles."""
        return float(self.entries[entry][-1])

    def share(self, entry: str) -> float:
        """The same as a fraction of the input."""
        return self.total(entry) / self.total("input")


def residual_of(model: str, cells: int, name: str = "rigid faces") -> float:
    """Size of the ledger's residual after `UNTIL` transits, relative to the largest entry."""
    solver = build_full_wave(model, slipwave.read(BOUNDARIES[name]), cells=cells, time=explicit_time(model))
    follow(solver, UNTIL)
    return abs(_ledger(solver).residual)


def ledger_order(model: str, residual: Array) -> Fit:
    """The order of the residuals above rounding; ValueError if fewer than four are."""
    return fit_order(np.array(LADDERS[model]), residual, _ROUNDING)


def history_of(name: str, cells: int) -> EnergyRun:
    """The ledger's entries over two cycles of the settled orbit, from the end of a run on; linear between ends of steps."""
    solver = build_full_wave("dg:7", slipwave.read(BOUNDARIES[name]), cells=cells, time="exact")
    solver.keep_ledger()
    period = float(watch(solver, 2400.0).events().period[-1])
    begin = solver.time
    moments = np.linspace(begin, begin + 2.0 * period, 1000)
    rows = [_entries(solver)]
    for moment in moments[1:]:
        if moment > solver.time:
            follow(solver, moment)
            rows.append(_entries(solver))
    time, *entries = np.array(rows).T
    found = (np.interp(moments, time, entry - entry[0]) for entry in entries)
    return EnergyRun(period, moments - begin, dict(zip(ENTRIES, found, strict=True)))


def _ledger(solver: FieldSolver) -> Energy:
    energy = solver.energy()
    if energy is None:
        raise ValueError(f"{solver.model}: keeps no ledger")
    return energy


def _entries(solver: FieldSolver) -> tuple[float, ...]:
    energy = _ledger(solver)
    return (solver.time, *(getattr(energy, entry) for entry in ENTRIES))
