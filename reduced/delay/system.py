"""Selects the fastest solver of a scene's exact delay system."""

from typing import TYPE_CHECKING

import numpy as np

from reduced.delay.alike import Delay
from reduced.delay.leaping import LeapingDelay
from reduced.delay.transmission_lines import NODES, Lines, lines_of
from slipwave.friction import respond, unknown_of
from slipwave.scene import Scene
from slipwave.scene.drive import StartKind

if TYPE_CHECKING:
    from reduced.delay.network import DelayNetwork

_LONGEST_STEP = 1.0 / 3.0  # transits
_ALIGNED = 1e-7  # of a step: ignoring a kink this close to a step's end causes a relative error of that size


def delay_system(scene: Scene, tolerance: float = 1e-9) -> "Delay | DelayNetwork":
    """The solver of the delay system: one slab and one delay for alike plain slabs, a network of lines for all other lossless
    ones. If equal steps cannot end on the jumps and kinks, steps end on these (`DelayBreaks`), hundreds in a transit. The solver
    is `Leaping`. For alike plain slabs in a scene that records nothing and does not start on its orbit, only the state at the end
    is accurate (`Delay`, emit=False). Raises SceneError for viscous slabs.
    """
    if scene.alike and scene.upper.is_plain:
        shown = bool(scene.record) or scene.start.kind is StartKind.ORBIT
        return LeapingDelay(scene, tolerance) if shown else Delay(scene, tolerance=tolerance, emit=False)
    from reduced.delay.break_points import DelayBreaks  # networks take as long to import as all that alike slabs need
    from reduced.delay.leaping_network import LeapingNetwork

    lines = lines_of(scene)
    if _breaks_within_steps(scene, lines.divisor) and not _hides_breaks(scene, lines, tolerance):
        return DelayBreaks(scene, tolerance=tolerance, lines=lines)
    return LeapingNetwork(scene, tolerance=tolerance, lines=lines)


def _hides_breaks(scene: Scene, lines: Lines, tolerance: float) -> bool:
    """Whether outer faces have masses and no dashpots, so that only their acceleration jumps, by K dV/m, at a jump of V, and the
    polynomials of a step represent its wave to the tolerance.

    A polynomial of degree n misses a jump q of the second derivative within a step h by about q (h/n)^2/8."""
    if scene.start.kind is StartKind.JUMP or any(top.dashpot > 0.0 or top.mass == 0.0 for top in lines.tops):
        return False
    velocities = scene.drive.velocities
    jump = max(velocities) - min(velocities)
    friction_z = respond(scene.law, unknown_of(scene.law, scene.velocity), scene.steady_psi)[3]
    bend = max(top.spring / top.mass * lines.impedance[last] for top, last in zip(lines.tops, lines.last, strict=True))
    return bool(jump * bend * ((_LONGEST_STEP / (NODES - 1)) ** 2 / 8.0) < tolerance * friction_z)


def _breaks_within_steps(scene: Scene, divisor: float | None) -> bool:
    """Whether echoes of a jump or of a knot of the drive fall within equal steps, which divide `divisor`."""
    if divisor is None:
        return scene.start.kind is StartKind.JUMP or not scene.drive.is_constant
    knots = np.array(scene.drive.knots) / divisor
    return bool((np.abs(knots - np.round(knots)) > _ALIGNED).any())
