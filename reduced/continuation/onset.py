"""Where steady sliding loses its stability as a parameter of the scene changes: the Hopf points, from the spectrum alone."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from reduced.stability.characteristic import characteristic
from reduced.stability.roots import polish
from reduced.stability.spectrum import leading_roots, unstable_count
from slipwave.errors import NumericsError
from slipwave.scene import Scene

_SAMPLES = 17
_HALVINGS = 8
WIDTH = 1e-13
"""Width of a bracket in the parameter."""


class Onset(NamedTuple):
    """Steady sliding at `parameter` has a pair of roots on the imaginary axis, with `period` (transits); the numbers of growing
    roots just below and above."""

    parameter: float
    period: float
    unstable_below: int
    unstable_above: int


def onsets(scene_at: Callable[[float], Scene], low: float, high: float, model: str) -> list[Onset]:
    """The Hopf points between the parameters `low` and `high`, in order, as far as sampling at equal distances separates them.

    Raises what reading a scene or finding its roots raises.
    """
    values = np.linspace(low, high, _SAMPLES)
    counts = [_unstable(scene_at, float(value), model) for value in values]
    changes = [k for k in range(_SAMPLES - 1) if counts[k] != counts[k + 1]]
    return [_between(scene_at, float(values[k]), float(values[k + 1]), counts[k], counts[k + 1], model) for k in changes]


def _between(scene_at: Callable[[float], Scene], low: float, high: float, below: int, above: int, model: str) -> Onset:
    """The change nearest to `low`: by counts at first, then by the zero of the crossing root's real part, which Newton's method
    follows from parameter to parameter."""
    from scipy.optimize import brentq

    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        count = _unstable(scene_at, middle, model)
        low, high = (middle, high) if count == below else (low, middle)
        above = above if count == below else count
    roots = leading_roots(characteristic(scene_at(low), model))
    crossing = complex(roots[np.abs(roots.real).argmin()])

    def root(value: float) -> complex:
        """The root of the spectrum that crosses the imaginary axis."""
        return complex(polish(characteristic(scene_at(value), model).jet, np.array([crossing]))[0])

    try:
        at = float(brentq(lambda value: root(value).real, low, high, xtol=WIDTH))
    except ValueError:  # both ends have the same sign
        raise NumericsError(
            f"{model}: the loss of stability between parameter = {low:.10g} and {high:.10g} is not a single pair of roots that "
            "crosses"
        ) from None
    return Onset(at, 2.0 * math.pi / abs(root(at).imag) / scene_at(at).transit, below, above)


def _unstable(scene_at: Callable[[float], Scene], value: float, model: str) -> int:
    return unstable_count(characteristic(scene_at(value), model))
