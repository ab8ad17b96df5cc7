"""Statistics of a run's cycles."""

from dataclasses import dataclass

import numpy as np

from slipwave.observe.events import Events
from slipwave.observe.pieces import Array


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation over cycles; NaN if there are no cycles."""

    mean: float
    std: float


@dataclass(frozen=True)
class RunStatistics:
    """Period (transits), stress drop, elastic stress drop, extreme slip rates (V*) over `cycles` cycles."""

    cycles: int
    period: Spread
    stress_drop: Spread
    elastic_stress_drop: Spread
    v_max: float
    v_min: float


def summarise(events: Events) -> RunStatistics:
    """Statistics of all cycles in `events`."""
    return RunStatistics(
        cycles=events.time.size,
        period=_spread(events.period),
        stress_drop=_spread(events.stress_drop),
        elastic_stress_drop=_spread(events.elastic_stress_drop),
        v_max=float(events.v_max.max()) if events.time.size else np.nan,
        v_min=float(events.v_min.min()) if events.time.size else np.nan,
    )


def _spread(values: Array) -> Spread:
    return Spread(float(values.mean()), float(values.std())) if values.size else Spread(np.nan, np.nan)
