"""SI <-> dimensionless (15): epsilon = rho c V*/sigma, round_trip = (h/c)/(L/V*) with h the thickness of both slabs."""

import math
from dataclasses import dataclass

from slipwave.scene.slab import face_sizes

IN_SI = {"transit": ("s", "s"), "normal stress": ("Pa", "Pa"), "V*": ("m s-1", "m_per_s"), "L": ("m", "m")}
IN_SI |= {"1/normal stress": ("Pa-1", "per_Pa"), "1/V*": ("s m-1", "s_per_m"), "1/transit": ("s-1", "per_s")}
IN_SI |= {"V*/L": ("s-1", "per_s")}
"""Unit of a value -> its SI unit, and the ending of names of values in that."""


@dataclass(frozen=True)
class Units:
    """The size of one unit of length, velocity and stress, in m, m/s and Pa."""

    memory_length: float
    reference_velocity: float
    normal_stress: float

    @property
    def time(self) -> float:
        """L/V* in seconds."""
        return self.memory_length / self.reference_velocity

    def size(self, unit: str, transit: float) -> float:
        """The size in SI of one `unit` of `IN_SI`, with a `transit` in L/V*."""
        sizes = {"transit": float(f"{transit * self.time:.15g}"), "normal stress": self.normal_stress}
        sizes |= {"V*": self.reference_velocity, "L": self.memory_length, "V*/L": 1.0 / self.time}
        return 1.0 / sizes[unit[2:]] if unit.startswith("1/") else sizes[unit]

    @property
    def face(self) -> dict[str, float]:
        """The size of one unit of an outer face's stiffness [Pa/m], impedance [Pa s/m] and mass [kg/m2]."""
        return face_sizes(self.normal_stress / self.reference_velocity, self.time)

    def epsilon(self, density: float, shear_modulus: float) -> float:
        """Slab impedance rho c over frictional impedance sigma/V*, c = sqrt(G/rho)."""
        return math.sqrt(density * shear_modulus) * self.reference_velocity / self.normal_stress

    def round_trip(self, density: float, shear_modulus: float, thickness: float) -> float:
        """2 * thickness / c on the friction clock, `thickness` that of one slab in m."""
        return 2.0 * thickness * math.sqrt(density / shear_modulus) / self.time
