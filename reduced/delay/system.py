"""The exact delay system of a scene, with the cheapest march that can compute it."""

import numpy as np

from reduced.delay.alike import Delay
from reduced.delay.break_points import DelayBreaks
from reduced.delay.leaping import LeapingDelay
from reduced.delay.network import DelayNetwork
from reduced.delay.transmission_lines import lines_of
from slipwave.scene import Scene
from slipwave.scene.start import StartKind

_ALIGNED = 1e-7  # of a step: ignoring a kink this close to a step's end causes a relative error of that size


def delay_system(scene: Scene, tolerance: float = 1e-9) -> Delay | DelayNetwork:
    """The solver of the delay system: one slab and one delay for alike plain slabs, a network of lines for all other lossless
    ones. If equal steps cannot end on the jumps and kinks, steps follow these (`DelayBreaks`), hundreds in a transit.

    For alike plain slabs it can leap over long sticks. For a scene that records nothing and does not start on its orbit, only the
    state at the end is accurate (`Delay`, emit=False). Raises SceneError for viscous slabs.
    """
    if scene.alike and scene.upper.is_plain:
        shown = bool(scene.record) or scene.start.kind is StartKind.ORBIT
        return LeapingDelay(scene, tolerance) if shown else Delay(scene, tolerance=tolerance, emit=False)
    lines = lines_of(scene)
    march = DelayBreaks if _breaks_within_steps(scene, lines.divisor) else DelayNetwork
    return march(scene, tolerance=tolerance, lines=lines)


def _breaks_within_steps(scene: Scene, divisor: float | None) -> bool:
    """Whether echoes of a jump or of a knot of the drive fall within equal steps, which divide `divisor`."""
    if divisor is None:
        return scene.start.kind is StartKind.JUMP or not scene.drive.is_constant
    knots = np.array(scene.drive.knots) / divisor
    return bool((np.abs(knots - np.round(knots)) > _ALIGNED).any())
