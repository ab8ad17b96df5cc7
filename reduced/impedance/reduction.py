"""ODE reductions: every simplified slab pair is one passive one-port, written as data (MODEL.md section 3).

The pair responds to the slip rate with  delta_mu = -Z(s) delta_v  and, with s in 1/transit and epsilon of the upper slab,

    Z(s)/epsilon = spring/s + mass s + damping + sum_k (residue_k s + offset_k)/(s^2 + 2 decay_k s + omega_k^2)
                   + sum_j strength_j/(s + rate_j).

Alike elastic slabs behind rigid faces have spring = 1 and need neither offsets nor relaxations, which occur in fits of lossy
scenes. As ODEs, with u = v - V and the stress tau_k of mode k (in units of epsilon):

    tau_k' = -residue_k u - 2 decay_k tau_k + p_k,   p_k' = -offset_k u - omega_k^2 tau_k,
    tau_j' = -strength_j u - rate_j tau_j,            y' = -spring u,   mass v' + damping u = y + sum tau - mu/epsilon.

V acts at the outer faces, half a transit away. Its stress at an interface without slip is T(s) delta_V, for alike slabs
eps/(2 sinh(s/2)) = eps (1/s + sum_k (-1)^k 2 s/(s^2 + (2 pi k)^2)): a reduction with modes has this as its `transfer`, and u = v
in the equations of tau, which the transfer's terms drive by V. In the others V acts on the spring and on the damping.

The frequencies at which Re Z can change its sign follow from the eigenvalues of a Hamiltonian pencil, so that no interval is
missed. Spring and mass do not dissipate. The rest is G(s) = D + C (s - A)^-1 B with the damping D, and G(s) + G(-s) is 0 exactly
at the finite eigenvalues of

    [[A, 0, B], [0, -A^T, -C^T], [C, B^T, 2 D]] x = s [[1, 0, 0], [0, 1, 0], [0, 0, 0]] x

(Boyd, Balakrishnan and Kabamba 1989, as a pencil, so that D may be 0). Re G(i omega) changes its sign only at imaginary ones.
Rounding displaces these from the axis; therefore the imaginary parts of all eigenvalues are used, though some are not zeros of Re
G.

`reduced.families` lists the reductions.
"""

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from reduced.families import MOST_MODES, REDUCTIONS
from reduced.impedance.transmission_line import Complex, Jet, Ratio
from slipwave.errors import SceneError
from slipwave.input.wording import shorten
from slipwave.observe.pieces import Array

_POLE_TOLERANCE = 1e-9
_ALLOWED: dict[str, tuple[int, Any, str]] = {
    "mass": (0, 0.0, "a number from 0"),
    "damping": (0, 0.0, "a number from 0"),
    "spring": (0, 0.0, "a number from 0"),
    "frequencies": (1, 1e-12, "a tuple of numbers above 0"),
    "residues": (1, -math.inf, "a tuple of numbers"),
    "decays": (1, 0.0, "a tuple of numbers from 0"),
    "offsets": (1, -math.inf, "a tuple of numbers"),
    "relaxations": (2, (-math.inf, 1e-12), "a tuple of pairs (strength, rate above 0)"),
}
"""Field -> depth of its tuples, least value, and what it must be."""


@dataclass(frozen=True)
class Reduction:
    """Poles, residues, mass and damping of a reduced pair, relative to the upper slab's epsilon, transit clock t~.

    `frequencies` are omega_k (radians per transit); `residues`, and `decays` and `offsets` unless all are zero, are as many.
    `transfer`: T(s)/epsilon of a drive that changes, with the same spring; None if V acts as the opposite slip rate. `is_fitted`:
    it was fitted to the exact impedance of its scene.
    """

    name: str
    mass: float = 0.0
    damping: float = 0.0
    frequencies: tuple[float, ...] = ()
    residues: tuple[float, ...] = ()
    decays: tuple[float, ...] = ()
    offsets: tuple[float, ...] = ()
    relaxations: tuple[tuple[float, float], ...] = ()
    spring: float = 1.0
    transfer: "Reduction | None" = None
    is_fitted: bool = False

    def of_slabs(self) -> "Reduction":
        """Itself. Raises SceneError, which names the first of its values that no passive slabs have."""
        for key, (depth, least, form) in _ALLOWED.items():
            value = getattr(self, key)
            many = {len(self.frequencies), 0 if key in ("decays", "offsets") else len(self.frequencies)}
            try:
                numbers = np.asarray(value, dtype=float)
                shaped = (numbers.ndim, numbers.shape[1:]) == (depth, np.shape(least)) and hash(value) is not None
                fits = (depth > 0 and value == ()) or (shaped and bool(np.all((numbers >= least) & (numbers < math.inf))))
            except (TypeError, ValueError):  # no numbers, or a list
                fits = False
            if not fits:
                raise SceneError(f"model = {self.name!r}: {key} = {shorten(value)}: must be {form}")
            if depth == 1 and len(value) not in many:
                raise SceneError(f"model = {self.name!r}: {key} = {shorten(value)}: must be as many as frequencies")
        if not self.is_passive:
            raise SceneError(f"model = {self.name!r}: is not passive: Re Z(i omega) is negative; change its residues or offsets")
        return self

    @cached_property
    def is_passive(self) -> bool:
        """Whether Re Z >= 0 wherever its sign may change, no pole grows, and those on the axis have positive residues."""
        poles, residues = self.poles_and_residues()
        on_axis = np.abs(poles.real) <= _POLE_TOLERANCE
        if np.any((poles.real > _POLE_TOLERANCE) | (on_axis & (residues.real < 0.0))):
            return False
        s = () if self.is_lossless else np.maximum(self.sign_frequencies(), 1e-6)
        p, q = (jet.value / (np.abs(jet.value) + 1e-300) for jet in self.ratio(1.0, 1.0, Jet.variable(1j * np.array(s))))
        return bool(np.all((q * p.conj()).real >= -1e-9))

    @cached_property
    def modes(self) -> tuple[tuple[float, float, float, float], ...]:
        """(omega, residue, decay, offset) of each mode."""
        zeros = (0.0,) * len(self.frequencies)
        return tuple(zip(self.frequencies, self.residues, self.decays or zeros, self.offsets or zeros, strict=True))

    @property
    def terms(self) -> tuple[list[tuple[float, float, float, float]], list[tuple[float, float, float, float]]]:
        """(residue, offset, 2 decay, omega^2) of every mode, and of every relaxation, a mode without inertia."""
        modes = [(residue, offset, 2.0 * decay, omega * omega) for omega, residue, decay, offset in self.modes]
        return modes, [(strength, 0.0, rate, 0.0) for strength, rate in self.relaxations]

    def driven(self, residues: tuple[float, ...]) -> "Reduction":
        """This reduction with a transfer of the same poles and these residues."""
        return replace(self, transfer=Reduction(self.name, frequencies=self.frequencies, residues=residues, spring=self.spring))

    @property
    def is_lossless(self) -> bool:
        """Whether no term dissipates: Z is imaginary on the imaginary axis."""
        return self.damping == 0.0 and not any(self.decays) and not any(self.offsets) and not self.relaxations

    @property
    def is_active(self) -> bool:
        """Whether a mode grows by itself, so that no run is bounded."""
        return any(decay < 0.0 for decay in self.decays)

    @property
    def is_algebraic(self) -> bool:
        """Whether there is no mass: v follows from the stress by the interface condition. With mass, v is a state."""
        return self.mass == 0.0

    @property
    def runs_away(self) -> bool:
        """Whether nothing limits v after a loss of stability, so that there is no limit cycle (no inertia, no radiation)."""
        return self.is_algebraic and self.damping == 0.0 and not self.frequencies and not self.relaxations

    def ratio(self, epsilon: float, transit: float, s: Jet) -> Ratio:
        """(p, q) with Z = q/p of a reduction; s on the friction clock, `transit` and `epsilon` are those of the upper slab.

        Each new term n/d turns q/p into (q d + n p)/(p d). Both are divided by powers of (1 + t/1000), t = s * transit, so that
        64 modes do not overflow; p and q are analytic to the right of t = -1000.
        """
        t = s * transit
        p, q = s.constant(1.0), (t * self.mass + self.damping) * epsilon
        for n, d in self._ratios(t):
            p, q = p * d, q * d + n * p * epsilon
        return p, q

    def _ratios(self, t: Jet) -> list[Ratio]:
        """(numerator, denominator) of every term of Z/epsilon except mass and damping; t = s * transit."""
        tame = 1.0 / (1.0 + t * 1e-3)
        terms = [(self.spring * tame, t * tame)] if self.spring else []
        for omega, residue, decay, offset in self.modes:
            scale = tame * tame * omega**-2
            terms.append(((t * residue + offset) * scale, (t * t + t * (2.0 * decay) + omega**2) * scale))
        for strength, rate in self.relaxations:
            scale = tame * (1.0 / rate)
            terms.append((strength * scale, (t + rate) * scale))
        return terms

    def poles_and_residues(self) -> tuple[Complex, Complex]:
        """Poles (in 1/transit) of Z/epsilon and the residues there, including conjugates; the spring's pole 0 comes first.

        A mode's pole pair is -decay +- i sqrt(omega^2 - decay^2), its residue (residue s + offset)/(2 s + 2 decay).
        """
        poles: list[complex] = [0.0] if self.spring else []
        residues: list[complex] = [self.spring] if self.spring else []
        for omega, residue, decay, offset in self.modes:
            root = cmath.sqrt(decay**2 - omega**2)
            for pole in (-decay + root, -decay - root):
                poles.append(pole)
                residues.append((residue * pole + offset) / (2.0 * (pole + decay)))
        for strength, rate in self.relaxations:
            poles.append(-rate)
            residues.append(strength)
        return np.array(poles, dtype=complex), np.array(residues, dtype=complex)

    def state_space(self) -> tuple[Array, Array, Array]:
        """(A, B, C) of Z/epsilon = C (s - A)^-1 B + damping + mass s, transit clock: the spring, if there is one, two states of
        every mode, those of an oscillator scaled by its frequency to equal size, and the relaxations."""
        sprung, pairs = int(self.spring > 0.0), len(self.frequencies)
        n = sprung + 2 * pairs + len(self.relaxations)
        a, b, c = np.zeros((n, n)), np.zeros(n), np.zeros(n)
        b[:sprung], c[:sprung] = 1.0, self.spring
        for first, (omega, residue, decay, offset) in zip(range(sprung, n, 2), self.modes, strict=False):
            second = first + 1
            a[first, second], a[second, first], a[second, second] = omega, -omega, -2.0 * decay
            b[second], c[first], c[second] = 1.0, offset / omega, residue
        for k, (strength, rate) in enumerate(self.relaxations, start=sprung + 2 * pairs):
            a[k, k], b[k], c[k] = -rate, 1.0, strength
        return a, b, c

    def dissipation(self, omega: Array) -> Array:
        """Re Z(i omega)/epsilon, omega in radians per transit."""
        terms = replace(self, spring=0.0)._ratios(Jet.variable(1j * np.asarray(omega, dtype=float)))
        return np.asarray(self.damping + np.zeros(np.shape(omega)) + sum((n.value / d.value).real for n, d in terms))

    def sign_frequencies(self) -> Array:
        """Frequencies (radians per transit) that decide passivity: those of the poles, and at least one in every interval of the
        axis in which Re Z has one sign. A reduction is passive if Re Z is nowhere negative on them and its poles are stable."""
        turns = np.unique(np.concatenate([[0.0], np.abs(self._zeros().imag), self.frequencies]))
        return np.concatenate([turns, 0.5 * (turns[1:] + turns[:-1]), [2.0 * turns[-1] + 1.0, 1e3 * (turns[-1] + 1.0)]])

    def _zeros(self) -> Complex:
        """Zeros of G(s) + G(-s)."""
        from scipy.linalg import eigvals

        a, b, c = replace(self, spring=0.0).state_space()
        n = b.size
        pencil, weight = np.zeros((2 * n + 1, 2 * n + 1)), np.diag(np.append(np.ones(2 * n), 0.0))
        pencil[:n, :n], pencil[n : 2 * n, n : 2 * n] = a, -a.T
        pencil[:n, -1], pencil[n : 2 * n, -1] = b, -c
        pencil[-1, :n], pencil[-1, n : 2 * n], pencil[-1, -1] = c, b, 2.0 * self.damping
        zeros = np.asarray(eigvals(pencil, weight), dtype=np.complex128)
        return zeros[np.isfinite(zeros)]


TABULATED: dict[str, Callable[[], Reduction]] = {
    "quasistatic": lambda: Reduction("quasistatic"),
    "quasidynamic": lambda: Reduction("quasidynamic", damping=0.5),
    "block8": lambda: Reduction("block8", mass=1.0 / 8.0),
    "block12": lambda: Reduction("block12", mass=1.0 / 12.0),
    # (11), (14), (41): (1/s)(1 + s^2/8)/(1 + s^2/24) = 1/s + 2 s/(s^2 + 24), and V by (1/s)/(1 + s^2/24) = 1/s - s/(s^2 + 24)
    "kelvin-voigt": lambda: Reduction("kelvin-voigt", frequencies=(math.sqrt(24.0),), residues=(2.0,)).driven((-1.0,)),
}
"""Reductions of the alike pair in closed form, except modal:N (`reduction`)."""


def _taylor() -> Reduction:
    pole = cmath.sqrt(complex(-40.0, math.sqrt(320.0)))  # 1 + s^2/24 + s^4/1920 = 0; the others are its mirror images
    square = pole * pole
    at_pole = (1.0 + square / 8.0 + square * square / 384.0) / (square / 12.0 + square * square / 480.0)
    residue, offset = 2.0 * at_pole.real, 2.0 * (at_pole * pole.conjugate()).real
    return Reduction("taylor", 0.0, 0.0, (abs(pole),) * 2, (residue,) * 2, (-pole.real, pole.real), (-offset, offset))


TAYLOR = _taylor()
"""The next Taylor truncation after the paper's, Z = (eps/s)(1 + s^2/8 + s^4/384)/(1 + s^2/24 + s^4/1920). It is unusable because
it has poles in the right half plane; it is analysed but never integrated."""


def reduction(name: str) -> Reduction:
    """The reduction `name` of an alike pair of homogeneous elastic slabs behind rigid faces.

    Raises SceneError for an unknown name (listing the known ones), for a mode count outside 0..64, and for `taylor`, the next
    truncation after the paper's: it has poles in the right half plane, so that no run of it is bounded.
    """
    if name in TABULATED:
        return TABULATED[name]()
    if name == TAYLOR.name:
        raise SceneError(
            "model = 'taylor': its impedance has poles in the right half plane, every run of it blows up; use modal:N"
        )
    if name.partition(":")[0] == "modal":
        modes = mode_count(name)
        frequencies = tuple(2.0 * math.pi * k for k in range(1, modes + 1))
        mass = 1.0 / 12.0 - sum(2.0 / omega**2 for omega in frequencies)
        reduced = Reduction(f"modal:{modes}", mass=mass, frequencies=frequencies, residues=(2.0,) * modes)
        return reduced.driven(tuple(2.0 * (-1.0) ** k for k in range(1, modes + 1)))
    raise SceneError(f"model = {name!r} is not an ODE reduction; known: {', '.join(family.pattern for family in REDUCTIONS)}")


def mode_count(name: str) -> int:
    """N of `modal:N` or `fitted:N`. Raises SceneError outside 0..64."""
    kind, _, count = name.partition(":")
    if not count.isascii() or not count.isdigit() or int(count) > MOST_MODES:
        raise SceneError(f"model = {name!r}: {kind}:N needs a whole number N in 0..{MOST_MODES}")
    return int(count)
