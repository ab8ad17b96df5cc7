"""The impedance of a reduction: a rational function of s, its poles, its linear equations, and the frequencies at which its real
part can change sign, from the eigenvalues of a Hamiltonian pencil, so that no interval is missed.

Spring and mass do not dissipate. The rest is G(s) = D + C (s - A)^-1 B with the damping D, and G(s) + G(-s) is 0 exactly at the
finite eigenvalues of

    [[A, 0, B], [0, -A^T, -C^T], [C, B^T, 2 D]] x = s [[1, 0, 0], [0, 1, 0], [0, 0, 0]] x

(Boyd, Balakrishnan and Kabamba 1989, as a pencil, so that D may be 0). Re G(i omega) changes its sign only at imaginary ones.
Rounding displaces these from the axis; therefore the imaginary parts of all eigenvalues are used, though some are not zeros of Re
G.
"""

import cmath
from dataclasses import replace

import numpy as np

from reduced.impedance.reduction import Reduction
from reduced.impedance.transmission_line import Complex, Jet, Ratio
from slipwave.observe.pieces import Array


def reduction_ratio(model: Reduction, epsilon: float, transit: float, s: Jet) -> Ratio:
    """(p, q) with Z = q/p of a reduction; s on the friction clock, `transit` and `epsilon` are those of the upper slab.

    Each new term n/d turns q/p into (q d + n p)/(p d). Both are divided by powers of (1 + t/1000), t = s * transit, so that 64
    modes do not overflow; p and q are analytic to the right of t = -1000.
    """
    t = s * transit
    p, q = s.constant(1.0), (t * model.mass + model.damping) * epsilon
    for n, d in _terms(model, t):
        p, q = p * d, q * d + n * p * epsilon
    return p, q


def _terms(model: Reduction, t: Jet) -> list[Ratio]:
    """(numerator, denominator) of every term of Z/epsilon except mass and damping; t = s * transit."""
    tame = 1.0 / (1.0 + t * 1e-3)
    terms = [(model.spring * tame, t * tame)] if model.spring else []
    for omega, residue, decay, offset in model.modes:
        scale = tame * tame * omega**-2
        terms.append(((t * residue + offset) * scale, (t * t + t * (2.0 * decay) + omega**2) * scale))
    for strength, rate in model.relaxations:
        scale = tame * (1.0 / rate)
        terms.append((strength * scale, (t + rate) * scale))
    return terms


def poles_and_residues(model: Reduction) -> tuple[Complex, Complex]:
    """Poles (in 1/transit) of Z/epsilon and the residues there, including conjugates; the spring's pole 0 comes first.

    A mode's pole pair is -decay +- i sqrt(omega^2 - decay^2), its residue (residue s + offset)/(2 s + 2 decay).
    """
    poles: list[complex] = [0.0] if model.spring else []
    residues: list[complex] = [model.spring] if model.spring else []
    for omega, residue, decay, offset in model.modes:
        root = cmath.sqrt(decay**2 - omega**2)
        for pole in (-decay + root, -decay - root):
            poles.append(pole)
            residues.append((residue * pole + offset) / (2.0 * (pole + decay)))
    for strength, rate in model.relaxations:
        poles.append(-rate)
        residues.append(strength)
    return np.array(poles, dtype=complex), np.array(residues, dtype=complex)


def real_part_on_axis(ratio: Ratio) -> Array:
    """Re Z relative to |Z| from a (p, q) evaluated on s = i omega or in the right half plane: >= 0 for a passive one-port."""
    p, q = ratio[0].value, ratio[1].value
    return np.asarray((q * p.conj()).real / (np.abs(q) * np.abs(p) + 1e-300))


def state_space(model: Reduction) -> tuple[Array, Array, Array]:
    """(A, B, C) of Z/epsilon = C (s - A)^-1 B + damping + mass s, transit clock: the spring, if there is one, two states of every
    mode, those of an oscillator scaled by its frequency to equal size, and the relaxations."""
    sprung, pairs = int(model.spring > 0.0), len(model.frequencies)
    n = sprung + 2 * pairs + len(model.relaxations)
    a, b, c = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    b[:sprung], c[:sprung] = 1.0, model.spring
    for first, (omega, residue, decay, offset) in zip(range(sprung, n, 2), model.modes, strict=False):
        second = first + 1
        a[first, second], a[second, first], a[second, second] = omega, -omega, -2.0 * decay
        b[second], c[first], c[second] = 1.0, offset / omega, residue
    for k, (strength, rate) in enumerate(model.relaxations, start=sprung + 2 * pairs):
        a[k, k], b[k], c[k] = -rate, 1.0, strength
    return a, b, c


def dissipation(model: Reduction, omega: Array) -> Array:
    """Re Z(i omega)/epsilon, omega in radians per transit."""
    terms = _terms(replace(model, spring=0.0), Jet.variable(1j * np.asarray(omega, dtype=float)))
    return np.asarray(model.damping + np.zeros(np.shape(omega)) + sum((n.value / d.value).real for n, d in terms))


def sign_frequencies(model: Reduction) -> Array:
    """Frequencies (radians per transit) that decide passivity: those of the poles, and at least one in every interval of the axis
    in which Re Z has one sign. A reduction is passive if Re Z is nowhere negative on them and its poles are stable."""
    turns = np.unique(np.concatenate([[0.0], np.abs(_zeros(model).imag), model.frequencies]))
    return np.concatenate([turns, 0.5 * (turns[1:] + turns[:-1]), [2.0 * turns[-1] + 1.0, 1e3 * (turns[-1] + 1.0)]])


def _zeros(model: Reduction) -> Complex:
    """Zeros of G(s) + G(-s)."""
    from scipy.linalg import eigvals

    a, b, c = state_space(replace(model, spring=0.0))
    n = b.size
    pencil, weight = np.zeros((2 * n + 1, 2 * n + 1)), np.diag(np.append(np.ones(2 * n), 0.0))
    pencil[:n, :n], pencil[n : 2 * n, n : 2 * n] = a, -a.T
    pencil[:n, -1], pencil[n : 2 * n, -1] = b, -c
    pencil[-1, :n], pencil[-1, n : 2 * n], pencil[-1, -1] = c, b, 2.0 * model.damping
    zeros = np.asarray(eigvals(pencil, weight), dtype=np.complex128)
    return zeros[np.isfinite(zeros)]
