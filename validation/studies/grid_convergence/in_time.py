"""The error in time: the exact and the explicit march of one grid, each compared with the other."""

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array
from slipwave.solve import Solver
from validation.compute.build import build
from validation.compute.models import grid_of
from validation.measure.grid_ladders import GENTLE
from validation.measure.grids.in_space import RESOLUTION, without_error_in_time
from validation.measure.order_fit import Fit, fit_dense
from validation.measure.orders import QUANTITIES, Measured, errors, measure
from validation.study import WITNESS, Table, Verdict, claim, table
from validation.study.known import of_order
from validation.study.text import plain

COURANT = tuple(2.0 ** (-k / 4) for k in range(1, 9))
REQUESTS = tuple(10.0**-k for k in range(4, 12))
"""Errors requested of the exact march."""

GRIDS = {"sbp:6": 32, "fem:4": 6, "dg:7": 3}
"""By model: cells on which the error in time is seen over several powers of ten."""

_FLOOR = 2e-12


class Marches(NamedTuple):
    """Errors of one grid's marches, one row per setting and one column per quantity: `explicit` (COURANT) against the exact
    march, `exact` (REQUESTS) against the shortest explicit steps."""

    model: str
    explicit: Array
    exact: Array

    @property
    def order(self) -> Fit:
        """Order in time of the explicit march, in the quantity that is worst."""
        return fit_dense(1.0 / np.array(COURANT), self.explicit.max(axis=1), 0, _FLOOR)

    @property
    def apart(self) -> float:
        """The largest relative difference of the exact march and of the shortest explicit steps, in any quantity."""
        return float(self.explicit[-1].max())

    @property
    def foreseen(self) -> float:
        """The error of the shortest explicit steps that the longest lead to at the declared order, and rounding."""
        family, number = grid_of(self.model)
        return float(self.explicit[0].max() * (COURANT[-1] / COURANT[0]) ** family.order_in_time(number) + _FLOOR)

    @property
    def excess(self) -> float:
        """Largest excess of the exact march's errors over the requested ones, negative if there is none; without the error of the
        explicit steps."""
        return float((self.exact.max(axis=1) - self.apart - np.array(REQUESTS)).max())


def marches_of(model: str) -> Marches:
    """Run both marches of the grid of `model`."""
    scene, cells = GENTLE.scene, GRIDS[model]

    def rows(make: Callable[[float], Solver], settings: tuple[float, ...], other: Measured) -> Array:
        """Errors against `other`, one row per setting."""
        return np.array([list(errors(measure(make(setting), GENTLE), other).values()) for setting in settings])

    def explicit(courant: float) -> Solver:
        """The solver with steps of the share `courant` of the longest stable one."""
        return build(model, scene, cells=cells, cfl=courant, time="explicit")

    def exact(request: float) -> Solver:
        """The solver with steps that resolve friction to the error `request`."""
        return without_error_in_time(model, scene, cells, request)

    finest, without = (measure(solver, GENTLE) for solver in (explicit(COURANT[-1]), exact(RESOLUTION)))
    return Marches(model, rows(explicit, COURANT, without), rows(exact, REQUESTS, finest))


def time_table(found: Sequence[Marches]) -> Table:
    """One row per setting: the largest error of any quantity, by family."""
    rows = (
        (name, setting, *(float(getattr(one, name)[k].max()) for one in found))
        for name, settings in (("explicit", COURANT), ("exact", REQUESTS))
        for k, setting in enumerate(settings)
    )
    named = [f"`{one.model}`, {GRIDS[one.model]} cells .0e" for one in found]
    caption = (
        "Error in time alone, on one grid of each family (scene s): the largest relative error of T, Δμ, Δy, v_{max} and the "
        "state. Explicit march: its Courant number, errors against the exact march. Exact march: the error requested of it, "
        "errors against the explicit march with its shortest steps."
    )
    return table("time", caption, " | ".join(["march | setting .2g", *named]), rows)


def time_verdicts(found: Sequence[Marches]) -> Iterator[Verdict]:
    """Order of the explicit march, agreement of the two, and the error requested of the exact one."""
    grid = {one.model: f"`{one.model}` with {GRIDS[one.model]} cells" for one in found}
    approaches = "On one grid the explicit march approaches the exact one at the order of its Runge-Kutta method"
    for model, one in zip(grid, found, strict=True):
        family, number = grid_of(model)
        declared = family.order_in_time(number)
        remark = f"{grid[model]}, Courant numbers from {COURANT[0]:.2f} down to {COURANT[-1]:.2f}"
        yield of_order(approaches, WITNESS, one.order, declared, remark, within=0.5, above=True, widest=1.0)
    agree = "The exact and the explicit march of one grid agree in every output"
    for model, one in zip(grid, found, strict=True):
        yield claim(agree, WITNESS, one.apart, one.foreseen, f"{grid[model]}; the worst of {len(QUANTITIES)} quantities")
    keeps = "The exact march keeps the error requested of it, measured by the explicit march of the same grid"
    remark = f"the largest excess; requests from {plain(REQUESTS[0], '.0e')} to {plain(REQUESTS[-1], '.0e')}"
    yield claim(keeps, WITNESS, max(one.excess for one in found), REQUESTS[-1], remark)


TIME_NOTE = (
    "The explicit march shares neither its steps nor its friction solve with the exact one. The delay system has its friction "
    "step in common with the exact march (`slipwave/step`): a mistake in it would show in the comparison of the two marches, not "
    "in that with the delay system."
)
