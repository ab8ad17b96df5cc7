"""The slabs that a full wave marches, and the fields of both from theirs."""

from collections.abc import Sequence

from slipwave.scene import Scene
from slipwave.scene.slab import Slab
from slipwave.solve import SlabSnapshot, Snapshot


def marched_slabs(scene: Scene) -> tuple[Slab, ...]:
    """The slab that stands for both where V is constant (`Scene.equivalent`), else the upper and the lower one. Where V changes,
    slabs that differ in epsilon swing together too, which their interface does not feel; only alike ones do not."""
    if scene.equivalent is not None and (scene.alike or scene.drive.is_constant):
        return (scene.equivalent,)
    return scene.upper, scene.lower


def both_slabs(scene: Scene, time: float, marched: Sequence[SlabSnapshot]) -> Snapshot:
    """Fields at `time` of both slabs, from those of the marched ones, whose velocities are positive in the slab's own direction
    of drive. One that stands for both has their stress; deviations of its velocity from V/2 are theirs times epsilon over its
    own."""
    shots = list(marched)
    if len(shots) == 1 and not scene.alike:
        (whole,), mean, stands = marched, 0.5 * scene.velocity, marched_slabs(scene)[0].epsilon
        shots = [
            SlabSnapshot(whole.depth, mean + stands / slab.epsilon * (whole.velocity - mean), whole.stress)
            for slab in (scene.upper, scene.lower)
        ]
    lower = shots[-1]
    return Snapshot(time, shots[0], SlabSnapshot(lower.depth, -lower.velocity, lower.stress))
