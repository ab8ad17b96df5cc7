"""The slabs that a full wave marches."""

from slipwave.scene import Scene
from slipwave.scene.slab import Slab


def marched_slabs(scene: Scene) -> tuple[Slab, ...]:
    """One of an alike pair, else the upper and the lower slab."""
    return (scene.upper,) if scene.alike else (scene.upper, scene.lower)
