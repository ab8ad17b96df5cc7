"""The interface of every solver, reduced or full wave: it marches, and its state can be saved and restored."""

from typing import Any, Protocol, TypeAlias, runtime_checkable

from slipwave.observe.ledger import Energy
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene

State: TypeAlias = dict[str, Array]
"""Plain float64 arrays by name."""


class Resumable(Protocol):
    """Something whose memory can be saved in a checkpoint and restored from it: solvers and observers."""

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
