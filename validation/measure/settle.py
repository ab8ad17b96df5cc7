"""Settles a model on its periodic orbit by running it until its cycles stop changing, with an error estimate.

A run converges at the rate of the orbit's largest Floquet multiplier and then stays at the solver's own jitter. The value is the
mean over the last few cycles, the error half of (largest - smallest) among them. It estimates the remaining transient, not the
discretisation error.
"""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass, fields

import numpy as np

from slipwave.observe import EventObserver, Events, HistoryObserver
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.solve import Solver, follow
from slipwave.solve.follow import Foresight
from validation.measure.cycle import OneCycle, cut
from validation.measure.stopwatch import timed

SYMBOLS = {"period": "T", "stress_drop": "Δμ", "elastic_stress_drop": "Δy", "v_max": "v_{max}", "v_min": "v_{min}"}
"""The figures of an orbit, and their symbols."""

WINDOW = 4
"""Cycles over which an orbit is judged."""
MOST_TRANSITS = 6000.0
_FIRST_STRETCH = 400.0
_STALLED = 3
_STEADY = 1e-3  # v_max/v_min - 1 below which a run has returned to steady sliding


@dataclass(frozen=True)
class Settled:
    """A model on its orbit, or as near as it came: `unrest` is the largest relative spread of the last cycles; `settled` is
    true if it is below the tolerance or at the jitter of the solver; processor time of the march, in seconds."""

    orbit: Orbit
    solver: Solver
    observer: EventObserver
    cycles: int
    unrest: float
    settled: bool
    seconds: float

    @property
    def transits(self) -> float:
        """Time marched so far (transits)."""
        return self.solver.time


class NoCycle(ArithmeticError):
    """The run has too few slip events for an orbit, or returned to steady sliding."""


def settle(
    solver: Solver, tolerance: float = 1e-9, most: float = MOST_TRANSITS, progress: Callable[[float], None] | None = None
) -> Settled:
    """March `solver` (from its start) until `WINDOW` cycles in a row agree to `tolerance`, relative, in period, drops and rates,
    or stop converging from stretch to stretch (the solver's own jitter), or `most` transits are over. Raises NoCycle for fewer
    than WINDOW cycles, or if the run returned to steady sliding, NumericsError where the solver fails.
    """
    observer = EventObserver(solver.scene, solver.nodes)
    seconds, (events, history) = timed(lambda: _march_until_settled(solver, observer, tolerance, most, progress))
    if events.time.size < WINDOW:
        raise NoCycle(f"{solver.model}: {observer.count} slip events in {solver.time:.0f} transits, too few to speak of an orbit")
    return Settled(estimate(events), solver, observer, observer.count - 1, history[-1], _finished(history, tolerance), seconds)


def _march_until_settled(
    solver: Solver, observer: EventObserver, tolerance: float, most: float, progress: Callable[[float], None] | None
) -> tuple[Events, list[float]]:
    """(cycles of the second half of the march, the unrest after each stretch of WINDOW cycles)."""
    events = observer.events()
    history: list[float] = []
    foresight = Foresight(solver, most)
    while solver.time < most and not _finished(history, tolerance):
        period = float(events.period[-1]) if events.period.size else _FIRST_STRETCH / WINDOW
        follow(solver, min(most, solver.time + WINDOW * period), [observer, foresight], progress)
        events = observer.events(0.5 * solver.time)  # judged by the present falls: those of the start may have been larger
        if events.time.size >= WINDOW:
            if events.v_max[-1] < (1.0 + _STEADY) * events.v_min[-1]:
                raise NoCycle(f"{solver.model}: back to steady sliding after {solver.time:.0f} transits")
            history.append(unrest(events))
    return events, history


def _finished(history: list[float], tolerance: float) -> bool:
    return bool(history) and (history[-1] < tolerance or (_stalled(history) and history[-1] < 1e-5))


def _stalled(history: list[float]) -> bool:
    """Whether the best of the last stretches is no better than half of the best before."""
    return len(history) > 2 * _STALLED and min(history[-_STALLED:]) > 0.5 * min(history[:-_STALLED])


def _window(events: Events) -> Array:
    """Last WINDOW cycles, rows; period, drops and rates, columns."""
    return np.array([getattr(events, field.name)[-WINDOW:] for field in fields(Orbit)]).T


def unrest(events: Events) -> float:
    """Largest relative spread (max - min over mean) among the last WINDOW cycles."""
    table = _window(events)
    return float(np.max(np.ptp(table, axis=0) / np.abs(table.mean(axis=0))))


def estimate(events: Events) -> Orbit:
    """Mean and half spread over the last WINDOW cycles."""
    table = _window(events)
    estimates = [Estimate(float(column.mean()), float(np.ptp(column)) / 2.0) for column in table.T]
    return Orbit(*estimates)


def one_cycle(settled: Settled, before: float = 0.0, after: float = 0.0, per_piece: int = 8) -> OneCycle:
    """A cycle of the next two periods, from `before` transits ahead of its event to `after` transits past its end. The solver's
    state is restored."""
    solver, observer, period = settled.solver, deepcopy(settled.observer), settled.orbit.period.value
    begin, here = solver.time, solver.state()
    history = HistoryObserver(solver.scene.law, solver.nodes)
    follow(solver, begin + 2.02 * period + before + after, [history, observer])
    solver.restore(here)
    dates = observer.dates()
    date = float(dates[dates >= begin + before][0])
    return cut(solver.scene.law, history.samples(per_piece), date, period, before, after)
