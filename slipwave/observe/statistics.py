"""Statistics of a run's cycles, and the quantities of a periodic motion.

Neighbouring cycles of a motion that never repeats depend on each other, so that std/sqrt(n) would be no error of the mean. The
cycles are divided in order into a few batches. Means of batches longer than this dependence are independent, and their scatter
gives the interval of their mean (Student's distribution). The autocorrelations of the cycles give another interval, corrected for
the bias of a short run, whose own mean is subtracted, and for the few independent windows in it. Where the run is only a few
times as long as its memory, neither sees how long that is: a third interval takes the memory to fade geometrically. The widest
counts.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from slipwave.observe.events import Events
from slipwave.observe.pieces import Array

FEWEST = 8
"""Fewest values whose mean has a margin."""

BATCHES = 6
_CONFIDENCE = 0.95
_OF_FADING = 0.97  # where memory is slow, 95 % would cover the mean in 94 of 100 runs, because its own estimate is uncertain
_BELOW, _ITERATIONS = 1.95, 6  # less than Student's quantile of any freedom; of Newton's method from there
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_FREEDOM, _LEFT = 3.0, 0.25  # least that a window as long as the run leaves: independent values, and share of the variance


@dataclass(frozen=True)
class Estimate:
    """A value and its error; for a settled run the error is half of (max - min) over the last cycles."""

    value: float
    error: float


@dataclass(frozen=True)
class Orbit:
    """The outputs of a run (MODEL.md section 6): period in transits, drops in units of the normal stress, rates in V*."""

    period: Estimate
    stress_drop: Estimate
    elastic_stress_drop: Estimate
    v_max: Estimate
    v_min: Estimate

    def values(self) -> dict[str, float]:
        """Name -> value."""
        return {field.name: getattr(self, field.name).value for field in fields(self)}


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation over cycles; NaN if there are no cycles."""

    mean: float
    std: float


@dataclass(frozen=True)
class RunStatistics:
    """Period (transits), stress drop, elastic stress drop, extreme slip rates (V*) over `cycles` cycles, the median of their
    largest slip rates, which has no heavy tail, and their mean, as a record has it; `margins`: half the widths of the 95 %
    intervals of the means and of the median over cycles that never repeat, by name; NaN for others."""

    cycles: int
    period: Spread
    stress_drop: Spread
    elastic_stress_drop: Spread
    v_max: float
    v_min: float
    v_max_median: float
    v_max_mean: float
    margins: Mapping[str, float]

    @property
    def spreads(self) -> dict[str, Spread]:
        """Name -> the figures that have a mean and a standard deviation."""
        return {"period": self.period, "stress_drop": self.stress_drop, "elastic_stress_drop": self.elastic_stress_drop}

    def values(self) -> dict[str, float]:
        """The figures by name: means and extremes."""
        return {name: float(spread.mean) for name, spread in self.spreads.items()} | {"v_max": self.v_max, "v_min": self.v_min}


def summarise(events: Events, repeat: bool = True) -> RunStatistics:
    """Statistics of all cycles in `events`; their means have margins unless the cycles `repeat`."""
    figures = (events.period, events.stress_drop, events.elastic_stress_drop)
    middle = float(np.median(events.v_max)) if events.time.size else math.nan
    halves = (math.nan,) * 4 if repeat else (*map(margin_of_mean, figures), _margin_of_median(events.v_max))
    margins = dict(zip(("period", "stress_drop", "elastic_stress_drop", "v_max_median"), halves, strict=True))
    if not events.time.size:
        nothing = Spread(np.nan, np.nan)
        return RunStatistics(0, nothing, nothing, nothing, np.nan, np.nan, np.nan, np.nan, margins)
    period, drop, elastic_drop = (Spread(float(values.mean()), float(values.std())) for values in figures)
    extremes = float(events.v_max.max()), float(events.v_min.min())
    return RunStatistics(events.time.size, period, drop, elastic_drop, *extremes, middle, float(events.v_max.mean()), margins)


def margin_of_mean(values: Array) -> float:
    """Half the width of the 95 % interval of the mean of `values` (cycles, in order); NaN for fewer than FEWEST values.

    The widest of three margins: that by batches is too narrow where correlations last longer than a batch, that by
    autocorrelations where neighbours alternate or the memory is not much shorter than the run, that by a fading memory without
    one. Alone, each covers the mean in fewer than 95 of 100 runs."""
    if values.size < FEWEST:
        return math.nan
    means = np.array([batch.mean() for batch in np.array_split(values, BATCHES)])
    by_batches = _quantile(BATCHES - 1.0) * float(means.std(ddof=1)) / math.sqrt(BATCHES)
    return max(by_batches, _by_autocorrelations(values), _by_fading_memory(values))


def _margin_of_median(values: Array) -> float:
    """The same of their median: what the quantiles differ by between which the share of values above the median lies, within half
    of its own margin."""
    if values.size < FEWEST:
        return math.nan
    share = 0.5 * margin_of_mean((values > np.median(values)).astype(float))
    low, high = np.quantile(values, np.clip((0.5 - share, 0.5 + share), 0.0, 1.0))
    return float(high - low)


def _by_autocorrelations(values: Array) -> float:
    """From the variance of the mean, 2 tau variance/n. The time tau = 1/2 + (sum of the autocorrelations) is summed in pairs of
    lags as long as these are positive (Geyer, Statistical Science 7, 1992): later ones are noise.

    Covariances about the run's own mean lack the variance of this mean at each of the w lags (of both signs): the sum is (1 -
    w/n) of the true one. It is as uncertain as a variance of n/w independent values, or of n/(2 tau) if these are fewer
    (Priestley, Spectral Analysis and Time Series, 1981, section 6.2)."""
    count, variance = values.size, float(values.var())
    covariance = variance * autocorrelations(values - values.mean())
    pairs = covariance[: 2 * (count // 2)].reshape(-1, 2).sum(axis=1)
    kept = pairs[: int((pairs <= 0.0).argmax()) if (pairs <= 0.0).any() else None]
    spread = 2.0 * float(kept.sum()) - variance
    if spread <= 0.0:
        return 0.0
    window = 4.0 * kept.size - 1.0
    spread /= max(1.0 - window / count, _LEFT)
    freedom = min(count / window, count * variance / spread - 1.0)
    return _quantile(max(freedom, _FREEDOM)) * math.sqrt(spread / count)


def _by_fading_memory(values: Array) -> float:
    """From x' = p x + noise, whose mean over n values has the variance noise^2/(n (1 - p)^2) and n (1 - p)/(1 + p) independent
    ones. The regression on the run itself is low by (1 + 3 p)/n for small p (Marriott and Pope, Biometrika 41, 1954), by 5.3/n
    at p = 1 (Dickey and Fuller, J. Am. Stat. Assoc. 74, 1979)."""
    count, deviations = values.size, values - values.mean()
    before, after = deviations[:-1], deviations[1:]
    squares = float(deviations @ deviations)
    memory = float(after @ before) / squares if squares else 0.0
    memory = min(memory + (1.0 + 4.3 * memory) / count, 1.0 - 1.0 / count)
    if memory <= 0.0:
        return 0.0
    noise = after - memory * before
    variance = float(noise @ noise) / (count - 2.0) / (1.0 - memory) ** 2
    freedom = max(count * (1.0 - memory) / (1.0 + memory) - 1.0, _FREEDOM)
    return _quantile(freedom, _OF_FADING) * math.sqrt(variance / count)


def autocorrelations(values: Array) -> Array:
    """Sums of products of `values` (n,) at each lag from 0 to n - 1, relative to that at lag 0; 0 if all values are 0."""
    sums = np.fft.irfft(np.abs(np.fft.rfft(values, 2 * values.size)) ** 2)[: values.size]
    return np.asarray(sums / (float(values @ values) or 1.0))


def _quantile(freedom: float, share: float = _CONFIDENCE) -> float:
    """Two-sided quantile of Student's distribution, sqrt(freedom) tan(angle): the integral of cos(x)^(freedom - 1) from 0 to this
    angle is a `share` of that to pi/2. By Newton's method, from below; to import scipy.special takes as long as a short run."""
    whole = 0.5 * math.sqrt(math.pi) * math.exp(math.lgamma(0.5 * freedom) - math.lgamma(0.5 * freedom + 0.5))
    angle = math.atan(_BELOW / math.sqrt(freedom))
    for _ in range(_ITERATIONS):
        inside = 0.5 * angle * float(_WEIGHTS @ np.cos(0.5 * angle * (_POINTS + 1.0)) ** (freedom - 1.0))
        angle += (share * whole - inside) / math.cos(angle) ** (freedom - 1.0)
    return math.sqrt(freedom) * math.tan(angle)
