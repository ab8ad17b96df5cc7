"""What a slab is made of, in SI; solvers need none of it."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """Density in kg/m3 and shear modulus in Pa."""

    density: float
    shear_modulus: float

    @property
    def wave_speed(self) -> float:
        """Speed of shear waves in m/s, c = sqrt(G/rho)."""
        return math.sqrt(self.shear_modulus / self.density)
