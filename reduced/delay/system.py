"""The exact delay system of a scene, by the cheapest march that can do it."""

import numpy as np

from reduced.delay.alike import Delay
from reduced.delay.break_points import DelayBreaks
from reduced.delay.network import DelayNetwork
from reduced.delay.transmission_lines import lines_of
from slipwave.scene import Scene
from slipwave.scene.start import StartKind

_ALIGNED = 1e-7  # of a step: a kink so close to its end costs that share of itself


def delay_system(scene: Scene, tolerance: float = 1e-9) -> Delay | DelayNetwork:
    """The marching delay system: one slab and one delay for alike plain slabs, a network of lines for all other lossless ones,
    with steps that follow jumps and kinks of the drive where equal ones cannot end on them (far dearer).

    A scene that records nothing, and need not find its orbit, gets the state at the end only (`Delay`, emit=False).
    Raises SceneError for viscous slabs.
    """
    if scene.alike and scene.upper.is_plain:
        return Delay(scene, tolerance=tolerance, emit=bool(scene.record) or scene.start.kind is StartKind.ORBIT)
    lines = lines_of(scene)
    march = DelayBreaks if _breaks_within_steps(scene, lines.divisor) else DelayNetwork
    return march(scene, tolerance=tolerance, lines=lines)


def _breaks_within_steps(scene: Scene, divisor: float | None) -> bool:
    """Whether a jump or a knot of the drive comes back where no equal steps, which divide `divisor`, can end."""
    if divisor is None:
        return scene.start.kind is StartKind.JUMP or not scene.drive.is_constant
    knots = np.array(scene.drive.knots) / divisor
    return bool((np.abs(knots - np.round(knots)) > _ALIGNED).any())
