"""Settles a model on its periodic orbit by running it until its cycles stop changing, with an error estimate.

A run converges at the rate of the orbit's largest Floquet multiplier and then stays at the solver's own jitter. The value is the
mean over the last few cycles, the error half of (largest - smallest) among them. It estimates the remaining transient, not the
discretisation error.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields

import numpy as np

from slipwave.errors import NumericsError
from slipwave.observe import EventObserver, Events
from slipwave.observe.events import NO_EVENTS
from slipwave.observe.pieces import Array
from slipwave.observe.statistics import Estimate, Orbit
from slipwave.solve import Solver
from validation.models.outlook import Ended, JudgedHalf, Length
from validation.models.run import simulate

WINDOW = 4
"""Cycles over which an orbit is judged."""

MOST_TRANSITS = 6000.0
_FIRST_STRETCH = 400.0
_STALLED = 3
_STEADY = 1e-3  # v_max/v_min - 1 below which a run has returned to steady sliding


@dataclass(frozen=True)
class Settled:
    """A model on its orbit, or as near as it came: `unrest` is the largest relative spread of the last cycles; `settled` is
    true if it is below the tolerance or at the jitter of the solver."""

    orbit: Orbit
    solver: Solver
    observer: EventObserver
    unrest: float
    settled: bool

    @property
    def transits(self) -> float:
        """Time marched so far (transits)."""
        return self.solver.time


class NoCycle(ArithmeticError):
    """The run has too few slip events for an orbit, or returned to steady sliding."""


@dataclass
class _UntilAlike(Length):
    """Run until `WINDOW` cycles in a row agree to `tolerance`, stop converging, or are those of steady sliding. `seen`: cycles of
    the latest half of the run, and their unrest after each stretch, of `WINDOW` periods."""

    tolerance: float
    cycles: Events = NO_EVENTS
    history: list[float] = field(default_factory=list)

    def ends(self, after: float) -> Iterator[float]:
        """As `Length`."""
        end = after
        while end < self.until:
            period = float(self.cycles.period[-1]) if self.cycles.period.size else _FIRST_STRETCH / WINDOW
            end = end + WINDOW * period if end + 2.0 * WINDOW * period <= self.until else self.until
            yield end

    def ended(self, now: JudgedHalf) -> Ended | None:
        """As `Length`."""
        self.cycles = now.cycles
        if self.has_cycles:
            table = _window(self.cycles)
            # the largest relative spread (max - min over mean) among these cycles
            self.history.append(float(np.max(np.ptp(table, axis=0) / np.abs(table.mean(axis=0)))))
        return "settled" if self.is_steady or self.finished else None

    @property
    def has_cycles(self) -> bool:
        """Whether there are enough to be judged."""
        return self.cycles.time.size >= WINDOW

    @property
    def is_steady(self) -> bool:
        """Whether the cycles are those of steady sliding."""
        return self.has_cycles and bool(self.cycles.v_max[-1] < (1.0 + _STEADY) * self.cycles.v_min[-1])

    @property
    def finished(self) -> bool:
        """Whether the cycles agree, or the best of the last stretches is no better than half of the best before."""
        history = self.history
        stalled = len(history) > 2 * _STALLED and min(history[-_STALLED:]) > 0.5 * min(history[:-_STALLED])
        return bool(history) and (history[-1] < self.tolerance or (stalled and history[-1] < 1e-5))


def settle(solver: Solver, tolerance: float = 1e-9, most: float = MOST_TRANSITS) -> Settled:
    """March `solver` (from its start) until `WINDOW` cycles in a row agree to `tolerance`, relative, in period, drops and rates,
    or stop converging from stretch to stretch (the solver's own jitter), or `most` transits are over. Raises NoCycle for fewer
    than WINDOW cycles, or if the run returned to steady sliding, NumericsError where the solver fails.
    """
    observer, length = EventObserver(solver.scene, solver.nodes), _UntilAlike(tolerance, until=most)
    run = simulate(solver, length, watch=observer)
    if run.failed:
        raise KeyboardInterrupt if run.stopped else NumericsError(run.failed)
    if not length.has_cycles:
        raise NoCycle(f"{solver.model}: {observer.count} slip events in {solver.time:.0f} transits, too few to speak of an orbit")
    if length.is_steady:
        raise NoCycle(f"{solver.model}: back to steady sliding after {solver.time:.0f} transits")
    return Settled(estimate(length.cycles), solver, observer, length.history[-1], length.finished)


def _window(events: Events) -> Array:
    """Last WINDOW cycles, rows; period, drops and rates, columns."""
    return np.array([getattr(events, field.name)[-WINDOW:] for field in fields(Orbit)]).T


def estimate(events: Events) -> Orbit:
    """Mean and half spread over the last WINDOW cycles."""
    table = _window(events)
    estimates = [Estimate(float(column.mean()), float(np.ptp(column)) / 2.0) for column in table.T]
    return Orbit(*estimates)
