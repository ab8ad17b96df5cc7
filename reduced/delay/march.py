"""What all marches of the delay system share: the present state, the counters, and the errors if a step cannot be resolved."""

import math
from typing import Any

from reduced.delay.alike_kernel import PSI, TIME, AlikeMemory
from reduced.delay.network_kernel import NetworkMemory
from slipwave.errors import NumericsError
from slipwave.friction import respond
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.solve import Energy
from slipwave.step.guess import TOO_STEEP
from slipwave.step.rows import UNKNOWN


class DelayMarch:
    """Base of the solvers of the delay system; they keep their state in `_memory`, whose `now` is the present state."""

    model = "delay"
    seconds_per_piece = 2e-6  # 0.9 to 1.9 measured
    transits_per_piece = math.nan
    failed_at = math.nan
    bookkeeping = frozenset({"counts", "origin", "waiting", "leaps", "tries", "past", "past.incoming", "arrivals"})
    nodes: Array
    settings: dict[str, Any]
    _memory: AlikeMemory | NetworkMemory
    _steepest: float

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.failures = 0
        self.iterations = 0

    @property
    def time(self) -> float:
        """Transits since the start."""
        return float(self._memory.now[TIME])

    def energy(self) -> Energy | None:
        """None: the delay system knows no fields in the slabs, and so keeps no ledger."""
        return None

    def _unresolved(self, steps: float, verdict: int) -> NumericsError:
        """The error to raise if even `steps` per transit are too few, for the `verdict` on the step that needs more."""
        if verdict == TOO_STEEP:
            return self._left_too_fast(steps)
        time, psi = self._memory.now[[TIME, PSI]]
        return NumericsError(
            f"delay: the step at t = {time:.6g} transits cannot be resolved with {steps:.0f} steps per transit "
            f"(psi = {psi:.6g}, scene {self.scene.name!r}, digest {self.scene.digest})"
        )

    def _left_too_fast(self, steps: float) -> NumericsError:
        """The error to raise if the motion is unstable on a time scale that the steps cannot follow."""
        growth, (time, psi) = self._growth(), self._memory.now[[TIME, PSI]]
        return NumericsError(
            f"delay: at t = {time:.6g} transits (psi = {psi:.6g}) the motion is unstable: disturbances grow at "
            f"{growth:.4g} per transit, by e^{growth / steps:.3g} in one of {steps:.0f} steps per transit, the largest number; "
            f"a step can follow at most e^{self._steepest:.3g}. Longer steps would damp this growth and follow a motion that "
            f"cannot last. Use thinner slabs, or fd with {math.ceil(growth)} cells or more "
            f"(scene {self.scene.name!r}, digest {self.scene.digest})"
        )

    def _growth(self) -> float:
        """Growth rate (per transit) of a disturbance of psi at present, with the arriving waves given:
        r (G_psi - G_z F_psi/(F_z + Z v_z)), the real root of the characteristic equation without echoes."""
        z = float(self._memory.guess[UNKNOWN, 0])
        _, v_z, _, friction_z, friction_psi, _, g_z, g_psi = respond(self.scene.law, z, float(self._memory.now[PSI]))
        return self.scene.transit * (g_psi - g_z * friction_psi / (friction_z + self.scene.impedance * v_z))
