"""All samples of a record of equal cycles, sorted by phase."""

from typing import NamedTuple

import numpy as np

from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from validation.data.events import noise_of
from validation.fit.cycles import MARGIN, dated_events

_ASTRAY = 0.1  # transits by which dates may differ from those of equal cycles, beyond the interval of two samples
MOST = 20_000
"""Most samples used; longer records are thinned."""

_TRIALS = 161  # periods, of which the one whose samples lie closest is taken


class FoldedRecord(NamedTuple):
    """Samples of a record of equal cycles: `times` since the first event and the number of the `cycle`, both (n,), `friction`;
    `period`; their `noise`."""

    times: Array
    cycle: Array
    friction: Array
    period: float
    noise: float

    @property
    def since(self) -> Array:
        """Times (n,) since the last event."""
        return self.times - self.period * self.cycle


def folded(name: str, times: Array, friction: Array, transit: float) -> FoldedRecord:
    """The samples of whole cycles away from events, sorted by phase. Raises SceneError for a record whose cycles are not
    equal."""
    dates = dated_events(name, times, friction).date
    count = np.arange(dates.size)
    period, first = np.polyfit(count, dates, 1)
    astray, step = float(np.std(dates - first - period * count)), float(np.median(np.diff(times)))
    if astray > step + _ASTRAY * transit:
        raise SceneError(
            f"{name!r}: slip events lie {astray / transit:.3g} transits off equal cycles; every wave can be fitted only to a "
            "motion that repeats: choose a part that does (--window), or a model without waves (quasidynamic)"
        )
    cycle = np.floor((times - first) / period)
    phase = (times - first) / period - cycle
    chosen = np.flatnonzero((cycle >= 0) & (cycle < dates.size - 1) & (phase > MARGIN) & (phase < 1.0 - MARGIN))
    chosen = chosen[:: -(-chosen.size // MOST)]
    since, cycle, values = times[chosen] - first, cycle[chosen], friction[chosen]

    def noise(longer: float) -> float:
        """Noise of the samples sorted by phase, for a period `longer` by this."""
        late = since - cycle * (period + longer)
        order = np.argsort(late, kind="stable")
        return noise_of(late[order], values[order])

    longer = min(np.linspace(-1.0, 1.0, _TRIALS) * 4.0 * max(astray, 0.1 * step) / dates.size, key=noise)
    order = np.argsort(since - cycle * (period + longer), kind="stable")
    return FoldedRecord(since[order], cycle[order], values[order], float(period + longer), noise(longer))
