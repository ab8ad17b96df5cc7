"""The mean of a sequence whose neighbours depend on each other, with an error that knows it."""

import numpy as np

from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate


def mean_of(values: Array) -> Estimate:
    """Mean of a stationary sequence (n,) and its standard error, sigma sqrt(2 tau/n).

    The time tau = 1/2 + (sum of the autocorrelations) is summed in pairs of lags as long as these are positive (Geyer,
    Statistical Science 7, 1992): later ones are noise. Of independent values tau = 1/2.
    """
    count = values.size
    apart = values - values.mean()
    transformed = np.fft.rfft(apart, 2 * count)
    covariance = np.fft.irfft(np.abs(transformed) ** 2)[:count] / count
    pairs = covariance[: 2 * (count // 2)].reshape(-1, 2).sum(axis=1)
    kept = pairs[: int((pairs <= 0.0).argmax()) if (pairs <= 0.0).any() else None]
    variance = max(2.0 * float(kept.sum()) - float(covariance[0]), 0.0) / count
    return Estimate(float(values.mean()), float(np.sqrt(variance)))
