"""What every model offers, reduced or full wave: it marches, and its state can be taken out and put back."""

from typing import Any, Protocol, TypeAlias

from slipwave.observe.ledger import Energy
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene

State: TypeAlias = dict[str, Array]
"""Plain float64 arrays by name."""


class Resumable(Protocol):
    """Something whose memory goes into a checkpoint and comes back from it: solvers and observers."""

    def state(self) -> State:
        """Everything that changes during a run, as copies."""

    def restore(self, state: State) -> None:
        """Go on from `state`, to the bit as if nothing had happened; SceneError if it does not fit."""


class Solver(Resumable, Protocol):
    """A model of one scene. `advance` moves on by a chunk of its own choosing (never past the first step end at or beyond
    `until`) and returns the pieces it covered; the motion does not depend on where chunks end."""

    @property
    def scene(self) -> Scene:
        """What is simulated."""

    @property
    def model(self) -> str:
        """The model's name, as given when it was built."""

    @property
    def settings(self) -> dict[str, Any]:
        """All that shapes its numbers besides the scene and the model's name; goes into a checkpoint as JSON."""

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
        """About what a piece costs."""

    @property
    def transits_per_piece(self) -> float:
        """Length of its pieces; NaN where steps adapt."""

    def advance(self, until: float) -> Pieces:
        """March towards `until` (transits) and return the pieces covered; raises NumericsError where it cannot."""

    def energy(self) -> Energy | None:
        """Ledger since t = 0, for models that keep one."""
