"""Linearised friction: the one-port of the interface, for any registered law."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reduced.impedance import Jet, Ratio
from slipwave.friction import Law, respond, steady_state, unknown_of


@dataclass(frozen=True)
class FrictionSlopes:
    """Slopes of a law at steady sliding: `direct` F_v, `healing` G_phi (1/(L/V*)), `steady` F_ss' = d mu_ss/dV."""

    direct: float
    healing: float
    steady: float

    @property
    def weakening(self) -> bool:
        """Friction falls with the steady rate, which is necessary for instability."""
        return self.steady < 0.0

    @property
    def omega_c(self) -> float:
        """omega_c = G_phi sqrt(-F_ss'/F_v) (20), (38): the critical frequency of every lossless slab; nan if strengthening."""
        return self.healing * float(np.sqrt(-self.steady / self.direct)) if self.weakening else float("nan")

    @property
    def reach(self) -> float:
        """For passive slabs every root with Re s >= 0 has |s + G_phi| <= reach, because beyond that Re H > 0 and Re Z >= 0."""
        return self.healing * abs(self.direct - self.steady) / self.direct

    @property
    def growing(self) -> tuple[float, float]:
        """(centre, radius) of the disc that holds every root with Re s >= 0: outside of it Re H > 0 there, and passive slabs have
        Re Z >= 0. On the imaginary axis it reaches to omega_c."""
        return 0.5 * self.reach - self.healing, 0.5 * self.reach

    def impedance_at(self, omega: float | NDArray[np.float64]) -> NDArray[np.complex128]:
        """H(i omega), delta_mu = H delta_v: (F_v s + G_phi F_ss')/(s + G_phi)."""
        s = 1j * np.asarray(omega)
        return np.asarray((self.direct * s + self.healing * self.steady) / (s + self.healing))

    def ratio(self, s: Jet) -> Ratio:
        """(numerator, denominator) of H as jets."""
        return s * self.direct + self.healing * self.steady, s + self.healing


def friction_slopes(law: Law, velocity: float) -> FrictionSlopes:
    """Slopes of `law` in steady sliding at `velocity` (V*), from its derivatives in the unknowns (z, psi):

    F_v = F_z/v_z,  G_phi = -G_psi (psi' = G),  F_ss' = F_v - F_psi G_z/(G_psi v_z).
    """
    psi = steady_state(law, velocity)
    _, v_z, _, f_z, f_psi, _, g_z, g_psi = respond(law, unknown_of(law, velocity), psi)
    return FrictionSlopes(f_z / v_z, -g_psi, (f_z - f_psi * g_z / g_psi) / v_z)
