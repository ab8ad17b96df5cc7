"""Every full wave against an exact solution with waves, friction and state, imposed by the drive."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from validation.measure.manufactured import error_of_motion, given_scene
from validation.measure.order_fit import Fit, fit_order
from validation.report import EXACT, Verdict, claim
from validation.report.known import declared_order, of_order, points_of

_SECOND, _THIRD, _FOURTH = (32, 48, 64, 96, 128), (12, 16, 20, 24, 32), (10, 12, 14, 16, 18, 20)
GRIDS = {
    "fd": (_SECOND, 7e-5),
    "sbp:2": (_SECOND, 4e-4),
    "sbp:4": ((32, 40, 48, 64, 96), 4e-6),
    "sbp:6": ((36, 40, 44, 48, 56, 64), 8e-7),
    "fem:1": (_SECOND, 4e-4),
    "fem:2": (_THIRD, 1e-5),
    "fem:3": (_FOURTH, 3e-6),
    "fem:4": ((6, 8, 10, 12, 16), 8e-8),
    "dg:1": ((48, 64, 80, 96, 128), 4e-4),
    "dg:2": (_THIRD, 2e-5),
    "dg:3": (_FOURTH, 1.2e-6),
    "dg:4": ((6, 7, 8, 10, 12), 7e-7),
}
"""By model: cells per slab, and a bound of the error on the finest grid, twice that measured of unlike slabs."""

MARCHES = {"alike": "exact", "unlike": "explicit"}
"""Pair of slabs -> march in time, except for the leapfrog, which has one."""

MOTION = "Full waves make an exact motion with friction and state at their orders"
_CFL = 0.5  # of the leapfrog; at 1 it is the delay system


class Ladder(NamedTuple):
    """Errors of a model on its grids, for a pair of slabs, and their order."""

    model: str
    pair: str
    cells: np.ndarray
    errors: np.ndarray
    order: Fit


def climbed(model: str, pair: str) -> Ladder:
    """The errors on all grids."""
    scene, cells = given_scene(pair == "unlike"), GRIDS[model][0]
    options = {"cfl": _CFL} if model == "fd" else {"time": MARCHES[pair]}
    errors = np.array([error_of_motion(model, scene, count, **options) for count in cells])
    return Ladder(model, pair, np.array(cells, dtype=float), errors, fit_order(np.array(cells), errors))


def motion_verdicts(ladders: Sequence[Ladder]) -> Iterator[Verdict]:
    """The order of each, unless its finest error is not below the bound. Schemes of order 2 must not be better either."""
    for model, pair, cells, errors, order in ladders:
        bound = GRIDS[model][1]
        declared, where = declared_order(model), f"`{model}`, {pair} slabs"
        if errors[-1] < bound:
            yield of_order(MOTION, EXACT, order, declared, where, above=declared != 2)
        else:
            yield claim(MOTION, EXACT, float(errors[-1]), bound, f"{where}: error on {cells[-1]:g} cells")


def motion_errors(ladders: Sequence[Ladder]) -> dict[str, dict[str, tuple[np.ndarray, np.ndarray]]]:
    """Errors over points per slab, by pair of slabs and model."""
    found: dict[str, dict[str, tuple[np.ndarray, np.ndarray]]] = {}
    for model, pair, cells, errors, _ in ladders:
        found.setdefault(f"{pair} slabs", {})[model] = cells * points_of(model), errors
    return found
