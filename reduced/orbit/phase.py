"""The phase response Z of an orbit: by how much a short pulse advances all later events, to first order, stable orbit or not.

With the left eigenvector w of the multiplier 1, w . dx/dt = 1, a small change dx of the state lets all later events come w . dx
earlier. `Flow.pulses` carries w backwards along the orbit. An impulse is the integral of a shear stress on the interface, or of a
change of the drive V, over a time in which Z hardly changes. The stress comes from outside: friction feels it, the slabs feel the
slip that it causes. A constant extra stress or velocity changes T by minus the integral of Z over the period.

A modulation A cos(2 pi t/P), with n P near T, advances the events by A Z cos per unit of time. Of this, only the product with the
n-th harmonic of Z does not average out, so that a cycle of n P follows from one of T, the cycle is locked, where

    |n P/T - 1| <= A |z_n|,     z_n = (1/T) integral of Z(t) exp(-2 pi i n t/T) dt.

White noise of the two-sided spectral density S (autocorrelation S delta(t)) lets the dates of events diffuse: their variance
grows by S times the mean of Z^2 per unit of time, 2 D with D = S/(2 T) integral of Z^2 dt. All this is to first order in A and S.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from slipwave.observe.pieces import Array, interpolation_matrix, lagrange_basis
from slipwave.step.collocation import radau
from slipwave.step.flow import Pulses


@dataclass(frozen=True, eq=False)
class PhaseResponse:
    """Z at the nodes of `pulses`, on the motion of the `period` (transits) in steps of these `nodes`: of stress in 1/(normal
    stress), of the drive in 1/V*."""

    pulses: Pulses
    period: float
    nodes: Array

    def at(self, times: Array) -> Array:
        """Z (2, m) of stress and drive at `times` (transits, since the start of the orbit's motion)."""
        known, times = self.pulses, times % self.period
        which = np.searchsorted(known.time, times, side="right") - 1
        rows = interpolation_matrix(lagrange_basis(self.nodes), (times - known.time[which]) / known.length[which])
        return np.stack([np.add.reduce(rows * values[which], axis=1) for values in (known.stress, known.drive)])

    @cached_property
    def samples(self) -> tuple[Array, Array, Array]:
        """Times (k, s) in the period, their weights in an integral, and Z (2, k, s)."""
        begin = np.maximum(self.pulses.time, 0.0)
        length = (self.pulses.time + self.pulses.length - begin)[:, None]
        times = begin[:, None] + length * self.nodes
        return times, length * radau(self.nodes.size).integral[-1], self.at(times.ravel()).reshape(2, *times.shape)

    def harmonics(self, most: int) -> Array:
        """|z_n| (2, `most`) for n = 1, 2 ..."""
        times, weights, values = self.samples
        once = np.exp(-2j * np.pi / self.period * times.ravel())
        turns = np.multiply.accumulate(np.broadcast_to(once, (most, once.size)))
        return np.asarray(np.abs((weights * values).reshape(2, -1) @ turns.T) / self.period)

    @property
    def diffusion(self) -> Array:
        """D/S (2,)."""
        _, weights, values = self.samples
        return np.asarray(0.5 * (weights * values**2).sum(axis=(1, 2)) / self.period)
