"""Modes of a lossless slab pair whose interface is locked: the poles of its impedance, and its impedance at low frequency.

On s = i omega a lossless section turns Y = i Y_c tan(alpha) at its far end into i Y_c tan(alpha + omega T) at its near end. So
the phase alpha of a chain of layers grows monotonically with omega with a known branch, so that no mode is missed. If the phases
of both slabs refer to the same impedance, Y_1 + Y_2 = 0 means beta_1 + beta_2 = k pi.
"""

import math

import numpy as np

from reduced.impedance.transmission_line import Jet, pair_ratio
from slipwave.scene import Scene
from slipwave.scene.slab import Slab

_NOT_COUPLED = 1e-9


def is_lossless(slab: Slab) -> bool:
    """Whether it is elastic with a rigid face, so that Z is imaginary on the imaginary axis; layers are allowed."""
    return slab.viscosity is None and slab.termination.is_rigid


def _rescale(angle: float, factor: float) -> float:
    """The angle whose tangent is `factor` times as large, on the same branch (by atan2, because tan has poles)."""
    turns = math.floor(angle / math.pi + 0.5) * math.pi
    return math.atan2(factor * math.sin(angle - turns), math.cos(angle - turns)) + turns


def _phase(slab: Slab, omega: float, reference: float) -> float:
    """beta(omega) with Y = (i/reference) tan beta; monotone."""
    angle, before = 0.0, slab.epsilon * slab.layers[-1].impedance
    for layer in reversed(slab.layers):
        here = slab.epsilon * layer.impedance
        angle = _rescale(angle, here / before) + 0.5 * omega * slab.round_trip * layer.fraction
        before = here
    return _rescale(angle, reference / before)


def _mode(scene: Scene, number: int, longest: float) -> float:
    """omega at which beta_1 + beta_2 = number * pi, by bisection down to rounding."""
    wanted, reference = number * math.pi, scene.impedance
    low, high = 0.0, 2.0 * math.pi * number / longest
    while _phase(scene.upper, high, reference) + _phase(scene.lower, high, reference) < wanted:
        high *= 2.0
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return middle
        if _phase(scene.upper, middle, reference) + _phase(scene.lower, middle, reference) < wanted:
            low = middle
        else:
            high = middle


def locked_modes(scene: Scene, count: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """(frequencies, residues) of the `count` lowest modes, relative to the upper slab's epsilon and transit.

    Near such a mode Z/epsilon = residue s/(s^2 + omega^2) + ..., residue = 2/(epsilon dY/ds) at s = i omega. Modes in which both
    slabs move together without stress at the interface do not couple to it and are left out.
    """
    frequencies: list[float] = []
    residues: list[float] = []
    longest = max(scene.upper.round_trip, scene.lower.round_trip)
    number = 0
    while len(frequencies) < count:
        number += 1
        omega = _mode(scene, number, longest)
        p, q = pair_ratio(scene, Jet.variable(1j * omega))
        residue = 2.0 * float((q.value / p.slope).real) * scene.transit / scene.upper.epsilon
        if residue > _NOT_COUPLED:
            frequencies.append(float(omega * scene.transit))
            residues.append(residue)
    return tuple(frequencies), tuple(residues)


def low_frequency(slab: Slab) -> tuple[float, float]:
    """(c_1, c_3) of Y = c_1 s + c_3 s^3 + ... of a lossless slab, s on the friction clock.

    Per layer, with x = s T and the coefficients f of the layers beyond: a_1 = f_1 + Y_c T,  a_3 = f_3 - Y_c T^3/3 - a_1 f_1
    T/Y_c.
    """
    first, third = 0.0, 0.0
    for layer in reversed(slab.layers):
        admittance = 1.0 / (slab.epsilon * layer.impedance)
        delay = 0.5 * slab.round_trip * layer.fraction
        total = first + admittance * delay
        third += -admittance * delay**3 / 3.0 - total * first * delay / admittance
        first = total
    return first, third


def spring_and_mass(scene: Scene) -> tuple[float, float]:
    """(spring, mass) of Z/epsilon = spring/s + mass s + ... of a lossless pair, transit clock; (1, 1/12) for the plain one."""
    first, third = np.add(low_frequency(scene.upper), low_frequency(scene.lower))
    epsilon, transit = scene.upper.epsilon, scene.transit
    return float(transit / (first * epsilon)), float(-third / (first**2 * epsilon * transit))
