"""Stated errors, true errors, and how often the former contain the latter."""

from collections.abc import Iterable
from itertools import groupby
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest

_CHANCE = 1e-15  # rounding error of what is taken for the truth, relative


class Held(NamedTuple):
    """A `figure` with its stated error `bar` and its true `error`, relative to the figure."""

    figure: str
    bar: float
    error: float


class Coverage(NamedTuple):
    """Coverage of a kind of `figure`: the number of bars (`many`), the `share` that contain the truth with its 95 % interval
    (Wilson), and `width`, the median ratio of bar to error."""

    figure: str
    many: int
    share: float
    low: float
    high: float
    width: float


def coverage_of(computations: Iterable[list[Held]]) -> list[Coverage]:
    """The coverage of each figure."""
    found = sorted((held for one in computations for held in one), key=lambda held: held.figure)
    return [_covered(figure, list(members)) for figure, members in groupby(found, key=lambda held: held.figure)]


def _covered(figure: str, group: list[Held]) -> Coverage:
    holds = sum(held.error <= held.bar for held in group)
    low, high = binomtest(holds, len(group)).proportion_ci(method="wilson")
    width = float(np.median([held.bar / max(held.error, _CHANCE) for held in group]))
    return Coverage(figure, len(group), holds / len(group), float(low), float(high), width)
