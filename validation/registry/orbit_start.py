"""The start `orbit`: the model is marched until it has settled on its own periodic orbit, and the clock is set to zero there.

This finds stable orbits only; where cycles go on changing (a torus, chaos, steady sliding) the run is refused with the reason.
"""

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from slipwave.errors import NumericsError, SceneError
from slipwave.observe import Energy, Pieces, Solver, follow
from slipwave.observe.foresight import require_time
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.measure.settle import MOST_TRANSITS, NoCycle, settle
from validation.run.progress import progress

if TYPE_CHECKING:
    from slipwave.observe.snapshot import FieldSolver, Snapshot

_TOLERANCE = 1e-9
_PASSED_ON = frozenset({"step", "total_cells", "settings", "choice", "seconds_per_piece", "transits_per_piece"})


class OnOrbit:
    """A solver whose t = 0 is the date of a slip event of its settled orbit, to within one step; see `Solver`."""

    def __init__(self, solver: Solver, origin: float) -> None:
        self._solver, self._origin = solver, origin
        self._ledger = solver.energy()
        self.scene: Scene = solver.scene
        self.model = solver.model
        self.nodes: Array = solver.nodes

    def __getattr__(self, name: str) -> Any:
        """What a full wave tells of its grid. Not its state: a checkpoint of it would not know where t = 0 was."""
        if name in _PASSED_ON:
            return getattr(self._solver, name)
        raise AttributeError(name)

    @property
    def time(self) -> float:
        """Transits since the start on the orbit."""
        return self._solver.time - self._origin

    @property
    def failures(self) -> int:
        """Unconverged solves, those of the approach included."""
        return self._solver.failures

    @property
    def failed_at(self) -> float:
        """Time of the first unconverged solve (transits since the start on the orbit); NaN if none is known."""
        return float(getattr(self._solver, "failed_at", math.nan)) - self._origin

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits since the start on the orbit)."""
        pieces = self._solver.advance(until + self._origin)
        return pieces._replace(time=pieces.time - self._origin)

    def energy(self) -> Energy | None:
        """Ledger since the start on the orbit."""
        now, before = self._solver.energy(), self._ledger
        if now is None or before is None:
            return None
        names = ("input", "friction", "radiated", "viscous", "stored")
        return Energy(**{name: getattr(now, name) - getattr(before, name) for name in names})


class FieldsOnOrbit(OnOrbit):
    """The same for a solver whose fields can be recorded (`slipwave.observe.snapshot.FieldSolver`): they carry the orbit's clock
    too."""

    _solver: "FieldSolver"

    def snapshot(self) -> "Snapshot":
        """The fields now."""
        return self._on_clock(self._solver.snapshot())

    def keep_frames(self) -> None:
        """From now on `frames` has the fields of every step."""
        self._solver.keep_frames()

    def frames(self) -> "list[Snapshot]":
        """The fields at the ends of the last advance's steps, where kept."""
        return [self._on_clock(frame) for frame in self._solver.frames()]

    def _on_clock(self, shot: "Snapshot") -> "Snapshot":
        return dataclasses.replace(shot, time=shot.time - self._origin)


def begin_on_orbit(solver: Solver) -> OnOrbit:
    """March `solver` onto its orbit and up to the next slip event, which becomes t = 0.

    Raises SceneError if the drive changes (there is no orbit then), NumericsError if the model does not settle.
    """
    scene = solver.scene
    if not scene.drive.is_constant:
        raise SceneError("start.kind = 'orbit': needs a constant drive.velocity; with a ramp use 'nudge' or 'jump'")
    try:
        require_time(solver, MOST_TRANSITS)
        with progress(f"{scene.name}, {solver.model}, on the way to its orbit", MOST_TRANSITS) as report:
            settled = settle(solver, _TOLERANCE, progress=report)
    except NoCycle as reason:
        raise NumericsError(f"start.kind = 'orbit': {reason} (scene {scene.name!r})") from None
    if not settled.settled:
        raise NumericsError(
            f"start.kind = 'orbit': {solver.model} had not settled after {settled.transits:.0f} transits: its last cycles differ "
            f"by {settled.unrest:.1e} (scene {scene.name!r}); it may have no stable periodic orbit here"
        )
    next_event = float(settled.observer.dates()[-1]) + settled.orbit.period.value
    while next_event <= solver.time:
        next_event += settled.orbit.period.value
    follow(solver, next_event)
    kind = FieldsOnOrbit if hasattr(solver, "snapshot") else OnOrbit
    return kind(solver, solver.time)
