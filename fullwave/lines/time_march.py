"""How a grid is marched in time if the user leaves it open: the march that is cheaper for the scene and the grid."""

from typing import Literal, TypeAlias

from slipwave.scene import Scene
from slipwave.scene.start import StartKind

TimeMarch: TypeAlias = Literal["exact", "explicit"]
"""How a grid is marched in time."""

MOST_BY_DEFAULT = 1000
"""Unknowns up to which the exact march is the default. Measured on the paper's scene, both marches with less error in time than
in space: from 130 unknowns on a transit costs a fifth of that by explicit steps, or less (a fortieth for elements of degree 4).
Tables take 40 ms for 270 unknowns, 0.2 to 0.5 s for 500, 0.7 to 1.8 s for 800, which pays after 20 to 150 transits (1600 for
`sbp:2`, whose explicit steps are cheapest); a scene of the gallery has 4000."""


def cheaper_march(scene: Scene, unknowns: int) -> TimeMarch:
    """The exact march up to `MOST_BY_DEFAULT` unknowns. A start with a jump leaves waves as short as the grid allows, which both
    marches must follow step by step: the error is that of the grid, and the explicit march is cheaper on most of them."""
    return "explicit" if unknowns > MOST_BY_DEFAULT or scene.start.kind is StartKind.JUMP else "exact"
