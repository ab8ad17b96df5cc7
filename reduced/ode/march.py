"""Marches any ODE reduction of a slab pair (MODEL.md section 3), all with the same stiff integrator."""

import math
from typing import Any

from reduced.impedance.reduce import reduction_of
from reduced.impedance.reduction import Reduction
from reduced.ode.slabs import ReducedSlabs
from slipwave.scene import Scene
from slipwave.solve import Energy
from slipwave.step.port_march import PortMarch

STAGES = 8
LONGEST = 2.0
"""Longest step (transits)."""

_FIRST = 0.125


class ReducedModel(PortMarch):
    """Marches `reduction` of the scene's slab pair to `tolerance`, the requested relative error of the cycle's figures.

    Radau IIA with 8 nodes (order 15 at step ends, L-stable), step lengths 2 / 2^level transits. Knots of the drive cause kinks of
    the motion; between two knots, step lengths are their distance over powers of two, so that a step ends on each. `failures`
    counts unconverged solves; a step that cannot be solved at the shortest length raises NumericsError naming time and scene (a
    quasi-static model runs away).
    """

    failed_at = math.nan
    failures = 0
    seconds_per_piece = 2e-6  # 1.2 to 2.4 measured
    transits_per_piece = math.nan

    def __init__(self, scene: Scene, reduction: Reduction, tolerance: float = 1e-9, stages: int = STAGES) -> None:
        self.scene, self.model, self.reduction = scene, reduction.name, reduction
        self.settings: dict[str, Any] = {"tolerance": tolerance, "stages": stages}
        reason = "nothing limits its slip rate: it runs away" if reduction.runs_away else ""
        super().__init__(ReducedSlabs(scene, self._reduce, stages), tolerance, LONGEST, _FIRST, reason)

    def _reduce(self, scene: Scene) -> Reduction:
        """The reduction of `scene`; this one if the slabs are the same."""
        same = scene.slabs == self.scene.slabs and scene.transit == self.scene.transit
        return self.reduction if same else reduction_of(scene, self.model)

    def energy(self) -> Energy | None:
        """None: a reduction's energy is not that of the slabs."""
        return None
