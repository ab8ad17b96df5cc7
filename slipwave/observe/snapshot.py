"""What a full-wave solver shows of its fields at one moment; every family offers `snapshot() -> Snapshot`."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from slipwave.observe.ledger import Energy
from slipwave.observe.pieces import Array
from slipwave.observe.solver import Solver


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


@runtime_checkable
class FieldSolver(Solver, Protocol):
    """A full wave: a solver on a grid, whose fields can be recorded."""

    @property
    def cells(self) -> int:
        """Cells asked for, per slab."""

    @property
    def step(self) -> float:
        """Length of a step, in transits."""

    def energy(self) -> Energy:
        """Ledger since t = 0."""

    def snapshot(self) -> Snapshot:
        """The fields now."""

    def keep_frames(self) -> None:
        """From now on `frames` has the fields of every step, as far as the solver's pieces are long."""

    def frames(self) -> list[Snapshot]:
        """The fields at the ends of the last advance's steps, where kept; at least those now."""
