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

`reduced.families` lists the reductions.
"""

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

from reduced.families import MOST_MODES, REDUCTIONS
from slipwave.errors import SceneError


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


def _modal(modes: int) -> Reduction:
    frequencies = tuple(2.0 * math.pi * k for k in range(1, modes + 1))
    mass = 1.0 / 12.0 - sum(2.0 / omega**2 for omega in frequencies)
    reduced = Reduction(f"modal:{modes}", mass=mass, frequencies=frequencies, residues=(2.0,) * modes)
    return reduced.driven(tuple(2.0 * (-1.0) ** k for k in range(1, modes + 1)))


TABULATED: dict[str, Callable[[], Reduction]] = {
    "quasistatic": lambda: Reduction("quasistatic"),
    "quasidynamic": lambda: Reduction("quasidynamic", damping=0.5),
    "block8": lambda: Reduction("block8", mass=1.0 / 8.0),
    "block12": lambda: Reduction("block12", mass=1.0 / 12.0),
    # (11), (14), (41): (1/s)(1 + s^2/8)/(1 + s^2/24) = 1/s + 2 s/(s^2 + 24), and V by (1/s)/(1 + s^2/24) = 1/s - s/(s^2 + 24)
    "kelvin-voigt": lambda: Reduction("kelvin-voigt", frequencies=(math.sqrt(24.0),), residues=(2.0,)).driven((-1.0,)),
}
"""Reductions of the alike pair in closed form, except modal:N (`_modal`)."""


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
        return _modal(mode_count(name))
    raise SceneError(f"model = {name!r} is not an ODE reduction; known: {', '.join(family.pattern for family in REDUCTIONS)}")


def mode_count(name: str) -> int:
    """N of `modal:N` or `fitted:N`. Raises SceneError outside 0..64."""
    kind, _, count = name.partition(":")
    if not count.isascii() or not count.isdigit() or int(count) > MOST_MODES:
        raise SceneError(f"model = {name!r}: {kind}:N needs a whole number N in 0..{MOST_MODES}")
    return int(count)
