"""Statistics of a run's cycles."""

import math
from dataclasses import dataclass, field

import numpy as np

from slipwave.observe.events import Events
from slipwave.observe.margin import margin_of_mean
from slipwave.observe.pieces import Array


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
    return RunStatistics(
        cycles=events.time.size,
        period=_spread(events.period),
        stress_drop=_spread(events.stress_drop),
        elastic_stress_drop=_spread(events.elastic_stress_drop),
        v_max=float(events.v_max.max()) if events.time.size else np.nan,
        v_min=float(events.v_min.min()) if events.time.size else np.nan,
        margins=Margins() if repeat else Margins(*map(margin_of_mean, figures)),
    )


def _spread(values: Array) -> Spread:
    return Spread(float(values.mean()), float(values.std())) if values.size else Spread(np.nan, np.nan)
