"""One cycle of the interface's motion: of a settled orbit, or the last complete one of a run."""

from typing import NamedTuple

from slipwave.friction import Law
from slipwave.observe import EventObserver, HistoryObserver
from slipwave.observe.history import named_columns
from slipwave.observe.pieces import Array, Pieces
from slipwave.solve import Observer, Solver, follow

_FIRST_MOST = 16  # chunks of pieces that are kept before the first check whether they are still needed


class OneCycle(NamedTuple):
    """A cycle's curves, arrays of equal length: time (transits) from the slip event's date, slip rate (V*), psi, mu, y; and its
    period."""

    time: Array
    slip_rate: Array
    psi: Array
    stress: Array
    elastic_stress: Array
    period: float


def cut(law: Law, samples: Array, date: float, period: float, before: float = 0.0, after: float = 0.0) -> OneCycle:
    """The part of `samples` (see `HistoryObserver`) that is the cycle of the event at `date`, with `before` transits ahead of it
    and `after` transits past its end."""
    inside = (samples[0] >= date - before) & (samples[0] <= date + period + after)
    columns = named_columns(law, samples[:, inside])
    return OneCycle(**columns | {"time": columns["time"] - date}, period=period)


def watch(solver: Solver, until: float, *others: Observer) -> EventObserver:
    """March `solver` to `until` (transits), observed by `others` too; returns the observer of the slip events. Raises
    NumericsError as `follow`."""
    observer = EventObserver(solver.scene, solver.nodes)
    follow(solver, until, [observer, *others])
    return observer


class CycleObserver:
    """Observer that keeps the last complete cycle and the present one: memory O(cycle). `watch`: the observer of the run's
    events, which sees the pieces first."""

    def __init__(self, solver: Solver, watch: EventObserver) -> None:
        self._law, self._watch = solver.scene.law, watch
        self._history = HistoryObserver(solver.scene.law, solver.nodes)
        self._most = _FIRST_MOST

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order."""
        self._history.scan(pieces)
        if len(self._history) > self._most:
            dates = self._watch.dates()
            if dates.size >= 3:
                self._history.forget(float(dates[-3]))  # the latest event may not be over
            self._most = 2 * len(self._history) + _FIRST_MOST

    def cycle(self, after: float) -> OneCycle | None:
        """The last complete cycle of the window from `after` (transits) to now, or None if there was none."""
        events = self._watch.events(after)
        if not events.time.size:
            return None
        return cut(self._law, self._history.samples(), float(events.time[-1]), float(events.period[-1]))
