"""The error in time alone: both marches of one grid, each measured against the other."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slipwave.observe.pieces import Array
from slipwave.solve import Solver
from validation.measure.grid_ladders import GENTLE
from validation.measure.order_fit import Fit, fit_dense, shortfall
from validation.measure.orders import QUANTITIES, Measured, errors, measure
from validation.registry.build import build
from validation.registry.families import grid_of
from validation.studies.grid_convergence.marches import without_error_in_time
from validation.study import WITNESS, Cell, Table, Verdict, claim, holding, table
from validation.study.text import plain

_GRIDS = {"sbp:6": 32, "fem:4": 6, "dg:7": 3}
"""Cells on which the error in time is seen over several powers of ten."""

COURANT = tuple(2.0 ** (-k / 4) for k in range(1, 9))
REQUESTS = tuple(10.0**-k for k in range(4, 12))
"""Errors requested of the exact march."""

_FLOOR = 2e-12
_APART = {"sbp:6": 3e-10, "fem:4": 3e-10, "dg:7": 5e-12}
"""Allowed differences of the two marches; 2e-11, 3e-11 and 3e-13 were measured, the error of the shortest explicit steps."""

_EXCESS = 3e-11
"""Allowed error of the exact march beyond the requested one; 4e-12 was measured, at the smallest request."""


@dataclass(frozen=True)
class Marches:
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
    def declared(self) -> int:
        """That of its Runge-Kutta method."""
        family, number = grid_of(self.model)
        return family.order_in_time(number)

    @property
    def apart(self) -> float:
        """The largest relative difference of the exact march and of the shortest explicit steps, in any quantity."""
        return float(self.explicit[-1].max())

    @property
    def excess(self) -> float:
        """By how much errors of the exact march exceed the requested ones, at most; below 0 if none does. What the explicit steps
        leave is not counted."""
        return float((self.exact.max(axis=1) - self.apart - np.array(REQUESTS)).max())


def marches_of(model: str) -> Marches:
    """Run both marches of the grid of `model`."""
    scene, cells = GENTLE.scene, _GRIDS[model]

    def rows(make: Callable[[float], Solver], settings: tuple[float, ...], other: Measured) -> Array:
        """Errors against `other`, one row per setting."""
        return np.array([list(errors(measure(make(setting), GENTLE), other).values()) for setting in settings])

    def explicit(courant: float) -> Solver:
        """Steps of that share of the longest stable one."""
        return build(model, scene, cells=cells, cfl=courant, time="explicit")

    def exact(request: float) -> Solver:
        """Steps that resolve friction to that error."""
        return without_error_in_time(model, scene, cells, request)

    finest = measure(explicit(COURANT[-1]), GENTLE)
    without = measure(without_error_in_time(model, scene, cells), GENTLE)
    return Marches(model, rows(explicit, COURANT, without), rows(exact, REQUESTS, finest))


def both_marches() -> list[Marches]:
    """Both marches of every grid of the study."""
    return [marches_of(model) for model in _GRIDS]


def time_table(found: list[Marches]) -> Table:
    """One row per setting: the largest error of any quantity, by family."""
    rows: list[tuple[Cell, ...]] = []
    for name, settings in (("explicit", COURANT), ("exact", REQUESTS)):
        sizes = np.array([getattr(one, name).max(axis=1) for one in found]).T
        rows += [(name, setting, *map(float, row)) for setting, row in zip(settings, sizes, strict=True)]
    named = [f"`{one.model}`, {_GRIDS[one.model]} cells .0e" for one in found]
    caption = (
        "Error in time alone, on one grid of each family (scene s): the largest relative error of T, Δμ, Δy, v_{max} and the "
        "state. Explicit march: its Courant number, errors against the exact march. Exact march: the error requested of it, "
        "errors against the explicit march with its shortest steps."
    )
    return table("time", caption, " | ".join(["march | setting .2g", *named]), rows)


def time_verdicts(found: list[Marches]) -> list[Verdict]:
    """Order of the explicit march, agreement of the two, and the error requested of the exact one."""
    return [*(_order_verdict(one) for one in found), *(_agreement(one) for one in found), _requested(found)]


def _order_verdict(one: Marches) -> Verdict:
    short = shortfall(one.order, one.declared, tolerance=0.5, at_least=True, widest=1.0)
    title = "On one grid the explicit march approaches the exact one at the order of its Runge-Kutta method"
    remark = f"`{one.model}` with {_GRIDS[one.model]} cells, Courant numbers from {COURANT[0]:.2f} down to {COURANT[-1]:.2f}"
    return holding(title, WITNESS, f"{one.declared} or more", one.order.rounded, not short, remark)


def _agreement(one: Marches) -> Verdict:
    title = "The exact and the explicit march of one grid agree in every output"
    remark = f"`{one.model}` with {_GRIDS[one.model]} cells; the worst of {len(QUANTITIES)} quantities"
    return claim(title, WITNESS, one.apart, _APART[one.model], remark)


def _requested(found: list[Marches]) -> Verdict:
    title = "The exact march keeps the error requested of it, measured by the explicit march of the same grid"
    remark = f"the largest excess; requests from {plain(REQUESTS[0], '.0e')} to {plain(REQUESTS[-1], '.0e')}"
    return claim(title, WITNESS, max(one.excess for one in found), _EXCESS, remark)


TIME_NOTE = (
    "The explicit march shares neither its steps nor its friction solve with the exact one. The delay system has its friction "
    "step in common with the exact march (`slipwave/step`): a mistake in it would show in the comparison of the two marches, not "
    "in that with the delay system."
)
