"""The mean of a correlated sequence, with its error."""

from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate, margin_of_mean


def mean_of(values: Array) -> Estimate:
    """Mean of a stationary sequence (n,), n of 8 or more, and its error: half of the 95 % margin, that is, 1.3 times the standard
    deviation of such means, and up to 1.9 times that for few values. Twice the error covers the mean of 95 in 100 sequences."""
    return Estimate(float(values.mean()), 0.5 * margin_of_mean(values))
