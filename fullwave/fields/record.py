"""Space-time record of one window of a full-wave run: velocity and shear stress in the slabs, sampled at step ends.

Any family whose solver offers `snapshot()` (see `slipwave.observe.snapshot`) can be recorded. Memory holds the window and no
more. For alike slabs one slab is kept: the other is its mirror image, with the velocity's sign changed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING

import numpy as np

from slipwave.errors import SceneError
from slipwave.observe import Final, Pieces, final_state, follow
from slipwave.observe.follow import Observer
from slipwave.observe.pieces import Array
from slipwave.observe.snapshot import FieldSolver, SlabSnapshot, Snapshot
from slipwave.scene import Scene

if TYPE_CHECKING:
    import xarray

INTERVAL = 1.0 / 32.0
"""Transits between two samples unless asked otherwise: sixteen to a wave's way across a slab."""


@dataclass(frozen=True)
class SlabField:
    """One slab: `depth` (m,) as a fraction of its travel time, `velocity` (k, m) in V*, `stress` (k, m) in normal stresses."""

    depth: Array
    velocity: Array
    stress: Array


@dataclass(frozen=True)
class Field:
    """Record of a window: `time` (k,) in transits, the slabs (`lower` is None for alike ones), and where it came from."""

    scene: Scene
    model: str
    time: Array
    upper: SlabField
    lower: SlabField | None

    @property
    def slabs(self) -> dict[str, SlabField]:
        """The recorded slabs by name."""
        return {"upper": self.upper} | ({"lower": self.lower} if self.lower is not None else {})

    def dataset(self) -> "xarray.Dataset":
        """As a Dataset with names, units and coordinates."""
        import xarray

        variables: dict[str, object] = {}
        coordinates: dict[str, object] = {"time": ("time", self.time, {"long_name": "time", "units": "transit"})}
        for name, slab in self.slabs.items():
            depth = f"{name}_depth"
            place = {"long_name": f"depth in the {name} slab, 0 at the interface", "units": "fraction of its travel time"}
            coordinates[depth] = (depth, slab.depth, place)
            motion = {"long_name": f"velocity in the {name} slab, positive along the upper face's drive", "units": "V*"}
            load = {"long_name": f"shear stress in the {name} slab", "units": "normal stress"}
            variables[f"{name}_velocity"] = (("time", depth), slab.velocity, motion)
            variables[f"{name}_stress"] = (("time", depth), slab.stress, load)
        return xarray.Dataset(variables, coordinates, self._facts())

    def _facts(self) -> dict[str, str | float]:
        try:
            release = version("slipwave")
        except PackageNotFoundError:
            release = "unknown"
        facts: dict[str, str | float] = {
            "title": f"fields of scene {self.scene.name} by model {self.model}",
            "scene": self.scene.name,
            "scene_digest": self.scene.digest,
            "model": self.model,
            "slipwave_version": release,
            "transit_in_friction_time": self.scene.transit,
        }
        if self.lower is None:
            facts["lower_slab"] = "mirror image of the upper: same stress, opposite velocity"
        return facts


def record_field(
    solver: FieldSolver,
    start: float,
    end: float,
    interval: float = INTERVAL,
    observers: Sequence[Observer] = (),
    progress: Callable[[float], None] | None = None,
) -> tuple[Field, Final]:
    """March to `end` and keep the fields from `start` on, every `interval` (transits; rounded up to the solver's steps).

    Returns the record and the interface's state at `end`. The record goes on to the end of the solver's piece, so its last sample
    may lie beyond `end` by less than one piece (a few steps). Raises SceneError if the window is empty or already past, and
    NumericsError as `follow` does.
    """
    if not (solver.time <= start < end and interval > 0.0):
        raise SceneError(f"window = [{start:g}, {end:g}]: must be later than t = {solver.time:g} and of positive length")
    if start > solver.time:
        follow(solver, start, observers, progress)
    solver.keep_frames()
    shots, latest = [solver.snapshot()], _Latest()
    while solver.time < end - 1e-9:
        follow(solver, min(end, solver.time + interval), [*observers, latest], progress)
        for frame in solver.frames():
            if min(shots[-1].time + interval, solver.time) - 1e-9 < frame.time:
                shots.append(frame)
    if latest.pieces is None:
        raise SceneError(f"window = [{start:g}, {end:g}]: shorter than the solver's step")
    return assemble(solver.scene, solver.model, shots), final_state(solver, latest.pieces, end)


class _Latest:
    """Remembers the latest pieces: the record's own last sample may lie a little beyond the end of the run."""

    pieces: Pieces | None = None

    def scan(self, pieces: Pieces) -> None:
        """Take the next pieces of the run, in order."""
        self.pieces = pieces


def assemble(scene: Scene, model: str, shots: Sequence[Snapshot]) -> Field:
    """Snapshots of one run as a record."""
    time = np.array([shot.time for shot in shots])
    lower = None if scene.alike else _stack([shot.lower for shot in shots])
    return Field(scene, model, time, _stack([shot.upper for shot in shots]), lower)


def _stack(shots: Sequence[SlabSnapshot]) -> SlabField:
    return SlabField(shots[0].depth, np.array([shot.velocity for shot in shots]), np.array([shot.stress for shot in shots]))
