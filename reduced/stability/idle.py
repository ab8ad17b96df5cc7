"""Idle modes: both slabs oscillate alike, without slip or stress at the interface, so that friction does not damp them.

A slab's free vibrations are the zeros omega_k of its reactance X, Z(i omega) = i X, which grows with omega (Foster's theorem). An
idle mode is a free vibration of both. If omega_1 and omega_2 of the slabs differ slightly, they oscillate together with a little
slip, which dissipates: with M = dX/domega at omega_1 and omega_2, to first order in their difference,

    omega = (M_1 omega_1 + M_2 omega_2)/(M_1 + M_2),     decay = (omega_1 - omega_2)^2 M_1^2 M_2^2/((M_1 + M_2)^3 F_v).

For the unregularised laws 1/F_v = v/a, and as the mean of v over any orbit is V, the decay in a period is that of steady sliding.
"""

import math
from typing import NamedTuple

import numpy as np

from reduced.impedance import Jet
from reduced.impedance.transmission_line import slab_ratio
from slipwave.friction.law import friction_slopes
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.slab import Slab

_HIGHEST = 400  # in units of pi/(round trip of the upper slab)
_PER_UNIT = 60  # samples in such a unit
_OFFSET = 0.382  # of the samples, in their distance: none is to fall on a pole
_SAME = 1e-9  # relative difference of two frequencies that are the same but for rounding
_NAMED = 4
_SLOW = 1e-3  # decay in a transit above which a mode is not worth its name
_CORRECTIONS = 4


class IdleMode(NamedTuple):
    """A vibration with `upper` and `lower` quarter waves in the slabs (layered: 2 n - 1 for the n-th vibration), its `frequency`
    (cycles per transit) and `decay` (1/transit), 0 without any damping."""

    upper: int
    lower: int
    frequency: float
    decay: float

    def multiplier(self, period: float) -> complex:
        """Multiplier of the mode on an orbit of this `period` (transits)."""
        return complex(np.exp((2j * math.pi * self.frequency - self.decay) * period))


def idle_modes(scene: Scene) -> tuple[IdleMode, ...]:
    """Idle modes of slabs without losses: the first few by frequency or, if there are none, the nearly idle ones that decay more
    slowly than all of lower frequency."""
    (upper, upper_mass), (lower, lower_mass) = (_free_vibrations(slab, scene.transit) for slab in (scene.upper, scene.lower))
    nearest = np.abs(upper[:, None] - lower).argmin(axis=1)
    apart, mass = upper - lower[nearest], upper_mass + lower_mass[nearest]
    apart[np.abs(apart) < _SAME * upper] = 0.0
    friction = friction_slopes(scene.law, scene.velocity).direct
    decays = (apart * upper_mass * lower_mass[nearest]) ** 2 / (mass**3 * friction)
    frequencies = (upper_mass * upper + lower_mass[nearest] * lower[nearest]) / mass / (2.0 * math.pi)
    modes: list[IdleMode] = []
    for n, decay in enumerate(decays.tolist()):
        if len(modes) < _NAMED and decay < _SLOW and (decay == 0.0 or all(decay < mode.decay for mode in modes)):
            modes.append(IdleMode(2 * n + 1, 2 * int(nearest[n]) + 1, float(frequencies[n]), decay))
    return tuple(modes)


def named(modes: tuple[IdleMode, ...], period: float) -> str:
    """Text that lists modes with their multipliers on an orbit of this `period` (transits)."""
    each = []
    for mode in modes:
        value = mode.multiplier(period)
        loss = f"modulus {abs(value):.6g}" if mode.decay else "modulus 1"
        waves = f"{mode.upper} and {mode.lower} quarter waves"
        each.append(
            f"{waves}, {mode.frequency:.6g} cycles a transit, multiplier {value.real:.5f} +- {abs(value.imag):.5f} i, {loss}"
        )
    return "; ".join(each)


def _free_vibrations(slab: Slab, transit: float) -> tuple[Array, Array]:
    """Angular frequencies (1/transit) of a slab whose inner face carries no stress, in order, and dX/domega there."""
    omega = (np.arange(_HIGHEST * _PER_UNIT) + _OFFSET) * math.pi / _PER_UNIT
    reactance = _reactance(slab, transit, omega)[0]
    before, after = reactance[:-1], reactance[1:]
    rises = np.flatnonzero((before < 0.0) & (after >= 0.0))
    zeros = omega[rises] - before[rises] * (omega[1] - omega[0]) / (after[rises] - before[rises])
    for _ in range(_CORRECTIONS):
        value, slope = _reactance(slab, transit, zeros)
        zeros = zeros - value / slope
    return zeros, _reactance(slab, transit, zeros)[1]


def _reactance(slab: Slab, transit: float, omega: Array) -> tuple[Array, Array]:
    """X and dX/domega at `omega` (1/transit)."""
    p, q = slab_ratio(slab, Jet.variable(1j * omega / transit))
    value = q.value / p.value
    slope = (q.slope - value * p.slope) / p.value
    return value.imag, slope.real / transit
