"""Motions whose orbits, periods, multipliers and special points are known in closed form, as `Flow`s.

    w' = (p - g(s) + i (1 + c s)) w,   s = |w|^2

has the orbit |w|^2 = s where p = g(s), with the period 2 pi/(1 + c s) and the multiplier exp(-2 s g'(s) T): folds lie where
g' = 0. A second oscillator u beside it is linear:

    turning:  u' = (d(p) + 1.3 i) u, or without the turn                    multipliers exp((d +- 1.3 i) T)
    Moebius:  u = (y + i z) sqrt(w/|w|),  y' = d(p) y,  z' = -0.4 z         multipliers -exp(d T), -exp(-0.4 T)
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
from scipy.integrate import RK45

from slipwave import read
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Pieces
from slipwave.step.flow import Cycle, velocity_by_difference

TURN = 1.3
SHRINKS = -0.4
_LAW = read("paper").law
_TINY = 1e-30  # an imaginary change that leaves the real part as it is: the motion is analytic


class Oscillator(NamedTuple):
    """`g` and its derivative `slope` as functions of s; the shear c; the rate d(p) of the second oscillator, if there is one, and
    whether it is a Moebius strip."""

    g: Callable
    slope: Callable
    shear: float = 0.3
    beside: Callable | None = None
    turn: float = TURN
    moebius: bool = False

    def period(self, s):
        return 2.0 * math.pi / (1.0 + self.shear * s)

    def multiplier(self, s):
        return math.exp(-2.0 * s * self.slope(s) * self.period(s))

    def state(self, s):
        """On the orbit, an eighth of the period after the largest z."""
        w = math.sqrt(0.5 * s) * np.ones(2)
        return np.r_[0.0, 0.0, w] if self.beside else w


SUPERCRITICAL = Oscillator(lambda s: s, lambda s: 1.0)
SUBCRITICAL = Oscillator(lambda s: s * s - s, lambda s: 2.0 * s - 1.0)
"""Its orbits exist from p = -1/4, where s = 1/2; those of s < 1/2, born at p = 0, are unstable."""
SNAKE = Oscillator(lambda s: 0.02 * s + 0.03 * np.sin(6.0 * s), lambda s: 0.02 + 0.18 * np.cos(6.0 * s), 0.02)


@dataclass(frozen=True)
class FlowByHand:
    """The motion of an `oscillator`. A state is (u, w), each as two reals, or w alone; z and psi are the parts of w. On an orbit
    the growth of |w| and the velocity of its angle are constant, so that `steps` have no errors but in multipliers. `roughest`:
    factor of the roughness; `radius`: what the flow gives as essential."""

    oscillator: Oscillator
    parameter: float
    steps: int = 6
    roughest: float = 0.0
    radius: float = 0.0
    model = "by hand"
    nodes = np.arange(1, 9) / 8.0

    @property
    def scene(self):
        return SimpleNamespace(name="by hand", digest="none", law=_LAW, slabs=(), p=self.parameter)

    @property
    def size(self):
        return 4 if self.oscillator.beside else 2

    @property
    def steady(self):
        return np.zeros(self.size)

    def of(self, scene):
        return replace(self, parameter=scene.p)

    def mesh_state(self):
        return {"steps": np.array([float(self.steps)])}

    def on_mesh(self, state):
        return replace(self, steps=int(state["steps"][0]))

    def remeshed(self, cycle, finer):
        return replace(self, steps=math.ceil(finer * self.steps - 1e-9)), cycle.start

    def loosened(self, start, scenes):
        return self, start

    def roughness(self, cycle, tolerance):
        return self.roughest * np.ptp(cycle.pieces.psi) * (6.0 / self.steps) ** self.nodes.size / tolerance

    def march(self, start, period):
        grown, turned = self._motion(start[:, None], period)
        if not np.isfinite(grown).all() or np.abs(grown).max() > 5.0:
            raise NumericsError("by hand: the motion runs away")
        times = (np.arange(self.steps)[:, None] + self.nodes).ravel() / self.steps * period
        knots = np.linspace(0.0, period, self.steps + 1)
        w = complex(*start[-2:]) * np.exp(np.interp(times, knots, grown[:, 0]) + 1j * np.interp(times, knots, turned[:, 0]))
        z, psi = (part.reshape(self.steps, -1) for part in (w.real, w.imag))
        pieces = Pieces(knots[:-1], np.diff(knots), z, psi, 0.5 * psi, 0.25 * z)
        return Cycle(period, start, self._end(start[:, None], period, grown[-1], turned[-1])[:, 0], pieces, self.steps)

    def velocity(self, cycle):
        return velocity_by_difference(self, cycle)

    def tangent(self, cycle):
        starts = cycle.start[:, None] + 1j * _TINY * np.eye(self.size)
        grown, turned = self._motion(starts, cycle.period)
        return self._end(starts, cycle.period, grown[-1], turned[-1]).imag / _TINY

    def essential_radius(self, cycle):
        return self.radius

    @property
    def idle(self):
        return np.zeros((self.size, 0))

    @property
    def undecided(self):
        return self.radius == 1.0

    def _motion(self, starts, period):
        """ln |w(t)/w(0)| and the angle between w(0) and w(t) (steps + 1, m) of m motions, by a Runge-Kutta rule of order 5."""
        s, one, h, weights = starts[-2] ** 2 + starts[-1] ** 2, self.oscillator, period / self.steps, RK45.B
        grown, turned = np.zeros((2, self.steps + 1, s.size), s.dtype)
        growth, velocity = np.empty((2, weights.size, s.size), s.dtype)
        for n in range(self.steps):
            for k in range(weights.size):
                now = s * np.exp(2.0 * (grown[n] + h * RK45.A[k, :k] @ growth[:k]))
                growth[k], velocity[k] = self.parameter - one.g(now), 1.0 + one.shear * now
            grown[n + 1], turned[n + 1] = grown[n] + h * weights @ growth, turned[n] + h * weights @ velocity
        return grown, turned

    def _end(self, starts, period, grown, turned):
        """Written in reals, so that imaginary changes stay apart."""
        x, y = starts[-2:]
        plane = np.exp(grown) * _rotated(x, y, turned)
        if self.oscillator.beside is None:
            return plane
        u, v, d = starts[0], starts[1], self.oscillator.beside(self.parameter)
        if not self.oscillator.moebius:
            return np.concatenate([math.exp(d * period) * _rotated(u, v, self.oscillator.turn * period), plane])
        r = np.sqrt(x * x + y * y)
        mean, half = math.exp(0.5 * (d + SHRINKS) * period), 0.5 * (d - SHRINKS) * period
        along, across = (x * u + y * v) / r, (y * u - x * v) / r
        grow, mix = mean * math.cosh(half), mean * math.sinh(half)
        return np.concatenate([_rotated(grow * u + mix * along, grow * v + mix * across, 0.5 * turned), plane])


def _rotated(x, y, angle):
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * x - sin * y, sin * x + cos * y])
