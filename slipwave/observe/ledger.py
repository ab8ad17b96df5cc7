"""Energy ledger per unit area of interface, in units of sigma L: work of the drive = friction + radiated + viscous + stored."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Energy:
    """Energies since t = 0: work done by the drive, dissipated in friction, radiated through the outer faces, dissipated by
    viscosity, and the change of the stored energy (kinetic and elastic, of the slabs and their outer faces)."""

    input: float
    friction: float
    radiated: float
    viscous: float
    stored: float

    @property
    def residual(self) -> float:
        """Input minus all other entries, relative to the largest entry; 0 if the energy balance is exact."""
        largest = max(abs(self.input), abs(self.friction), abs(self.stored), 1e-300)
        return (self.input - self.friction - self.radiated - self.viscous - self.stored) / largest
