"""The impedance of a reduction: a rational function of s, its poles, and its real part."""

import cmath

import numpy as np
from numpy.typing import NDArray

from reduced.impedance.jet import Complex, Jet
from reduced.impedance.reduction import Reduction
from reduced.impedance.transmission_line import Ratio


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
    for omega, residue, decay, offset in zip(model.frequencies, model.residues, model.decays, model.offsets, strict=True):
        scale = tame * tame * omega**-2
        terms.append(((t * residue + offset) * scale, (t * t + t * (2.0 * decay) + omega**2) * scale))
    for strength, rate in model.relaxations:
        scale = tame * (1.0 / rate)
        terms.append((strength * scale, (t + rate) * scale))
    return terms


def taylor_ratio(epsilon: float, transit: float, s: Jet) -> Ratio:
    """(p, q) of the next Taylor truncation after the paper's, Z = (eps/s)(1 + s^2/8 + s^4/384)/(1 + s^2/24 + s^4/1920). It is
    unusable because it has poles in the right half plane; it is analysed but never integrated."""
    square = (s * transit) * (s * transit)
    return s * transit * (1.0 + square * (1.0 / 24.0 + square * (1.0 / 1920.0))), (
        1.0 + square * (1.0 / 8.0 + square * (1.0 / 384.0))
    ) * epsilon


def poles_and_residues(model: Reduction) -> tuple[Complex, Complex]:
    """Poles (in 1/transit) of Z/epsilon and the residues there, including conjugates; the spring's pole 0 comes first.

    A mode's pole pair is -decay +- i sqrt(omega^2 - decay^2), its residue (residue s + offset)/(2 s + 2 decay).
    """
    poles: list[complex] = [0.0] if model.spring else []
    residues: list[complex] = [model.spring] if model.spring else []
    for omega, residue, decay, offset in zip(model.frequencies, model.residues, model.decays, model.offsets, strict=True):
        root = cmath.sqrt(decay**2 - omega**2)
        for pole in (-decay + root, -decay - root):
            poles.append(pole)
            residues.append((residue * pole + offset) / (2.0 * (pole + decay)))
    for strength, rate in model.relaxations:
        poles.append(-rate)
        residues.append(strength)
    return np.array(poles, dtype=complex), np.array(residues, dtype=complex)


def taylor_poles() -> Complex:
    """Poles (in 1/transit) of the next Taylor truncation: 0 and four more, two of them in the right half plane."""
    return np.concatenate([[0.0], np.roots([1.0 / 1920.0, 0.0, 1.0 / 24.0, 0.0, 1.0])]).astype(complex)


def real_part_on_axis(ratio: Ratio) -> NDArray[np.float64]:
    """Re Z relative to |Z| from a (p, q) evaluated on s = i omega or in the right half plane: >= 0 for a passive one-port."""
    p, q = ratio[0].value, ratio[1].value
    return np.asarray((q * p.conj()).real / (np.abs(q) * np.abs(p) + 1e-300))
