"""Scenes and solvers that between them reach every branch of the explicit method-of-lines march."""

from functools import partial

from leapfrog_scenes import SCENES

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts

FAMILIES = {
    "dg:5": partial(DiscontinuousGalerkin, number=5, cells=3, time="explicit"),
    "fem:4": partial(FiniteElement, number=4, cells=4, time="explicit"),
    "fem:2 consistent": partial(FiniteElement, number=2, cells=6, mass="consistent", time="explicit"),
    "sbp:6": partial(SummationByParts, number=6, cells=16, time="explicit"),
}
VISCOUS_AND_CONSISTENT = ("fem:2 consistent", ("kelvin-voigt", "everything"))
"""What no solver takes: Kelvin-Voigt viscosity with a consistent mass."""

PAIRS = [
    (family, scene)
    for family in FAMILIES
    for scene in SCENES
    if not (family == VISCOUS_AND_CONSISTENT[0] and scene in VISCOUS_AND_CONSISTENT[1])
]
