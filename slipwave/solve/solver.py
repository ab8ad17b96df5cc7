"""The interface of every solver, reduced or full wave: it marches, and its state can be saved and restored."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias, runtime_checkable

from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene

State: TypeAlias = dict[str, Array]
"""Plain float64 arrays by name."""


@dataclass(frozen=True)
class Energy:
    """Energies per unit area of interface since t = 0, in units of sigma L: work done by the drive, dissipated in friction,
    radiated through the outer faces, dissipated by viscosity, and the change of the stored energy (kinetic and elastic)."""

    input: float
    friction: float
    radiated: float
    viscous: float
    stored: float

    @property
    def residual(self) -> float:
        """Input minus all other entries, relative to the largest entry; 0 if the energy balance is exact."""
        largest = max(abs(self.input), abs(self.friction), abs(self.stored), 1e-300)
        return (self.input - self.friction - self.radiated - self.viscous - self.stored) / largest


class Resumable(Protocol):
    """A solver or observer whose memory can be saved in a checkpoint and restored from it."""

    def state(self) -> State:
        """Everything that changes during a run, as copies."""

    def restore(self, state: State) -> None:
        """Continue from `state`, with bit-identical results. Raises SceneError if it does not fit."""


class Solver(Resumable, Protocol):
    """A model of one scene. `advance` marches a chunk of steps of its own choice, at most to the first end of a step at or beyond
    `until`, and returns their pieces. The motion does not depend on the chunks."""

    @property
    def scene(self) -> Scene:
        """The scene that is simulated."""

    @property
    def model(self) -> str:
        """The model's name, as given when it was built."""

    @property
    def settings(self) -> dict[str, Any]:
        """All options that affect the numbers, other than scene and model; saved in a checkpoint as JSON."""

    @property
    def nodes(self) -> Array:
        """Nodes of the pieces in [0, 1]."""

    @property
    def time(self) -> float:
        """Time reached, in transits."""

    @property
    def failures(self) -> int:
        """Number of solves, of the interface or a step, that did not converge so far."""

    @property
    def failed_at(self) -> float:
        """Time of the first failed solve (transits); NaN if unknown."""

    @property
    def seconds_per_piece(self) -> float:
        """Approximate processor time of a piece (s)."""

    @property
    def transits_per_piece(self) -> float:
        """Length of the pieces (transits); NaN if steps adapt."""

    @property
    def bookkeeping(self) -> frozenset[str]:
        """Names of the entries of `state()` that do not belong to the motion: counters, times, records."""

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits) and return the new pieces. Raises NumericsError if no step is short enough."""

    def energy(self) -> Energy | None:
        """Energy balance since t = 0; None for models without one."""


@runtime_checkable
class Leaping(Solver, Protocol):
    """A solver that can pass slow motion without a step in every transit."""

    @property
    def skipped(self) -> float:
        """Transits so far in which no step was marched."""

    def leap(self, until: float, end: float, gaps: bool) -> Pieces:
        """As `advance`, but with long pieces where waves change z by less than the tolerance and, if `gaps` are allowed, with
        gaps (`slipwave.observe.pieces`), or long pieces without the waves, where no figure of a cycle is determined. The run's
        `end` (transits) never lies in a gap."""


@runtime_checkable
class Cutting(Solver, Protocol):
    """A solver whose steps may end far beyond the end of a run."""

    def cut(self, pieces: Pieces, until: float) -> Pieces:
        """The latest `pieces` as far as `until` (transits), which is then the time reached: what the last step has beyond is the
        next piece to come. As they are, if that is within 2 transits."""


@runtime_checkable
class Stopping(Solver, Protocol):
    """A solver whose steps end wherever the motion lets them, unless it is told where."""

    def stop_at(self, time: float) -> None:
        """End a step at `time` (transits), infinite for none, beyond the end of the last step, which is then the time reached:
        what a cut left of it does not come."""


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
        """Let `energy` return the balance; call it before the first step. A model whose balance costs nothing always keeps it."""

    def snapshot(self) -> Snapshot:
        """The fields at the present time."""

    def disturb(self, noise: Callable[[int], Array], stressed: bool = True) -> None:
        """Add `noise(n)` (V*) to the n velocities of each marched slab and, if `stressed` and both are stored at one time, to its
        stresses over the impedance."""

    def deviation(self) -> float:
        """Largest deviation (V*) of the stored velocities and, if stored at the same time, of the stresses over the impedance,
        from steady sliding."""

    def deviation_energy(self) -> float:
        """Twice the energy of all deviations from steady sliding over the impedance (V*^2): in the scheme's own norm, or as the
        mean over the nodes where velocity and stress belong to different times."""

    def keep_frames(self, interval: float) -> None:
        """Let `frames` return the fields at the ends of all steps and, where steps are longer than `interval` (transits) and can
        be divided, within them."""

    def frames(self) -> list[Snapshot]:
        """The fields at the steps of the last `advance`, if they are kept; at least those at the present time."""
