"""Space-time record of one window of a full-wave run: velocity and shear stress in the slabs, sampled at the ends of steps.

Any solver with `snapshot()` (see `slipwave.solve`) can be recorded. Only the window is kept in memory. For alike slabs
one slab is kept; the other is its mirror image, with the sign of the velocity changed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import CONVENTIONS, TIME
from slipwave.observe.pieces import SAME, Array
from slipwave.scene import Scene
from slipwave.scene.units import IN_SI
from slipwave.solve import FieldSolver, SlabSnapshot, Snapshot, State, tables

if TYPE_CHECKING:
    import xarray

INTERVAL = 1.0 / 32.0
"""Default time between two samples, in transits: sixteen samples while a wave crosses a slab."""

QUANTITIES = {
    "time": ("time since the start of the run", "transit"),
    "depth": ("depth in the {} slab, 0 at the interface", "travel time through the slab"),
    "velocity": ("velocity in the {} slab, positive along the upper face's drive", "V*"),
    "stress": ("shear stress in the {} slab", "normal stress"),
}
"""Quantity -> its meaning, and the unit of its numbers."""


@dataclass(frozen=True)
class Field:
    """Record of a window: `time` (k,) in transits, the slabs (`lower` is None for alike ones), and the scene and model. Velocity
    and stress of a slab are (k, m)."""

    scene: Scene
    model: str
    time: Array
    upper: SlabSnapshot
    lower: SlabSnapshot | None

    @property
    def slabs(self) -> dict[str, SlabSnapshot]:
        """The recorded slabs by name."""
        return {"upper": self.upper} | ({"lower": self.lower} if self.lower is not None else {})

    def dataset(self) -> "xarray.Dataset":
        """The record as a Dataset with names and coordinates; values are dimensionless, their unit is the attribute
        `in_units_of`."""
        require("files", "a dataset of fields")
        import xarray

        variables: dict[str, object] = {TIME: (TIME, self.time, self._notes("time"))}
        for name, slab in self.slabs.items():
            depth = f"{name}_depth"
            for quantity, values in vars(slab).items():
                dimensions = depth if quantity == "depth" else (TIME, depth)
                variables[f"{name}_{quantity}"] = (dimensions, values, self._notes(quantity, name))
        fields = xarray.Dataset(variables, attrs=self._facts())
        for coordinate in fields.coords.values():
            coordinate.encoding["_FillValue"] = None  # of a coordinate no value is missing
        return fields

    def si_size(self, quantity: str) -> float | None:
        """SI size of the unit of `quantity`; None in a scene without units."""
        unit, units = QUANTITIES[quantity][1], self.scene.units
        return None if units is None or unit not in IN_SI else units.size(unit, self.scene.transit)

    def _notes(self, quantity: str, slab: str = "") -> dict[str, str | float]:
        meaning, unit = QUANTITIES[quantity]
        known: dict[str, str | float] = {"long_name": meaning.format(slab), "units": "1", "in_units_of": unit}
        size = self.si_size(quantity)
        return known if size is None else known | {"si_factor": size, "si_units": IN_SI[unit][0]}

    def _facts(self) -> dict[str, str | float]:
        facts: dict[str, str | float] = {
            "Conventions": CONVENTIONS,
            "history": f"{datetime.now(UTC).isoformat(timespec='seconds')} fields of a run",
            "title": f"fields of scene {self.scene.name} by model {self.model}",
            "scene": self.scene.name,
            "scene_digest": self.scene.digest,
            "model": self.model,
            "slipwave_version": version("slipwave"),
            "transit_in_friction_time": self.scene.transit,
        }
        if self.lower is None:
            facts["lower_slab"] = "mirror image of the upper: same stress, opposite velocity"
        return facts


class FieldRecord:
    """Marks of a run: keeps the fields of `solver` from `start` to `end`, every `interval` (transits; rounded up to the solver's
    steps). The record ends with a piece of the solver, so its last sample may lie beyond `end` by less than one piece (a few
    steps). A run that continues from a checkpoint keeps the samples in its window.

    Raises SceneError if the window is empty.
    """

    def __init__(self, solver: FieldSolver, start: float, end: float, interval: float = INTERVAL) -> None:
        if not (start < end and interval > 0.0):
            raise SceneError(f"window = [{start:g}, {end:g}]: must be of positive length")
        self._solver, self._start, self._end, self._interval = solver, start, end, interval
        self._shots: list[Snapshot] = []

    @property
    def due(self) -> float:
        """As `Mark`."""
        if not self._shots:
            return self._start
        last = self._shots[-1].time
        return min(last + self._interval, self._end) if last < self._end - SAME else math.inf

    def act(self) -> None:
        """As `Mark`."""
        if not self._shots:
            self._solver.keep_frames(self._interval)
            self._shots.append(self._solver.snapshot())
            return
        for frame in self._solver.frames():  # always keeps the last one, from which the next sample is counted
            if min(self._shots[-1].time + self._interval, self._solver.time) - SAME < frame.time:
                self._shots.append(frame)

    @property
    def field(self) -> Field:
        """The record so far. Raises SceneError if it is shorter than a step."""
        if len(self._shots) < 2:
            raise SceneError(f"window = [{self._start:g}, {self._end:g}]: shorter than the solver's step")
        time = np.array([shot.time for shot in self._shots])
        lower = None if self._solver.scene.alike else _stack([shot.lower for shot in self._shots])
        return Field(self._solver.scene, self._solver.model, time, _stack([shot.upper for shot in self._shots]), lower)

    def state(self) -> State:
        """As `Resumable`: a row per sample with its time, then velocity and stress of the upper and of the lower slab."""
        width = 1 + sum(values.size for values in _values(self._solver.snapshot()))
        rows = [np.concatenate([[shot.time], *_values(shot)]) for shot in self._shots]
        return {"samples": np.array(rows).reshape(len(rows), width)}

    def restore(self, state: State) -> None:
        """As `Resumable`."""
        now = self._solver.snapshot()
        sizes = [values.size for values in _values(now)]
        rows = tables(state, {"samples": (-1, 1 + sum(sizes))}, self._solver.model)["samples"]
        self._shots = []
        for row in rows[rows[:, 0] >= self._start - SAME]:
            time, *values = np.split(row, np.cumsum([1, *sizes])[:-1])
            slabs = SlabSnapshot(now.upper.depth, *values[:2]), SlabSnapshot(now.lower.depth, *values[2:])
            self._shots.append(Snapshot(float(time[0]), *slabs))
        if self._shots:
            self._solver.keep_frames(self._interval)


def _values(shot: Snapshot) -> tuple[Array, Array, Array, Array]:
    return shot.upper.velocity, shot.upper.stress, shot.lower.velocity, shot.lower.stress


def _stack(shots: Sequence[SlabSnapshot]) -> SlabSnapshot:
    return SlabSnapshot(shots[0].depth, np.array([shot.velocity for shot in shots]), np.array([shot.stress for shot in shots]))
