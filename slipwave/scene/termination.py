"""An outer face of any kind as numbers, the only form in which models read it (MODEL.md section 3).

A spring and a dashpot in parallel connect the drive to a mass, which moves with the face. In deviations from steady sliding and
in the slab's own direction of drive, with the drive's velocity V, the face's velocity w and the slab's stress sigma there,

    mass w' = load + dashpot (V - w) - sigma,     load' = spring (V - w).

An infinite spring or dashpot is a rigid face, w = V. Where there is no spring, the stress of steady sliding acts on the face as a
dead load, which never changes.
"""

import math
from dataclasses import dataclass

from slipwave.errors import SceneError


@dataclass(frozen=True)
class Termination:
    """`dashpot` in units of stress/V*, `spring` in stress/V* per unit of time, `mass` in stress/V* times a unit of time, where
    stress is the normal stress. The unit of time is L/V*, or one transit after `in_transits`.

    Raises SceneError for a negative number, for NaN, and for an infinite mass.
    """

    spring: float
    dashpot: float
    mass: float = 0.0

    def __post_init__(self) -> None:
        if not (self.spring >= 0.0 and self.dashpot >= 0.0 and 0.0 <= self.mass < math.inf):
            raise SceneError(
                f"outer face: spring = {self.spring:g}, dashpot = {self.dashpot:g}, mass = {self.mass:g}: must be 0 or more, "
                "the mass finite"
            )
        if math.inf in (self.spring, self.dashpot):
            for name, value in (("spring", 0.0), ("dashpot", math.inf), ("mass", 0.0)):
                object.__setattr__(self, name, value)

    @property
    def is_rigid(self) -> bool:
        """The face moves with the drive."""
        return math.isinf(self.dashpot)

    @property
    def has_dead_load(self) -> bool:
        """No spring: the stress of steady sliding acts on the face itself."""
        return self.spring == 0.0 and not self.is_rigid

    def in_transits(self, transit: float) -> "Termination":
        """The same with time in transits, one transit being `transit` L/V*."""
        return Termination(self.spring * transit, self.dashpot, self.mass / transit)
