"""Whether a solver places the steps of V where they are: one that marches equal steps takes each from the end of a step on."""

import math
from itertools import pairwise

from slipwave.observe import Solver
from slipwave.scene.drive import Drive

_ON_A_STEP = 1e-6
"""Of a step: nearer to its end than this, a step of V is on it."""


def late_steps(solver: Solver) -> list[str]:
    """A note on a solver that may place a step of V beside its time; none if every one falls on the end of a step of its own."""
    pieces, drive = solver.transits_per_piece, solver.scene.drive
    if solver.nodes[0] > 0.0 or math.isnan(pieces):  # it ends a step at every knot
        return []
    step = pieces / (solver.nodes.size - 1)
    if all(abs(time / step - round(time / step)) < _ON_A_STEP for time in _jumps(drive)):
        return []
    return [
        f"steps of V are placed to within one time step ({step:.3g} transits) by this model: their error falls with the step, "
        "not with the order of the scheme; the delay system, and full waves with --time exact, place them exactly"
    ]


def _jumps(drive: Drive) -> list[float]:
    pairs = pairwise(zip(drive.times, drive.velocities, strict=True))
    return [late for (early, before), (late, after) in pairs if early == late and before != after]
