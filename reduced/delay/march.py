"""Common part of all marches of the delay system: present state, counters, and errors for a step that cannot be resolved."""

import math
from typing import Any

import numpy as np

from reduced.delay.kernel import DelayMemory
from slipwave.errors import NumericsError
from slipwave.friction import allows_rest, respond, said_of_rest, unknown_of
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.solve import Energy
from slipwave.step.collocation import growth_limit, rule_of
from slipwave.step.newton import first_guess
from slipwave.step.nodal import PSI, TIME, TOO_STEEP, Interface, Limits, Physics, nodal_of

MAX_STEPS = 4096
"""Largest number of steps per transit."""

_MORE = 8  # times as many for laws that allow v <= 0: v, but for its rate, bends sharply where it changes its sign
_SLOW = 0.98  # of V, at most, in a stick

EXTREMES = 6
"""Values of `extremes`."""


def extremes(pieces: Pieces) -> Array:
    """The largest z, mu, y and the largest -z, -mu, -y at the nodes."""
    values = (pieces.z, pieces.mu, pieces.y)
    return np.array([*(value.max() for value in values), *(-value.min() for value in values)])


class DelayMarch:
    """Base of the solvers of the delay system; they keep their state in `_memory`, whose `now` is the present state."""

    model = "delay"
    seconds_per_piece = 2e-6  # 0.9 to 1.9 measured
    transits_per_piece = math.nan
    failed_at = math.nan
    bookkeeping = frozenset({"counts", "levels", "origin", "waiting", "leaps", "tries", "past", "past.incoming", "arrivals"})
    settings: dict[str, Any]
    _memory: DelayMemory

    def __init__(self, scene: Scene, stages: int, tolerance: float, resolution: float) -> None:
        self.scene, self._stages = scene, stages
        self.failures = 0
        self.iterations = 0
        matrices, rule, self._shape = rule_of(stages)
        self.nodes: Array = matrices.nodes
        self._physics, self._nodal = Physics(scene.law, scene.forcing, scene.drive.compiled, rule), nodal_of(stages)
        self._most_steps = MAX_STEPS * (_MORE if allows_rest(scene.law) else 1)
        self._limits = Limits(max(1e-3 * tolerance, 1e-14), resolution, growth_limit(stages, tolerance))

    @property
    def time(self) -> float:
        """Transits since the start."""
        return float(self._memory.now[TIME])

    def energy(self) -> Energy | None:
        """None: the delay system has no fields in the slabs, hence no energy balance."""
        return None

    def _stick_limit(self, time: float) -> float:
        """Largest z of a stick at a `time` (transits): v is below V, in a hold below V before it."""
        drive = self.scene.drive
        paces = [drive.initial, *(v for t, v in zip(drive.times, drive.velocities, strict=True) if t <= time and v > 0.0)]
        return unknown_of(self.scene.law, _SLOW * paces[-1])

    def _first_guess(self, impedance: float, incoming: Array, psi: float) -> Interface:
        """psi and z at the nodes of a step with constant psi under the stress `incoming` (s,)."""
        law = self.scene.law
        guess, solved = first_guess(self._shape, law, impedance, incoming, psi, unknown_of(law, self.scene.velocity))
        self.failures += not solved
        return guess

    def _unresolved(self, steps: float, verdict: int) -> NumericsError:
        """Error for a step with this `verdict` even with `steps` per transit."""
        if verdict == TOO_STEEP:
            return self._left_too_fast(steps)
        time, psi = self._memory.now[[TIME, PSI]]
        rest = said_of_rest(self.scene.law, self._nodal.incoming, float(psi))
        return NumericsError(
            f"delay: the step at t = {time:.6g} transits cannot be resolved with {steps:.0f} steps per transit{rest} "
            f"(psi = {psi:.6g}, scene {self.scene.name!r}, digest {self.scene.digest})"
        )

    def _left_too_fast(self, steps: float) -> NumericsError:
        """Error for a motion that is unstable on a time scale shorter than the steps resolve."""
        time, psi = self._memory.now[[TIME, PSI]]
        _, v_z, _, friction_z, friction_psi, _, g_z, g_psi = respond(self.scene.law, float(self._memory.guess.z[0]), float(psi))
        # the real root of the characteristic equation without echoes: the arriving waves are given
        growth = self.scene.transit * (g_psi - g_z * friction_psi / (friction_z + self.scene.impedance * v_z))
        return NumericsError(
            f"delay: at t = {time:.6g} transits (psi = {psi:.6g}) the motion is unstable: disturbances grow at "
            f"{growth:.4g} per transit, by e^{growth / steps:.3g} in one of {steps:.0f} steps per transit, the largest number; "
            f"a step can follow at most e^{self._limits.growth:.3g}. Longer steps would damp this growth and follow a motion "
            f"that cannot last. Use thinner slabs, or fd with {math.ceil(growth)} cells or more "
            f"(scene {self.scene.name!r}, digest {self.scene.digest})"
        )


def dense_resolution(tolerance: float, stages: int) -> float:
    """Limit of the highest Legendre coefficient of z in a step whose polynomial has error `tolerance` (the first neglected
    coefficient is smaller by the decay from one coefficient to the next)."""
    return float(max(tolerance ** (stages / (stages + 2.0)), 1e-9))


def next_count(steps: int) -> int:
    """The next of 3, 4, 6, 8, 12, 16, ... (each larger by a factor of 4/3 or 3/2)."""
    power = 1 << max(1, steps.bit_length() - 1)
    return next(n for n in (power, 3 * power // 2, 2 * power, 3 * power) if n > steps)
