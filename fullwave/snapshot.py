"""What a full-wave solver shows of its fields at one moment; every family offers `snapshot() -> Snapshot`."""

from dataclasses import dataclass
from typing import Protocol

from scene.observe import Energy
from scene.observe.pieces import Array, Pieces
from scene.scene import Scene


@dataclass(frozen=True)
class SlabSnapshot:
    """One slab: `depth` (m,) as a fraction of its one-way travel time, 0 at the interface and 1 at the outer face; `velocity`
    (m,) in V*, positive in the upper slab's direction of drive; shear `stress` (m,) in units of the normal stress."""

    depth: Array
    velocity: Array
    stress: Array


@dataclass(frozen=True)
class Snapshot:
    """Both slabs at `time` (transits). For alike slabs `lower` is the mirror image of `upper`."""

    time: float
    upper: SlabSnapshot
    lower: SlabSnapshot


class FieldSolver(Protocol):
    """A solver whose fields can be recorded: the `Solver` protocol, `snapshot`, `keep_frames` and `frames`."""

    scene: Scene
    model: str
    nodes: Array
    failures: int

    @property
    def time(self) -> float:
        """Time reached, in transits."""

    def advance(self, until: float) -> Pieces:
        """As `scene.observe.follow.Solver`."""

    def energy(self) -> Energy | None:
        """As `scene.observe.follow.Solver`."""

    def snapshot(self) -> Snapshot:
        """The fields now."""

    def keep_frames(self) -> None:
        """From now on `frames` has the fields of every step, as far as the solver's pieces are long."""

    def frames(self) -> list[Snapshot]:
        """The fields at the ends of the last advance's steps, where kept; at least those now."""
