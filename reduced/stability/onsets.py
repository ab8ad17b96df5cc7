"""Where steady sliding loses its stability as a parameter of the scene changes: the Hopf points, from the spectrum alone."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from reduced.stability.characteristic import Characteristic, characteristic
from reduced.stability.crossing import between
from reduced.stability.spectrum import follow_root, leading_roots, unstable_count
from slipwave.scene import Scene

_SAMPLES = 17
_HALVINGS = 8
_STEPS_OUT = 12  # by factors of four
_NEUTRAL = 1e-9  # of the rate at the other end
ONSET_WIDTH = 1e-13
"""Width of a bracket, relative to the parameter."""


class Onset(NamedTuple):
    """Steady sliding at `parameter` has a pair of roots +-2 pi i/`period` (transits); numbers of growing roots on both sides."""

    parameter: float
    period: float
    unstable_below: int
    unstable_above: int


def onsets(scene_at: Callable[[float], Scene], low: float, high: float, model: str) -> list[Onset]:
    """The Hopf points between the parameters `low` and `high`, in order; two of them between neighbouring samples, at equal
    distances, may be missed. Raises SceneError and NumericsError of the scenes and their roots.
    """

    def problem(value: float) -> Characteristic:
        return characteristic(scene_at(value), model)

    values = np.linspace(low, high, _SAMPLES).tolist()
    counts = [unstable_count(problem(value)) for value in values]
    hopf = list[tuple[float, float, int, int]]()
    for high, last, low, below in zip(values[1:], counts[1:], values, counts, strict=False):
        while below != last:
            beside, beyond, above = _narrowed(problem, low, high, below, last)
            if (above - below) % 2 == 0:  # else a single real root crosses, with which no orbit begins
                hopf.append((*_crossing(problem, beside, beyond), below, above))
            low, below = beyond, above
    return [Onset(at, 2.0 * math.pi / omega / scene_at(at).transit, below, above) for at, omega, below, above in hopf if omega]


def _narrowed(
    problem: Callable[[float], Characteristic], low: float, high: float, below: int, above: int
) -> tuple[float, float, int]:
    """The change of the count nearest to `low`, as a narrow bracket, and the count at its upper end."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        count = unstable_count(problem(middle))
        low, high = (middle, high) if count == below else (low, middle)
        above = above if count == below else count
    return low, high, above


def _crossing(problem: Callable[[float], Characteristic], low: float, high: float) -> tuple[float, float]:
    """The zero of the crossing root's real part between `low` and `high`, and its frequency."""
    roots = leading_roots(problem(low))
    crossing = complex(roots[np.abs(roots.real).argmin()])
    low, high = _bracket(lambda value: follow_root(problem(value), crossing).real, low, high)
    return between(problem, low, high, crossing)


def _bracket(rate: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Bracket of the zero of `rate`: `low` and `high`. If an end is nearly neutral, so that the sign of its rate is that of
    rounding, or its root was not counted, the bracket goes a little beyond it."""
    end, other = sorted((low, high), key=lambda value: abs(rate(value)))
    if abs(rate(end)) > _NEUTRAL * abs(rate(other)) and rate(end) * rate(other) < 0.0:
        return low, high
    for k in range(_STEPS_OUT, 0, -1):
        beyond = end + 4.0**-k * (end - other)
        if rate(beyond) * rate(other) < 0.0:
            return min(beyond, other), max(beyond, other)
    return low, high
