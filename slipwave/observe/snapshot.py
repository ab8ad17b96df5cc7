"""The fields of a full-wave solver at one time; every family offers `snapshot() -> Snapshot`."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from slipwave.observe.ledger import Energy
from slipwave.observe.pieces import Array
from slipwave.observe.solver import Solver


@dataclass(frozen=True)
class SlabSnapshot:
    """The fields of a slab: `depth` (m,) as a fraction of its one-way travel time, 0 at the interface and 1 at the outer face;
    `velocity` (m,) in V*, positive in the upper slab's direction of drive; shear `stress` (m,) in units of the normal stress."""

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
        """The requested cells per slab."""

    @property
    def step(self) -> float:
        """Length of a step, in transits."""

    def keep_ledger(self) -> None:
        """From now on `energy` returns the ledger; called before the first step. Where nothing is gained, it is always kept."""

    def energy(self) -> Energy | None:
        """Ledger since t = 0, if it is kept."""

    def snapshot(self) -> Snapshot:
        """The fields now."""

    def disturb(self, noise: Callable[[int], Array], stressed: bool = True) -> None:
        """Add `noise(n)`, in V*, to n velocities of each marched slab and, if `stressed` and where both belong to one time, to
        its stresses over the impedance."""

    def deviation(self) -> float:
        """Largest deviation of the stored velocities (and, if they belong to one time, stresses) from steady sliding (V*)."""

    def deviation_energy(self) -> float:
        """Twice the energy of all deviations from steady sliding over the impedance (V*^2): in the scheme's own norm, or as the
        mean over the nodes where velocity and stress belong to different times."""

    def keep_frames(self, interval: float) -> None:
        """From now on `frames` returns the fields at the ends of steps, if pieces are longer, and within steps that are longer
        than `interval` (transits), if these can be divided."""

    def frames(self) -> list[Snapshot]:
        """The fields at the ends of the last advance's steps, if they are kept; at least those at the present time."""
