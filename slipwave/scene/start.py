"""How a run starts. Every start builds on steady sliding at the drive's initial velocity.

nudge  smooth: d psi/dt~ gains size * exp(-(t~ - 6)^2), t~ in transits of the upper slab. Every scheme keeps its full order.
jump   psi(0) = psi_ss + size with no wave in the slabs: breaks compatibility; the jump's echoes never end (MODEL.md section 7).
orbit  on the model's own periodic orbit, at the date of a slip event.
"""

import math
from dataclasses import dataclass
from enum import StrEnum

from slipwave.compiled import inlined

NUDGE_CENTRE = 6.0
"""Transits at which the nudge peaks; at t~ = 0 it is size * e^-36."""

NUDGE_REACH = 7.0
"""Outside NUDGE_CENTRE +- this many transits the nudge is below size * 6e-22 and is set to 0."""


class StartKind(StrEnum):
    """The registered starts; values are the scene file's words."""

    NUDGE = "nudge"
    JUMP = "jump"
    ORBIT = "orbit"


@dataclass(frozen=True)
class Start:
    """Kind, and size of the disturbance of psi (`orbit` uses it only to leave steady sliding before the orbit is found)."""

    kind: StartKind = StartKind.NUDGE
    size: float = 0.5

    @property
    def nudge_size(self) -> float:
        """Amplitude of the smooth forcing of psi (0 for a jump)."""
        return 0.0 if self.kind is StartKind.JUMP else self.size

    @property
    def jump_size(self) -> float:
        """psi(0) - psi_ss (0 unless the start is a jump)."""
        return self.size if self.kind is StartKind.JUMP else 0.0


@inlined
def nudge_rate(size: float, time: float) -> float:
    """The contribution of the nudge to d psi/dt~ at `time` (transits)."""
    late = time - NUDGE_CENTRE
    return size * math.exp(-late * late) if size != 0.0 and abs(late) < NUDGE_REACH else 0.0
