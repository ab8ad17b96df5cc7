"""The exact delay system of a scene, by the cheapest march that can do it."""

from reduced.delay import Delay
from reduced.delay_breaks import DelayBreaks
from reduced.delay_network import DelayNetwork
from reduced.network import common_divisor, lines_of
from scene.scene import Scene
from scene.start import StartKind


def delay_system(scene: Scene, tolerance: float = 1e-9) -> Delay | DelayNetwork:
    """The marching delay system: one slab and one delay for alike plain slabs, a network of lines for all other lossless ones.

    A scene that records nothing gets the state at the end only (`Delay`, emit=False). Raises SceneError for viscous slabs.
    """
    if scene.alike and scene.upper.is_plain:
        return Delay(scene, tolerance=tolerance, emit=bool(scene.record))
    jump = scene.start.kind is StartKind.JUMP
    if jump and common_divisor(lines_of(scene).travel) is None:
        return DelayBreaks(scene, tolerance=tolerance)
    return DelayNetwork(scene, tolerance=tolerance)
