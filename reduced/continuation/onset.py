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
_STEPS_OUT = 12  # by factors of four
ONSET_WIDTH = 1e-13
"""Width of a bracket in the parameter."""


class Onset(NamedTuple):
    """Steady sliding at `parameter` has a pair of roots +-2 pi i/`period` (transits); numbers of growing roots on both sides."""

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
    """The change nearest to `low`: by counts at first, then by the zero of the crossing root's real part."""
    from scipy.optimize import brentq

    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        count = _unstable(scene_at, middle, model)
        low, high = (middle, high) if count == below else (low, middle)
        above = above if count == below else count
    roots = leading_roots(characteristic(scene_at(low), model))
    crossing = complex(roots[np.abs(roots.real).argmin()])

    def root(value: float) -> complex:
        return complex(polish(characteristic(scene_at(value), model).jet, np.array([crossing]))[0])

    def rate(value: float) -> float:
        return root(value).real

    low, high = _bracket(rate, low, high)
    if rate(low) * rate(high) > 0.0:
        between = f"parameter = {low:.10g} and {high:.10g}"
        raise NumericsError(f"{model}: the loss of stability between {between} is not a single pair of roots that crosses")
    at = float(brentq(rate, low, high, xtol=ONSET_WIDTH))
    return Onset(at, 2.0 * math.pi / abs(root(at).imag) / scene_at(at).transit, below, above)


def _bracket(rate: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """`low` and `high`, or the end where the root is nearly neutral, and not counted, and a value a little beyond it."""
    if rate(low) * rate(high) <= 0.0:
        return low, high
    end, other = (low, high) if abs(rate(low)) < abs(rate(high)) else (high, low)
    for k in range(_STEPS_OUT, 0, -1):
        beyond = end + 4.0**-k * (end - other)
        if rate(beyond) * rate(end) <= 0.0:
            return min(beyond, end), max(beyond, end)
    return low, high


def _unstable(scene_at: Callable[[float], Scene], value: float, model: str) -> int:
    return unstable_count(characteristic(scene_at(value), model))
