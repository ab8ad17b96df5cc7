"""What a step of V costs a model: one that marches equal time steps takes it from the end of a step on, and no grid resolves the
front of its wave."""

import math
from itertools import pairwise

from slipwave.scene.drive import Drive
from slipwave.solve import Solver

_ON_A_STEP = 1e-6
"""Of a step: nearer to its end than this, a step of V is on it."""


def costly_steps(solver: Solver) -> list[str]:
    """A note on a full wave whose order a step of V lowers, by its place beside a time step or by its front; none if V has no
    steps after the start, if the model takes them exactly, and for the leapfrog with steps that fall on the ends of its own."""
    jumps = _jumps(solver.scene.drive)
    late = _late(solver, jumps)
    if late or not jumps or "time" not in solver.settings:
        return late
    return [
        "no grid resolves the front of a step of V: the error of this model falls as the size of its cells, whatever its order; "
        "the delay system has no such error"
    ]


def _late(solver: Solver, jumps: list[float]) -> list[str]:
    """A note on a solver that places one of these steps beside its time; none if all fall on the ends of steps of its own."""
    pieces = solver.transits_per_piece
    if solver.nodes[0] > 0.0 or math.isnan(pieces):  # it ends a step at every knot
        return []
    step = pieces / (solver.nodes.size - 1)
    if all(abs(time / step - round(time / step)) < _ON_A_STEP for time in jumps):
        return []
    return [
        f"steps of V are placed to within one time step ({step:.3g} transits) by this model: their error falls with the step, "
        "not with the order of the scheme; the delay system, and full waves with --time exact, place them exactly"
    ]


def _jumps(drive: Drive) -> list[float]:
    pairs = pairwise(zip(drive.times, drive.velocities, strict=True))
    return [late for (early, before), (late, after) in pairs if early == late > 0.0 and before != after]
