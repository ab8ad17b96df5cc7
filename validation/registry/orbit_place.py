"""Puts a solver onto its model's own periodic orbit, stable or not, as Newton's method finds it (`orbits`)."""

import math
from typing import Any

import numpy as np

from reduced.orbit.closing import Closed
from slipwave.errors import NumericsError
from slipwave.observe import EventObserver
from slipwave.observe.pieces import Pieces, lagrange_basis, values_at
from slipwave.scene.start import NUDGE_CENTRE, NUDGE_REACH
from slipwave.solve import FieldSolver, Solver, State
from slipwave.step.flow import Place
from validation.registry.families import DELAY, family_of
from validation.registry.flows import moving
from validation.registry.orbits import find_orbit

BEGIN = float(math.ceil(NUDGE_CENTRE + NUDGE_REACH))
"""Date (transits) of the orbit's start on the solver's own clock: a whole transit after the nudge."""

_TOLERANCE = 1e-9
_SAMPLES = 4096  # of a period, for the means of stresses
_PERIODS = 3


def place_on_orbit(solver: Solver) -> float:
    """Put `solver` onto its orbit between two slip events; returns the date (transits, its own clock) of the next event.

    Raises NumericsError if no orbit is found, SceneError if the run that looks for it would take too long."""
    cells = solver.cells if isinstance(solver, FieldSolver) else None
    model = moving(solver.model, solver.scene, _TOLERANCE, cells)
    try:
        closed = find_orbit(model, _TOLERANCE).found.closed
    except NumericsError as reason:
        raise NumericsError(f"start.kind = 'orbit': {reason}") from None
    solver.restore(state_on(solver, closed))
    return solver.time + first_event(closed)


def state_on(solver: Any, closed: Closed) -> State:
    """The state of `solver` at the start of a motion of its own flow that closes, or nearly so."""
    cycle, place = closed.cycle, _place(closed)
    if family_of(solver.model) is DELAY:
        from reduced.flows.delay_start import placed as placed_delay

        flow: Any = closed.flow
        return placed_delay(solver, flow, cycle, place)
    state: State = solver.placed(cycle, place)
    return state


def _place(closed: Closed) -> Place:
    """The interface at the orbit's start. Its flow knows the elastic stress but for a constant: over a period, mean stresses are
    the same at all depths, so that the mean of y is that of mu."""
    cycle, basis = closed.cycle, lagrange_basis(closed.flow.nodes)
    times = np.linspace(0.0, cycle.period, _SAMPLES, endpoint=False)
    z, _, mu, y = values_at(cycle.pieces, basis, times)
    return Place(BEGIN, float(z[0]), float(cycle.start[-1]), float(y[0] + (mu - y).mean()))


def first_event(closed: Closed) -> float:
    """Date (transits from its start) of the first slip event of a `closed` orbit."""
    cycle, flow = closed.cycle, closed.flow
    observer = EventObserver(flow.scene, flow.nodes)
    within = cycle.pieces.time + cycle.pieces.length <= cycle.period + 1e-9
    pieces = Pieces(*(values[within] for values in cycle.pieces))
    for k in range(_PERIODS):
        observer.scan(pieces._replace(time=pieces.time + k * cycle.period))
    return float(observer.dates()[1]) % cycle.period
