"""Statistics of a run over the complete cycles of its second half."""

from dataclasses import dataclass

import numpy as np

from scene.observe.events import Events
from scene.observe.pieces import Array


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation over cycles; NaN when there is none."""

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


def summarise(events: Events, after: float) -> RunStatistics:
    """Statistics of the cycles that start at or after `after` (transits)."""
    keep = events.time >= after

    def spread(values: Array) -> Spread:
        """Mean and standard deviation over the chosen cycles."""
        chosen = values[keep]
        return Spread(float(chosen.mean()), float(chosen.std())) if chosen.size else Spread(np.nan, np.nan)

    found = bool(keep.any())
    return RunStatistics(
        cycles=int(keep.sum()),
        period=spread(events.period),
        stress_drop=spread(events.stress_drop),
        elastic_stress_drop=spread(events.elastic_stress_drop),
        v_max=float(events.v_max[keep].max()) if found else np.nan,
        v_min=float(events.v_min[keep].min()) if found else np.nan,
    )
