"""Statistics of a run's cycles, and the quantities of a motion that repeats, whichever method gives them.

Neighbouring cycles of a motion that never repeats depend on each other, so that std/sqrt(n) would be no error of the mean. The
cycles are divided in order into batches. Means of batches longer than this dependence are independent, and their scatter gives
the interval of their mean (Student's distribution).
"""

import math
from dataclasses import dataclass, field, fields

import numpy as np

from slipwave.observe.events import Events
from slipwave.observe.pieces import Array

BATCHES = 8
_CONFIDENCE = 0.95


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
class Margins:
    """Half the widths of the 95 % intervals of the means over cycles that never repeat; NaN for others."""

    period: float = math.nan
    stress_drop: float = math.nan
    elastic_stress_drop: float = math.nan


@dataclass(frozen=True)
class RunStatistics:
    """Period (transits), stress drop, elastic stress drop, extreme slip rates (V*) over `cycles` cycles; `margins` of means."""

    cycles: int
    period: Spread
    stress_drop: Spread
    elastic_stress_drop: Spread
    v_max: float
    v_min: float
    margins: Margins = field(default_factory=Margins)

    def values(self) -> dict[str, float]:
        """The figures by name: means and extremes."""
        means = {name: float(getattr(self, name).mean) for name in ("period", "stress_drop", "elastic_stress_drop")}
        return means | {"v_max": self.v_max, "v_min": self.v_min}


def summarise(events: Events, repeat: bool = True) -> RunStatistics:
    """Statistics of all cycles in `events`; their means have margins unless the cycles `repeat`."""
    figures = (events.period, events.stress_drop, events.elastic_stress_drop)
    margins = Margins() if repeat else Margins(*map(margin_of_mean, figures))
    if not events.time.size:
        nothing = Spread(np.nan, np.nan)
        return RunStatistics(0, nothing, nothing, nothing, np.nan, np.nan, margins)
    period, drop, elastic_drop = (Spread(float(values.mean()), float(values.std())) for values in figures)
    extremes = float(events.v_max.max()), float(events.v_min.min())
    return RunStatistics(events.time.size, period, drop, elastic_drop, *extremes, margins)


def margin_of_mean(values: Array) -> float:
    """Half the width of the 95 % interval of the mean of `values` (cycles, in order); NaN for fewer than BATCHES values."""
    if values.size < BATCHES:
        return math.nan
    from scipy.special import stdtrit

    means = np.array([batch.mean() for batch in np.array_split(values, BATCHES)])
    quantile = float(stdtrit(BATCHES - 1, 0.5 * (1.0 + _CONFIDENCE)))
    return quantile * float(means.std(ddof=1)) / math.sqrt(BATCHES)
