"""Any pair of lossless slabs as transmission lines between the interface and the drive: the delay system as data.

A slab is a chain of layers. Each carries one wave inwards and one outwards, sigma +- e w, which arrive at the layer's other end
after its one-way travel time. At the ends of layers the waves obey (MODEL.md section 3), in deviations from steady sliding,

    joint      U from inside, D from outside:  w = (D - U)/(e_in + e_out),  back in U + 2 e_in w,  on out D - 2 e_out w
    top        P from inside:  m w' = y + Z_g (dV - w) - P - e w,  y' = K (dV - w),  back in P + 2 e w
    interface  S from outside: mu = Z (sum S_i/e_i - dv),  on out 2 mu - S

(K, Z_g, m) is the slab's `Termination`; a rigid top is Z_g -> infinity (w = dV). The sign of the lower slab's velocities is such
that the slip rate is the sum of both slabs' velocities. For alike slabs only one is computed, and counted twice.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from reduced.commensurate import common_divisor
from slipwave.errors import SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.termination import Termination

_MOST_DIVISIONS = 64


@dataclass(frozen=True)
class Lines:
    """Layers of all slabs, slab after slab, from the interface outwards.

    `impedance`, `travel` (one way, transits) per layer; per slab `first` and `last` layer index, and its `tops` (transit clock);
    `weight` is 2 for one of two alike slabs, else 1.
    """

    impedance: Array
    travel: Array
    first: tuple[int, ...]
    last: tuple[int, ...]
    tops: tuple[Termination, ...]
    weight: float

    @cached_property
    def divisor(self) -> float | None:
        """Longest step (transits) that divides every travel time. None if it would be too short or does not exist; delayed values
        are then interpolated."""
        return common_divisor(self.travel, _MOST_DIVISIONS)


def lines_of(scene: Scene) -> Lines:
    """The scene's slabs as lines. Raises SceneError for viscous slabs, whose waves disperse: no finite set of delays is exact."""
    slabs = scene.slabs
    for slab in slabs:
        if slab.viscosity is not None:
            raise SceneError(
                f"model = delay: scene {scene.name!r} is viscous: its waves disperse, so that no finite set of delays is exact; "
                "use fitted:N or a full wave"
            )
    counts = [len(slab.layers) for slab in slabs]
    ends = np.cumsum(counts)
    return Lines(
        impedance=np.array([slab.epsilon * layer.impedance for slab in slabs for layer in slab.layers]),
        travel=np.array([0.5 * slab.round_trip / scene.transit * layer.fraction for slab in slabs for layer in slab.layers]),
        first=tuple(int(end - count) for end, count in zip(ends, counts, strict=True)),
        last=tuple(int(end - 1) for end in ends),
        tops=tuple(slab.termination.in_transits(scene.transit) for slab in slabs),
        weight=2.0 if scene.alike else 1.0,
    )
