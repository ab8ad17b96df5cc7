"""Floquet multipliers of a closed cycle: eigenvalues of its monodromy matrix, but for the trivial one, which is 1."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.orbit.closing import Closed
from slipwave.observe.pieces import Array

Complex = NDArray[np.complex128]

NEUTRAL = 1e-6
"""Distance of a multiplier's modulus from 1 below which stability is not decided."""

_AGREE = 1e-3
"""Two meshes must agree on a multiplier to this part of it, or it is not reported: eigenvalues of the essential spectrum never
do."""
_SMALLEST = 1e-6
"""Modulus below which a multiplier is lost in the errors of larger ones."""


class Multipliers(NamedTuple):
    """`values` (m,), largest modulus first, without the trivial one, whose distance from 1 is `trivial_defect`;
    `essential_radius` is the radius below which infinitely many accumulate (0 if there are finitely many); `stable` is None if
    the values cannot decide, with the `reason`."""

    values: Complex
    trivial_defect: float
    essential_radius: float
    stable: bool | None
    reason: str = ""


def multipliers(closed: Closed, coarser: Closed | None = None) -> Multipliers:
    """Multipliers of `closed` outside the essential radius; of these only those that a `coarser` mesh confirms."""
    values, defect = floquet(closed.monodromy)
    radius = closed.flow.essential_radius(closed.cycle)
    isolated = values[np.abs(values) > max(radius, _SMALLEST)]
    if coarser is not None:
        others = floquet(coarser.monodromy)[0]
        nearest = [np.abs(others - one).min() if others.size else np.inf for one in isolated]
        isolated = isolated[np.array(nearest, dtype=float) < _AGREE * np.abs(isolated)]
    stable, reason = _verdict(isolated, radius)
    return Multipliers(isolated, defect, radius, stable, reason)


def count_unstable(closed: Closed) -> int:
    """The number of all multipliers of `closed` outside the unit circle."""
    return int((np.abs(floquet(closed.monodromy)[0]) > 1.0).sum())


def floquet(monodromy: Array) -> tuple[Complex, float]:
    """Eigenvalues, largest modulus first, without the one nearest to 1; and its distance from 1."""
    values = np.linalg.eigvals(monodromy).astype(complex)
    trivial = int(np.abs(values - 1.0).argmin())
    rest = np.delete(values, trivial)
    return rest[np.argsort(-np.abs(rest), kind="stable")], float(abs(values[trivial] - 1.0))


def _verdict(isolated: Complex, radius: float) -> tuple[bool | None, str]:
    if radius > 1.0 - NEUTRAL:
        return None, (
            f"the waves' own multipliers reach a radius of {radius:.9f}: some motion of the slabs is never damped by friction, "
            "and multipliers cannot decide stability"
        )
    largest = float(np.abs(isolated).max(initial=0.0))
    if abs(largest - 1.0) < NEUTRAL:
        return None, f"the largest multiplier has modulus {largest:.9f}: neutral within the error of the computation"
    return largest < 1.0, ""
