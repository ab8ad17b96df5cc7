"""How far the mean of cycles that never repeat may be from the mean of an endless run.

Neighbouring cycles depend on each other, so std/sqrt(n) would be wrong. The cycles are divided in order into batches. Means of
batches longer than this dependence are independent, and their scatter gives the interval of their mean (Student's distribution).
"""

import math

import numpy as np

from slipwave.observe.pieces import Array

BATCHES = 8
_CONFIDENCE = 0.95


def margin_of_mean(values: Array) -> float:
    """Half the width of the 95 % interval of the mean of `values` (cycles, in order), by batch means; NaN for fewer than
    BATCHES values."""
    if values.size < BATCHES:
        return math.nan
    from scipy.special import stdtrit

    means = np.array([batch.mean() for batch in np.array_split(values, BATCHES)])
    quantile = float(stdtrit(BATCHES - 1, 0.5 * (1.0 + _CONFIDENCE)))
    return quantile * float(means.std(ddof=1)) / math.sqrt(BATCHES)
