"""What a full-wave solver shows of its fields at one moment; every family offers `snapshot() -> Snapshot`."""

from dataclasses import dataclass
from typing import Protocol

from slipwave.observe.follow import Solver
from slipwave.observe.pieces import Array


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


class FieldSolver(Solver, Protocol):
    """A solver whose fields can be recorded."""

    def snapshot(self) -> Snapshot:
        """The fields now."""

    def keep_frames(self) -> None:
        """From now on `frames` has the fields of every step, as far as the solver's pieces are long."""

    def frames(self) -> list[Snapshot]:
        """The fields at the ends of the last advance's steps, where kept; at least those now."""
