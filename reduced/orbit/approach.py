"""Marches a run near a periodic orbit, from which Newton's method starts. Some cycles are enough, settled or not; unstable orbits
lie near close returns of an irregular motion.
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple, Protocol

import numpy as np

from slipwave.errors import NumericsError
from slipwave.friction.law import ALWAYS_STABLE, friction_slopes
from slipwave.observe import EventObserver, Events
from slipwave.observe.pieces import SAME, Array
from slipwave.scene import Scene
from slipwave.solve import Solver, follow
from slipwave.solve.follow import Foresight
from slipwave.step.flow import Flow

MOST_TRANSITS = 6000.0
"""Transits after which a run without cycles is given up."""

_ALIKE = (1e-3, 1e-4, 1e-5)
"""Relative changes of period and size from cycle to cycle at which Newton's method starts: at the first; if that fails, at the
next."""

_SPREAD = 0.03  # relative spread of sizes up to which cycles that do not settle in time are those around an orbit
_LAST = 3
_CYCLES = 24  # after so many that still change, it starts from the mean of so many more
_RETURNS = 8  # closest returns from which an orbit is sought
_STRETCH = 200.0
_STEP = 0.05  # periods, from one look for the next event to the next; two events are further apart
_LATE = 10.0  # periods after which no further event is waited for
_STEADY = 1e-3  # v_max/v_min - 1 below which a run has returned to steady sliding


class FlowingSolver(Solver, Protocol):
    """A solver whose motion over a period is a differentiable map."""

    def flow(self, period: float, tolerance: float) -> tuple[Flow, Array]:
        """The map over a `period` (transits), on a mesh for figures with this relative error, and the present state."""


class Guess(NamedTuple):
    """Start of Newton's method: a `state` of `flow` between two slip events, where the motion is smooth, and a `period` of
    `cycles` cycles; whether the run had `settled`."""

    flow: Flow
    state: Array
    period: float
    settled: bool
    cycles: int = 1


def approach(
    solver: FlowingSolver, tolerance: float, most: float = MOST_TRANSITS, progress: Callable[[float], None] | None = None
) -> Guess:
    """March `solver` near its periodic orbit, for a flow of this `tolerance`. If its cycles keep changing, as near an unstable
    orbit, the guess is the mean of many of them, which lies near the unstable orbit inside a torus or between the cycles of a
    doubled one.

    Raises NumericsError if the run makes no cycles within `most` transits, or returns to steady sliding.
    """
    return next(guesses(solver, tolerance, most, progress))


def guesses(
    solver: FlowingSolver,
    tolerance: float,
    most: float = MOST_TRANSITS,
    progress: Callable[[float], None] | None = None,
    near: float | None = None,
) -> Iterator[Guess]:
    """Yield the guess of `approach`, then, if the cycles settle, guesses of the same run settled further: near a fold cycles
    hardly change though the orbit exists only at another parameter. If the cycles keep changing, yield the closest returns, of
    one cycle or of those that take about the period `near` (transits), which then come first: an irregular motion passes many
    unstable orbits, but the mean of its cycles is near none. The closest return, by the largest difference of a component of the
    state, comes first; with `near`, only of the half whose times are nearest to it.

    Raises NumericsError as `approach` does, and SceneError if the run would take too long."""
    observer, foresight = EventObserver(solver.scene, solver.nodes), Foresight(solver, most)
    for alike in _ALIKE:
        events = _cycles(solver, (observer, foresight), alike, most, progress)
        period = float(events.period.mean())
        cycles = 1 if near is None else max(1, round(near / period))
        if cycles > 1 or not (_settled(events, alike) or _drifts(events)):
            break
        period = float(events.period[-1])
        yield Guess(*_between(solver, observer, tolerance, period), period, _settled(events, alike))
    else:
        return
    flows, states, dates = _sections(solver, observer, tolerance, period)
    if near is None:
        yield Guess(flows[0], states.mean(axis=0), float(dates[-1] - dates[0]) / (dates.size - 1), False)
    periods = dates[cycles:] - dates[:-cycles]
    sought = np.arange(periods.size)
    if near is not None:
        sought = np.argsort(np.abs(periods - near), kind="stable")[: (periods.size + 1) // 2]
    gaps = np.abs(states[cycles:] - states[:-cycles]).max(axis=1)
    for k in sought[np.argsort(gaps[sought], kind="stable")][:_RETURNS]:
        yield Guess(flows[k], states[k], float(periods[k]), False, cycles)


def _cycles(
    solver: Solver,
    observers: tuple[EventObserver, Foresight],
    alike: float,
    most: float,
    progress: Callable[[float], None] | None,
) -> Events:
    """March `solver` until its late cycles are `alike`, or too many to become so; returns them."""
    observer, _ = observers
    events = observer.events(0.5 * solver.time)
    while not (_settled(events, alike) or (events.period.size >= _CYCLES and not _drifts(events))):
        if solver.time > most - SAME:
            _require_orbit(solver, events, most)
            break
        follow(solver, min(most, solver.time + _STRETCH), observers, progress)
        events = observer.events(0.5 * solver.time)
        small = events.time.size >= 2 and events.v_max[-1] < (1.0 + _STEADY) * events.v_min[-1]
        if small and events.elastic_stress_drop[-1] < events.elastic_stress_drop[0]:
            raise NumericsError(
                f"{solver.model}: the run returns to steady sliding, which is stable against small disturbances here; "
                f"{_advice(solver.scene)}"
            )
    return events


def _settled(events: Events, alike: float) -> bool:
    """Whether the last cycles are `alike` in period and in size, which may grow at constant period near the onset."""
    if events.time.size < _LAST:
        return False
    lasts = (events.period[-_LAST:], events.elastic_stress_drop[-_LAST:])
    return all(float(np.abs(np.diff(last)).max()) < alike * float(last[-1]) for last in lasts)


def _drifts(events: Events) -> bool:
    """Whether the size changes in one direction over all cycles: a slow transient, not a motion around an orbit."""
    changes = np.diff(events.elastic_stress_drop)
    return bool((changes > 0.0).all() or (changes < 0.0).all())


def _sections(solver: FlowingSolver, observer: EventObserver, tolerance: float, period: float) -> tuple[list[Flow], Array, Array]:
    """Flows, all on one mesh, and states (k, n) halfway after the next events, and the dates (k,) of these (transits)."""
    sections: list[tuple[Flow, Array, float]] = []
    while len(sections) < _CYCLES:
        flow, state = _between(solver, observer, tolerance, period)
        if sections and flow.size != sections[0][0].size:  # the solver has refined its mesh
            sections = []
        sections.append((flow, state, float(observer.dates()[-1])))
    flows, states, dates = zip(*sections, strict=True)
    return list(flows), np.array(states), np.array(dates)


def _between(solver: FlowingSolver, observer: EventObserver, tolerance: float, period: float) -> tuple[Flow, Array]:
    """March to half a period after the next slip event; returns flow and state there."""
    last = float(observer.dates()[-1])
    if last + (0.5 - _STEP) * period <= solver.time:  # later pieces move the date of an event a little
        follow(solver, max(last + 1.2 * period, solver.time + _STEP * period), [observer])
        while float(observer.dates()[-1]) < last + _STEP * period:
            if solver.time > last + _LATE * period:
                raise NumericsError(f"{solver.model}: no slip event came for {_LATE:g} periods (scene {solver.scene.name!r})")
            follow(solver, solver.time + _STEP * period, [observer])
        last = float(observer.dates()[-1])
    if last + 0.5 * period > solver.time:
        follow(solver, last + 0.5 * period, [observer])
    return solver.flow(period, tolerance)


def _require_orbit(solver: Solver, events: Events, most: float) -> None:
    """Raises NumericsError if a run of `most` transits is not near an orbit; cycles that still grow, or hardly change to and fro,
    may be near enough."""
    count, sizes = events.time.size, events.elastic_stress_drop
    falls = count >= _LAST and _drifts(events)
    if count >= _LAST and (sizes[-1] > sizes[0] or (not falls and np.ptp(sizes) < _SPREAD * sizes[-1])):
        return
    became = ", each smaller than the one before" if falls else ", the last smaller than the first"
    made = f"made {count} cycles in its second half" + (became if count >= _LAST else "")
    raise NumericsError(f"{solver.model}: a run of {most:.0f} transits {made}: no orbit near it; {_advice(solver.scene)}")


def _advice(scene: Scene) -> str:
    """What may lead to an orbit of `scene`, in words."""
    if friction_slopes(scene.law, scene.velocity).weakening:
        means = "begin with a larger disturbance (start.size), or follow the orbits from where steady sliding loses stability"
    else:
        means = ALWAYS_STABLE
    return f"{means} (scene {scene.name!r})"
