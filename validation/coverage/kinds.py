"""Kinds of stated errors: random scenes of known truth, and how many of them are recorded and repeated."""

from collections.abc import Callable
from typing import NamedTuple
from zlib import crc32

import numpy as np

from slipwave.errors import NumericsError, SceneError
from validation.coverage.held import Held
from validation.coverage.irregular import exponents, irregular_means
from validation.coverage.repeating import WITNESS as KNOWING
from validation.coverage.repeating import any_orbit, chosen_grid, default_grid, limits_of_grids, steps
from validation.measure.settle import NoCycle
from validation.study import SELF, WITNESS, Evidence


class Kind(NamedTuple):
    """A kind of stated error: whose `bar`, the `truth` it is held against, the `evidence` that this is, how one computation is
    `measure`d, how many are `recorded`, and how many of them a report `repeated`ly makes. An irregular motion is not `exact`ly
    repeated on another machine."""

    bar: str
    truth: str
    evidence: Evidence
    measure: Callable[[np.random.Generator], list[Held]]
    recorded: int
    repeated: int
    exact: bool = True


_KNOWN = f"delay system; with viscosity `{KNOWING}`"
KINDS = {
    "orbits": Kind("`slipwave orbit`: error of each figure", "a mesh three times finer", SELF, any_orbit, 110, 6),
    "tolerances": Kind("`--tol` of models without a grid", "the orbit, by Newton’s method", SELF, steps, 250, 4),
    "chosen grids": Kind("`--tol` of full waves: estimated error", _KNOWN, WITNESS, chosen_grid, 135, 4),
    "default grids": Kind("default grids of full waves: estimated error", _KNOWN, WITNESS, default_grid, 110, 4),
    "extrapolation": Kind("Richardson’s limit of three grids", "delay system", WITNESS, limits_of_grids, 104, 4),
    "means": Kind("means of motions that never repeat: margin", "1000 cycles more", SELF, irregular_means, 165, 1, False),
    "exponents": Kind("largest Lyapunov exponents: margin", "600 intervals more", SELF, exponents, 175, 1, False),
}
"""Kinds by name."""

LEFT_OUT = {("chosen grids", 50)}
"""Computations that are not made: this one had not ended after 90 s of processor time, on hundreds of cells. What it would say is
not known."""


def computation(kind: str, number: int) -> list[Held]:
    """Computation `number` of a kind: the same whenever it is repeated. Empty where there is nothing to be held: no orbit, or a
    motion of another sort; and if it is LEFT_OUT."""
    if (kind, number) in LEFT_OUT:
        return []
    try:
        return KINDS[kind].measure(np.random.default_rng([crc32(kind.encode()), number]))
    except (NumericsError, SceneError, NoCycle):
        return []
