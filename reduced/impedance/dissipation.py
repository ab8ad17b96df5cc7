"""Where a reduction's Re Z(i omega) can change its sign, from the eigenvalues of a Hamiltonian pencil, so that none is missed.

Spring and mass dissipate nothing on the axis. The rest is G(s) = D + C (s - A)^-1 B with the damping D, and G(s) + G(-s) is 0
exactly at the finite eigenvalues of

    [[A, 0, B], [0, -A^T, -C^T], [C, B^T, 2 D]] x = s [[1, 0, 0], [0, 1, 0], [0, 0, 0]] x

(Boyd, Balakrishnan and Kabamba 1989, as a pencil, so that D may be 0). Re G(i omega) changes its sign only at imaginary ones.
Rounding moves these off the axis, so the imaginary parts of all eigenvalues are used; some of them are not zeros of Re G.
"""

import numpy as np
from numpy.typing import NDArray

from reduced.impedance.reduction import Reduction

Real = NDArray[np.float64]


def dissipation(model: Reduction, omega: Real) -> Real:
    """Re Z(i omega)/epsilon, omega in radians per transit."""
    s = 1j * np.asarray(omega, dtype=float)[:, None]
    residue, offset, decay, frequency = (
        np.array(term) for term in (model.residues, model.offsets, model.decays, model.frequencies)
    )
    strength, rate = np.array(model.relaxations, dtype=float).reshape(-1, 2).T
    modes = (residue * s + offset) / (s * s + 2.0 * decay * s + frequency**2)
    return np.asarray(model.damping + modes.real.sum(axis=1) + (strength / (s + rate)).real.sum(axis=1))


def telling_frequencies(model: Reduction) -> Real:
    """Frequencies (radians per transit): those of the poles, and at least one in every interval of the axis in which Re Z keeps
    its sign. A reduction is passive if Re Z is not negative at any of them and its poles are stable."""
    turns = np.unique(np.concatenate([[0.0], np.abs(_zeros(model).imag), model.frequencies]))
    return np.concatenate([turns, 0.5 * (turns[1:] + turns[:-1]), [2.0 * turns[-1] + 1.0, 1e3 * (turns[-1] + 1.0)]])


def _zeros(model: Reduction) -> NDArray[np.complex128]:
    """Zeros of G(s) + G(-s)."""
    from scipy.linalg import eigvals

    a, b, c = _state_space(model)
    n = b.size
    pencil, weight = np.zeros((2 * n + 1, 2 * n + 1)), np.diag(np.append(np.ones(2 * n), 0.0))
    pencil[:n, :n], pencil[n : 2 * n, n : 2 * n] = a, -a.T
    pencil[:n, -1], pencil[n : 2 * n, -1] = b, -c
    pencil[-1, :n], pencil[-1, n : 2 * n], pencil[-1, -1] = c, b, 2.0 * model.damping
    zeros = np.asarray(eigvals(pencil, weight), dtype=np.complex128)
    return zeros[np.isfinite(zeros)]


def _state_space(model: Reduction) -> tuple[Real, Real, Real]:
    """(A, B, C) of modes and relaxations; a mode's states are those of an oscillator, scaled by its frequency to equal size."""
    pairs, singles = len(model.frequencies), len(model.relaxations)
    n = 2 * pairs + singles
    a, b, c = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    for k, (omega, residue, decay, offset) in enumerate(
        zip(model.frequencies, model.residues, model.decays, model.offsets, strict=True)
    ):
        first, second = 2 * k, 2 * k + 1
        a[first, second], a[second, first], a[second, second] = omega, -omega, -2.0 * decay
        b[second], c[first], c[second] = 1.0, offset / omega, residue
    for k, (strength, rate) in enumerate(model.relaxations, start=2 * pairs):
        a[k, k], b[k], c[k] = -rate, 1.0, strength
    return a, b, c
