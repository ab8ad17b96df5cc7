"""The error in time: the exact and the explicit march of one grid, each compared with the other. They share neither steps nor
friction solve; the delay system has its friction step in common with the exact march."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from slipwave.solve import Solver
from validation.measure.grid_ladders import GENTLE
from validation.measure.grids.in_space import without_error_in_time
from validation.measure.order_fit import fit_dense
from validation.measure.orders import errors, measure
from validation.models.build import build
from validation.models.by_name import grid_of
from validation.report import WITNESS, Verdict, claim
from validation.report.known import of_order

COURANT = tuple(2.0 ** (-k / 4) for k in range(1, 9))
REQUESTS = tuple(10.0**-k for k in range(4, 12))
"""Errors requested of the exact march."""

GRIDS = {"sbp:6": 32, "fem:4": 6, "dg:7": 3}
"""By model: cells on which the error in time is seen over several powers of ten."""

STEPS = "On one grid the explicit march approaches the exact one at the order of its Runge-Kutta method"
MARCHES = "The exact and the explicit march of one grid agree in every output"
KEEPS = "The exact march keeps the error requested of it, measured by the explicit march of the same grid"
_RESOLUTION, _FLOOR, _ROUNDING = 1e-13, 2e-12, 1e-11


class Marches(NamedTuple):
    """Largest error of any output by one grid's marches: `explicit` (COURANT) against the exact march, `exact` (REQUESTS) against
    the shortest explicit steps."""

    model: str
    explicit: np.ndarray
    exact: np.ndarray


def marches_of(model: str) -> Marches:
    """Run both marches of the grid of `model`."""

    def explicit(courant: float) -> Solver:
        """The solver with steps of the share `courant` of the longest stable one."""
        return build(model, GENTLE.scene, cells=GRIDS[model], cfl=courant, time="explicit")

    def exact(request: float) -> Solver:
        """The solver with steps that resolve friction to the error `request`."""
        return without_error_in_time(model, GENTLE.scene, GRIDS[model], request)

    def largest(make: Callable[[float], Solver], settings: tuple[float, ...], other: Solver) -> np.ndarray:
        """The largest error of any output against the `other` march, by setting."""
        known = measure(other, GENTLE)
        return np.array([max(errors(measure(make(setting), GENTLE), known).values()) for setting in settings])

    return Marches(model, largest(explicit, COURANT, exact(_RESOLUTION)), largest(exact, REQUESTS, explicit(COURANT[-1])))


def time_verdicts(found: Marches) -> Iterator[Verdict]:
    """Order of the explicit march; the marches' distance, against what that order leaves of the longest steps' error; the largest
    error of an exact march over the requested one, which the explicit steps and rounding may add to."""
    (family, number), where = grid_of(found.model), f"`{found.model}` with {GRIDS[found.model]} cells"
    declared, apart = family.order_in_time(number), float(found.explicit[-1])
    order = fit_dense(1.0 / np.array(COURANT), found.explicit, 0, _FLOOR)
    yield of_order(STEPS, WITNESS, order, declared, where, within=0.5, above=True, widest=1.0)
    foreseen = found.explicit[0] * (COURANT[-1] / COURANT[0]) ** declared + _FLOOR
    yield claim(MARCHES, WITNESS, apart, float(foreseen), where)
    share = float((found.exact / (np.array(REQUESTS) + apart + _ROUNDING)).max())
    yield claim(KEEPS, WITNESS, share, 1.0, f"{where}; the largest error over its request")
