"""The start `orbit`: the model starts on its own periodic orbit, stable or not; t = 0 is the date of a slip event.

The orbit is computed by Newton's method; a leapfrog, whose motion over a period is no differentiable map, is marched until it has
settled, which gives stable orbits only. If its cycles keep changing (a torus, chaos) or end (steady sliding), the run is refused
with the reason.
"""

import dataclasses
import math
from typing import Any

import numpy as np

from reduced.orbit.closing import Closed
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver
from slipwave.observe.history import values_at
from slipwave.observe.pieces import Array, Pieces, lagrange_basis
from slipwave.scene import Scene
from slipwave.scene.drive import NUDGE_CENTRE, NUDGE_REACH
from slipwave.solve import Energy, FieldSolver, Snapshot, Solver, State, follow, tables
from slipwave.solve.follow import require_time
from slipwave.step.flow import InterfaceState
from validation.models.by_name import family_of
from validation.models.orbits import find_orbit, has_flow
from validation.models.settle import MOST_TRANSITS, NoCycle, settle

BEGIN = float(math.ceil(NUDGE_CENTRE + NUDGE_REACH))
"""Date (transits) of the orbit's start on the solver's own clock: a whole transit after the nudge."""

_TOLERANCE = 1e-9
_SAMPLES = 4096  # of a period, for the means of stresses
_PERIODS = 3
_OWN = "orbit start"  # no solver's own name: networks have an `origin`


class OnOrbit:
    """A solver whose t = 0 is the date of a slip event of its settled orbit, to within one step, after `begin` or `restore`; see
    `Solver`."""

    def __init__(self, solver: Solver) -> None:
        self._solver = solver
        self._origin, self._ledger = 0.0, _entries(None)
        self.scene: Scene = solver.scene
        self.model, self.nodes = solver.model, solver.nodes
        self.bookkeeping: frozenset[str] = solver.bookkeeping | {_OWN}
        self.settings: dict[str, Any] = solver.settings
        self.seconds_per_piece, self.transits_per_piece = solver.seconds_per_piece, solver.transits_per_piece

    def begin(self) -> None:
        """Set the state onto the orbit and march to the next slip event, which becomes t = 0.

        Raises SceneError if the drive changes (there is no orbit then), NumericsError if no orbit is found.
        """
        if not self.scene.drive.is_constant:
            raise SceneError("start.kind = 'orbit': needs a constant drive.velocity; with a ramp use 'nudge' or 'jump'")
        family = family_of(self.model)
        assert family is not None
        follow(self._solver, _by_newton(self._solver) if has_flow(family) else _by_settling(self._solver))
        self._origin, self._ledger = self._solver.time, _entries(self._solver.energy())

    @property
    def time(self) -> float:
        """Transits since the start on the orbit."""
        return self._solver.time - self._origin

    @property
    def failures(self) -> int:
        """Unconverged solves, including those of the approach."""
        return self._solver.failures

    @property
    def failed_at(self) -> float:
        """Time of the first unconverged solve (transits since the start on the orbit); NaN if none is known."""
        return self._solver.failed_at - self._origin

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits since the start on the orbit)."""
        pieces = self._solver.advance(until + self._origin)
        return pieces._replace(time=pieces.time - self._origin)

    def energy(self) -> Energy | None:
        """Energy balance since the start on the orbit."""
        now = self._solver.energy()
        return None if now is None else Energy(*(_entries(now) - self._ledger).tolist())

    def state(self) -> State:
        """As `Solver`; `orbit start`: date of t = 0 on the solver's own clock, and its energy balance then."""
        return self._solver.state() | {_OWN: np.array([self._origin, *self._ledger])}

    def restore(self, state: State) -> None:
        """As `Solver`, without a march to the orbit."""
        origin = tables(state, {_OWN: (1 + self._ledger.size,)}, self.model)[_OWN]
        self._solver.restore({name: array for name, array in state.items() if name != _OWN})
        self._origin, self._ledger = float(origin[0]), origin[1:]


class FieldsOnOrbit(OnOrbit):
    """As `OnOrbit` for a full wave (`slipwave.solve.FieldSolver`), whose fields have the orbit's clock too."""

    _solver: FieldSolver

    def __init__(self, solver: FieldSolver) -> None:
        super().__init__(solver)
        self.cells, self.step = solver.cells, solver.step
        self.keep_frames, self.disturb = solver.keep_frames, solver.disturb
        self.deviation, self.deviation_energy = solver.deviation, solver.deviation_energy

    def keep_ledger(self) -> None:
        """As `FieldSolver`, since the start on the orbit."""
        self._solver.keep_ledger()
        self._ledger = _entries(self._solver.energy())

    def snapshot(self) -> Snapshot:
        """As `FieldSolver`."""
        return self._on_clock(self._solver.snapshot())

    def frames(self) -> list[Snapshot]:
        """As `FieldSolver`."""
        return [self._on_clock(frame) for frame in self._solver.frames()]

    def _on_clock(self, shot: Snapshot) -> Snapshot:
        return dataclasses.replace(shot, time=shot.time - self._origin)


def _entries(ledger: Energy | None) -> Array:
    return np.zeros(5) if ledger is None else np.array(dataclasses.astuple(ledger))


def _by_newton(solver: Solver) -> float:
    """Set `solver` onto its orbit between two slip events; returns the date (transits, its own clock) of the next event."""
    cells = solver.cells if isinstance(solver, FieldSolver) else None
    try:
        closed = find_orbit(solver.model, solver.scene, _TOLERANCE, cells).periodic.closed
    except NumericsError as reason:
        raise NumericsError(f"start.kind = 'orbit': {reason}") from None
    solver.restore(state_on(solver, closed))
    return solver.time + first_event(closed)


def _by_settling(solver: Solver) -> float:
    """March `solver` to its settled orbit; returns the date of the next slip event."""
    scene = solver.scene
    try:
        require_time(solver, MOST_TRANSITS)
        settled = settle(solver, _TOLERANCE)
    except NoCycle as reason:
        raise NumericsError(f"start.kind = 'orbit': {reason} (scene {scene.name!r})") from None
    if not settled.settled:
        raise NumericsError(
            f"start.kind = 'orbit': {solver.model} had not settled after {settled.transits:.0f} transits: its last cycles differ "
            f"by {settled.unrest:.1e} (scene {scene.name!r}); it may have no stable periodic orbit here"
        )
    last, period = float(settled.observer.dates()[-1]), settled.orbit.period.value
    return last + period * (1 + max(0, math.floor((solver.time - last) / period)))


def state_on(solver: Any, closed: Closed) -> State:
    """The state of `solver` at the start of a motion of its own flow that closes, or nearly so. The flow gives the elastic stress
    up to a constant: mean stresses over a period are the same at all depths, so that the mean of y equals that of mu."""
    cycle = closed.cycle
    times = np.linspace(0.0, cycle.period, _SAMPLES, endpoint=False)
    z, _, mu, y = values_at(cycle.pieces, lagrange_basis(closed.flow.nodes), times, closed.flow.scene.law)
    interface = InterfaceState(BEGIN, float(z[0]), float(cycle.start[-1]), float(y[0] + (mu - y).mean()))
    state: State = solver.state_at_start(cycle, interface)
    return state


def first_event(closed: Closed) -> float:
    """Date (transits from its start) of the first slip event of a `closed` orbit."""
    cycle, flow = closed.cycle, closed.flow
    observer = EventObserver(flow.scene, flow.nodes)
    within = cycle.pieces.time + cycle.pieces.length <= cycle.period + 1e-9
    pieces = cycle.pieces.part(within)
    for k in range(_PERIODS):
        observer.scan(pieces._replace(time=pieces.time + k * cycle.period))
    return float(observer.dates()[1]) % cycle.period
