"""Checks of a user's options for a grid: whole numbers in a range, a Courant number in (0, 1]."""

import math
import numbers

from slipwave.errors import SceneError

MOST_CELLS = 1_000_000
LEAST_CFL = 1e-9


class AnyShare(float):
    """A `cfl` that may exceed 1, for studies of steps beyond the limit; users' options are never converted to it."""


class CellsRefused(SceneError):
    """A number of cells that a grid does not accept: too few, or too many for the memory."""


def require_whole(name: str, value: object, least: int, most: int) -> None:
    """Raises SceneError unless `value` is a whole number from `least` to `most`."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or not least <= int(value) <= most:
        refusal = CellsRefused if name == "cells" else SceneError
        raise refusal(f"{name} = {value!r}: must be a whole number from {least} to {most}")


def require_cfl(cfl: object) -> None:
    """Raises SceneError unless `cfl` is a number in (0, 1], or an `AnyShare`, and at least LEAST_CFL; smaller steps would be lost
    in rounding."""
    most = math.inf if isinstance(cfl, AnyShare) else 1.0
    if isinstance(cfl, bool) or not isinstance(cfl, numbers.Real) or not 0.0 < float(cfl) <= most:
        raise SceneError(f"cfl = {cfl!r}: must lie in (0, 1]")
    if float(cfl) < LEAST_CFL:
        raise SceneError(f"cfl = {cfl!r}: must be at least {LEAST_CFL:g}; with shorter steps no run would end")
