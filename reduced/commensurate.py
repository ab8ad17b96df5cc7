"""Whether the travel times of a scene's waves are commensurate: whole multiples of one time."""

import numpy as np

from slipwave.observe.pieces import Array

_SAME = 1e-9  # of the longest time


def common_divisor(times: Array, most_parts: int) -> float | None:
    """Longest time that divides all `times`; None if it is shorter than the shortest of them over `most_parts`: `times` then
    count as incommensurate."""
    shortest = float(times.min())
    for parts in range(1, most_parts + 1):
        counts = times * (parts / shortest)
        if np.abs(counts - np.round(counts)).max() < _SAME * counts.max():
            return shortest / parts
    return None
