"""All roots of steady sliding under a reduction, which has finitely many: eigenvalues of its linear equations."""

import numpy as np

from reduced.impedance import Complex
from reduced.impedance.reduction import Reduction
from reduced.stability.friction import FrictionSlopes


def eigenvalues(model: Reduction, slopes: FrictionSlopes, transit: float, epsilon: float) -> Complex:
    """All roots s of H(s) + Z(s) = 0 of a reduction, on the friction clock: eigenvalues of the linear equations of `Reduction`
    for deviations from steady sliding, with friction's stress  F_v v + x,  x' = -G_phi (x + (F_v - F_ss') v).

    The states are x, tau_k, p_k, tau_j, and y if there is a spring, v if there is a mass; p_k is over omega_k.
    """
    poles, sprung = len(model.frequencies), int(model.spring > 0.0)
    first = 1 + sprung
    last = first + 2 * poles
    size = last + len(model.relaxations)
    rates, driven = np.zeros((size, size)), np.zeros(size)  # d/dt~ of the states; and by v
    rates[0, 0], driven[0] = -slopes.healing * transit, slopes.healing * (slopes.steady - slopes.direct) * transit
    driven[1:first] = -model.spring * epsilon
    for k, (omega, residue, decay, offset) in enumerate(
        zip(model.frequencies, model.residues, model.decays, model.offsets, strict=True)
    ):
        tau, p = first + 2 * k, first + 1 + 2 * k
        rates[tau, tau], rates[tau, p], rates[p, tau] = -2.0 * decay, omega, -omega
        driven[tau], driven[p] = -residue * epsilon, -offset * epsilon / omega
    for j, (strength, rate) in enumerate(model.relaxations, last):
        rates[j, j], driven[j] = -rate, -strength * epsilon
    load = np.ones(size)
    load[0], load[first + 1 : last : 2] = -1.0, 0.0
    resistance = slopes.direct + model.damping * epsilon
    if model.mass == 0.0:  # v = load/resistance
        return np.asarray(np.linalg.eigvals(rates + np.outer(driven, load / resistance)) / transit, dtype=complex)
    with_rate = np.block([[rates, driven[:, None]], [load / (model.mass * epsilon), -resistance / (model.mass * epsilon)]])
    return np.asarray(np.linalg.eigvals(with_rate) / transit, dtype=complex)
