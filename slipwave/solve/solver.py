"""The interface of every solver, reduced or full wave: it marches, and its state can be saved and restored."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias, TypeGuard, runtime_checkable

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
    """A model of one scene. `advance` marches over a chunk of steps, whose number it chooses itself, and returns their pieces. It
    stops at the latest at the first end of a step at or beyond `until`. The motion does not depend on where chunks end."""

    @property
    def scene(self) -> Scene:
        """What is simulated."""

    @property
    def model(self) -> str:
        """The model's name, as given when it was built."""

    @property
    def settings(self) -> dict[str, Any]:
        """Everything besides the scene and the model's name that affects its numbers; saved in a checkpoint as JSON."""

    @property
    def nodes(self) -> Array:
        """Nodes of its pieces in [0, 1]."""

    @property
    def time(self) -> float:
        """Time reached, in transits."""

    @property
    def failures(self) -> int:
        """Interface or step solves so far that did not converge."""

    @property
    def failed_at(self) -> float:
        """Time of the first of them (transits); NaN if it is not known."""

    @property
    def seconds_per_piece(self) -> float:
        """Approximate cost of a piece."""

    @property
    def transits_per_piece(self) -> float:
        """Length of its pieces; NaN where steps adapt."""

    @property
    def bookkeeping(self) -> frozenset[str]:
        """The entries of `state()` that are no part of the motion: counters, times, records. `now` begins with the time."""

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits) and return the new pieces. Raises NumericsError if it cannot."""

    def energy(self) -> Energy | None:
        """Ledger since t = 0, for models that keep one."""


@runtime_checkable
class Leaping(Solver, Protocol):
    """A solver that can go over slow motion without a step in every transit."""

    @property
    def skipped(self) -> float:
        """Transits in which it has marched no step so far."""

    def leap(self, until: float, end: float, gaps: bool) -> Pieces:
        """As `advance`, but with long pieces where waves move z by less than the tolerance and, if `gaps` are allowed, with gaps
        between pieces (see `slipwave.observe.pieces`) where no figure of a cycle lies. `end` is that of the run (transits), which
        never falls into a gap."""


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


_known: dict[tuple[type, type], bool] = {}


def offers(one: object, protocol: type) -> bool:
    """Whether it is an instance of the `protocol`; asked once for a class, because the question takes 0.1 ms."""
    kind = (type(one), protocol)
    if kind not in _known:
        _known[kind] = isinstance(one, protocol)
    return _known[kind]


def has_fields(solver: Solver) -> TypeGuard[FieldSolver]:
    """Whether it is a full wave."""
    return offers(solver, FieldSolver)
