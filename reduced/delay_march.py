"""What every march of the delay system is: the present moment, the counters, and how it gives up."""

from typing import Protocol

from reduced.delay_kernel import PSI, TIME
from scene.errors import NumericsError
from scene.observe.ledger import Energy
from scene.observe.pieces import Array
from scene.scene import Scene


class _Memory(Protocol):
    @property
    def now(self) -> Array:
        """time (transits), psi, y."""


class DelayMarch:
    """Base of the solvers of the delay system; they keep their state in `_memory`, whose `now` is the present moment."""

    model = "delay"
    _memory: _Memory

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.failures = 0
        self.iterations = 0

    @property
    def time(self) -> float:
        """Transits since the start."""
        return float(self._memory.now[TIME])

    @property
    def psi(self) -> float:
        """psi at the present moment."""
        return float(self._memory.now[PSI])

    def energy(self) -> Energy | None:
        """The delay system keeps no ledger: its slabs have no inside."""
        return None

    def _unresolved(self, steps: float) -> NumericsError:
        """What to raise where even `steps` a transit are too few."""
        return NumericsError(
            f"delay: the step at t = {self.time:.6g} transits cannot be resolved with {steps:.0f} steps a transit "
            f"(psi = {self.psi:.6g}, scene {self.scene.name!r}, digest {self.scene.digest})"
        )
