"""What holds a slab's outer face, as numbers: the one form in which every model reads a face (MODEL.md section 3).

A spring and a dashpot act side by side from the drive on a mass, which moves with the face. In deviations from steady sliding and
in the slab's own direction of drive, with V the drive's velocity, w the face's and sigma the slab's stress there,

    mass w' = load + dashpot (V - w) - sigma,     load' = spring (V - w).

An infinite spring or dashpot is a rigid face, w = V. Where there is no spring, the stress of steady sliding acts on the face as a
dead load: it never changes, whatever the face does.
"""

import math
from dataclasses import dataclass

from slipwave.errors import SceneError


@dataclass(frozen=True)
class Termination:
    """`dashpot` in units of stress/V*, `spring` in stress/V* per unit of time, `mass` in stress/V* times a unit of time, stress
    that of the normal stress. The unit of time is L/V*, or one transit after `in_transits`.

    Raises SceneError for a negative number, one that is none, and an infinite mass.
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
