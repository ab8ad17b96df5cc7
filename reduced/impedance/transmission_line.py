"""Exact one-ports: slabs as chained transmission-line sections (MODEL.md section 3).

A one-port is stored as a pair (p, q) with admittance Y = p/q and impedance Z = q/p. Poles of Y and Z are then zeros of a function
that is analytic wherever the slab's material law is (everywhere if elastic, right of the relaxation rates if viscous). A section
of impedance Z_c and one-way travel time T turns the pair at its far end into the pair at its near end,

    Y_in = Y_c (Y_far + Y_c tanh x)/(Y_c + Y_far tanh x),   x = s T,   tanh x = (1 - E)/(1 + E),   E = e^(-2 x),

with both multiplied by 1 + E, so that nothing overflows in the right half plane. s is on the friction clock, in 1/(L/V*).

A `Jet` is a value with its derivative in s: one formula gives both Z and dZ/ds (forward differentiation).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from slipwave.scene import Scene
from slipwave.scene.slab import Slab

Complex: TypeAlias = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Jet:
    """Complex arrays `value` and `slope` = d value/ds of one shape."""

    value: Complex
    slope: Complex

    @staticmethod
    def variable(s: object) -> Jet:
        """The jet of s itself, slope 1."""
        value = np.asarray(s, dtype=np.complex128)
        return Jet(value, np.ones_like(value))

    def constant(self, number: complex) -> Jet:
        """The jet of the constant `number`, slope 0, of the same shape."""
        return Jet(np.full_like(self.value, number), np.zeros_like(self.value))

    def __add__(self, other: Jet | complex) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.slope)
        return Jet(self.value + other.value, self.slope + other.slope)

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet(-self.value, -self.slope)

    def __sub__(self, other: Jet | complex) -> Jet:
        return self + (-other)

    def __rsub__(self, other: complex) -> Jet:
        return -self + other

    def __mul__(self, other: Jet | complex) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value * other, self.slope * other)
        return Jet(self.value * other.value, self.slope * other.value + self.value * other.slope)

    __rmul__ = __mul__

    def __truediv__(self, other: Jet | complex) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.value / other, self.slope / other)
        quotient = self.value / other.value
        return Jet(quotient, (self.slope - quotient * other.slope) / other.value)

    def __rtruediv__(self, other: complex) -> Jet:
        return self.constant(other) / self

    def sqrt(self) -> Jet:
        """Principal square root."""
        root = np.sqrt(self.value)
        return Jet(root, self.slope / (2.0 * root))

    def expm1(self) -> Jet:
        """e^x - 1 without cancellation near 0; -1 for a large negative real part."""
        value = np.expm1(self.value)
        return Jet(value, (1.0 + value) * self.slope)


Ratio: TypeAlias = tuple[Jet, Jet]
"""(p, q) with Y = p/q and Z = q/p."""


def _root_of_modulus(slab: Slab, s: Jet) -> Jet | float:
    """sqrt(G(s)/G), the factor of wave speed and impedance, with the (unrelaxed) modulus G to which epsilon and the round trip
    refer; 1 for an elastic slab."""
    if slab.viscosity is None:
        return 1.0
    modulus: Jet = slab.rheology.modulus(s)
    return modulus.sqrt()


def _outer_face(slab: Slab, s: Jet) -> Ratio:
    """(p, q) of the outer face's termination, seen from the slab: Z = mass s + dashpot + spring/s; both over epsilon."""
    held = slab.termination
    if held.is_rigid:
        return s.constant(0.0), s.constant(1.0)
    resistance = (s * held.mass + held.dashpot) * (1.0 / slab.epsilon)
    if held.has_dead_load:
        return s.constant(1.0 / slab.epsilon), resistance
    return s * (1.0 / slab.epsilon), s * resistance + held.spring / slab.epsilon


def slab_ratio(slab: Slab, s: Jet) -> Ratio:
    """(p, q) of one slab at the interface: velocity w of its inner face per stress on it, Y = p/q.

    A rigid face gives Y = tanh(s r/2)/epsilon; layers are chained from the outer face inwards.
    """
    p, q = _outer_face(slab, s)
    root = _root_of_modulus(slab, s)
    echoes: dict[float, Jet] = {}  # 1 - E of layers with this fraction
    for layer in reversed(slab.layers):
        admittance = 1.0 / (root * (slab.epsilon * layer.impedance))
        if layer.fraction not in echoes:
            echoes[layer.fraction] = -(s * (-slab.round_trip * layer.fraction) / root).expm1()
        backward = echoes[layer.fraction]
        forward = 2.0 - backward
        p, q = p * forward + (q * backward) * admittance, q * forward + (p * backward) / admittance
    return p, q


def pair_ratio(scene: Scene, s: Jet) -> Ratio:
    """(p, q) of both slabs in series, Y = Y_1 + Y_2 = p/q: slip rate v per stress. Slabs with an `equivalent`: Y = 2 Y_1 of it,
    without the modes in which both slabs move together without stress or slip at the interface."""
    p, q = slab_ratio(scene.slabs[0], s)
    if len(scene.slabs) == 1:
        return p * 2.0, q
    below_p, below_q = slab_ratio(scene.lower, s)
    return p * below_q + below_p * q, q * below_q


def drive_ratio(scene: Scene, s: Jet) -> Ratio:
    """(p, n) of the stress T V at an interface without slip, T = n/p, when both outer faces are driven at V/2 each.

    For alike slabs behind rigid faces T = eps/(2 sinh(s r/2)). A free slab passes the velocity of its drive on with a factor H;
    T = Z (H_1 + H_2)/2."""
    p, q = slab_ratio(scene.slabs[0], s)
    if len(scene.slabs) == 1:
        return p * 2.0, _passed(scene.slabs[0], s)
    below_p, below_q = slab_ratio(scene.lower, s)
    passed = _passed(scene.upper, s) * below_q + _passed(scene.lower, s) * q
    return p * below_q + below_p * q, passed * 0.5


def _passed(slab: Slab, s: Jet) -> Jet:
    """H q of a slab, with the factors 1 + E of `slab_ratio`: the part of q of `_outer_face` that couples the face to the drive,
    all but its mass, delayed by all layers."""
    held, root = slab.termination, _root_of_modulus(slab, s)
    if held.is_rigid:
        passed = s.constant(1.0)
    elif held.has_dead_load:
        passed = s.constant(held.dashpot / slab.epsilon)
    else:
        passed = (s * held.dashpot + held.spring) * (1.0 / slab.epsilon)
    for layer in slab.layers:
        passed = passed * ((s * (-0.5 * slab.round_trip * layer.fraction) / root).expm1() + 1.0) * 2.0
    return passed
