"""The compiled march of the delay system: collocation steps for any lines that carry the waves.

With one slab's incoming characteristic S = mu + eps v/2 (MODEL.md section 3), the equations of alike plain slabs are, on the t~
clock,

    F(z, psi) + (eps/2) v(z) = S,     psi' = r G(z, psi) + nudge(t),     S(t + 1) = S(t) - eps v(t) + eps V(t + 1/2),

which is (29, 35) with S = mu_ss + eps V/2 - 2 eps g(t - 1). Their steps divide the transit, so that delayed values lie on the
same collocation nodes and nothing is interpolated. The functions of lines that the march calls are defined here for these,
`Alike`, and in `network_kernel` for all others.

`DelayMarch` is the common part of all solvers that march it: present state, counters, and errors for a step that cannot be
resolved.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from slipwave.compiled import njit
from slipwave.compiled.dispatch import by_class
from slipwave.errors import NumericsError
from slipwave.friction import allows_rest, law_of_step, respond, said_of_rest, to_own, to_step, unknown_of
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.scene.drive import velocity_at
from slipwave.solve import Energy
from slipwave.step.collocation import EQUAL, Nodes, growth_limit, rule_of
from slipwave.step.impedance import Diagonal
from slipwave.step.newton import emit, first_guess, solve
from slipwave.step.nodal import (
    DONE,
    ELASTIC,
    NOT_SMOOTH,
    PSI,
    TIME,
    TOO_STEEP,
    Interface,
    Limits,
    Nodal,
    Physics,
    begin_step,
    hold,
    judge_step,
    nodal_of,
    predict,
)


class DelayMemory(NamedTuple):
    """The present: predicted nodal psi and z of the next step, `guess`, and `now` (4,): time (transits), psi, y, and what
    rounding lost of y: a sample in a machine takes 1e8 steps, and in each y changes by a few roundings (compensated sum)."""

    guess: Interface
    now: Array


LOST = 3


def present(time: float, psi: float, y: float) -> Array:
    """`DelayMemory.now` without lost parts."""
    return np.array([time, psi, y, 0.0])


class Clock(NamedTuple):
    """Steps that `begin` (n + 1,), with the end of the last, after `origin`, and their `length` (n,), in transits: a sum of steps
    would accumulate rounding. All are repeated `times`; each repetition begins where the one before ended."""

    origin: float
    begin: Array
    length: Array
    times: int = 1


def clock_of(origin: float, done: int, count: int, length: float) -> Clock:
    """`count` equal steps, after `done` of them."""
    return Clock(origin, np.arange(done, done + count + 1, dtype=np.float64) * length, np.full(count, length))


class Alike(NamedTuple):
    """Waves of alike plain slabs of `impedance` eps/2: S at the nodes of the steps of the next transit, `incoming` (steps, s);
    within a transit, S of the solved steps `before` (steps, s), and the memory at the transit's `start`."""

    impedance: float
    incoming: Array
    before: Array
    start: DelayMemory


def alike_lines(impedance: float, incoming: Array) -> Alike:
    """The waves at the start of a transit."""
    stages = incoming.shape[1]
    return Alike(impedance, incoming, np.empty_like(incoming), DelayMemory(Interface(*np.empty((2, stages))), np.empty(4)))


@by_class(inline=True)
def receive(lines: Any, nodes: Nodes, physics: Physics, n: int, length: float, nodal: Nodal) -> None:
    """nodal.incoming <- S of step `n` of this `length`. The memory does not change."""
    for j in range(len(nodes)):
        nodal.incoming[j] = lines.incoming[n, j]


@by_class(inline=True)
def roughness(lines: Any, nodes: Nodes, tail: Array, nodal: Nodal) -> float:
    """Highest Legendre coefficient of the waves launched at the far ends of the lines in the step."""
    return 0.0


@by_class(inline=True)
def leave(lines: Any, nodes: Nodes, physics: Physics, n: int, start: float, length: float, nodal: Nodal) -> None:
    """Store the waves of the solved step `n`."""
    drive, middle = physics.drive, start + 0.5 * length + 0.5
    for j in range(len(nodes)):
        driven = velocity_at(drive, start + nodes[j] * length + 0.5, middle)
        lines.before[n, j] = lines.incoming[n, j]
        lines.incoming[n, j] += 2.0 * lines.impedance * (driven - nodal.v[j])


@by_class(inline=True)
def _begin_clock(lines: Any, memory: DelayMemory) -> None:
    """Called at the start of each repetition of the clock."""


@by_class(inline=True)
def _go_back(lines: Any, memory: DelayMemory, n: int) -> None:
    """Called when step `n` of the clock is rejected. The memory stays that of the step's start."""


@_begin_clock.register(Alike)
def _begin_transit(lines, memory):  # type: ignore[no-untyped-def]
    _copy(memory, lines.start)


@_go_back.register(Alike)
def _back_to_transit(lines, memory, n):  # type: ignore[no-untyped-def]
    for k in range(n):
        for j in range(lines.incoming.shape[1]):
            lines.incoming[k, j] = lines.before[k, j]
    _copy(lines.start, memory)


@njit
def _copy(memory: DelayMemory, into: DelayMemory) -> None:
    for j in range(memory.guess.z.size):
        into.guess.psi[j], into.guess.z[j] = memory.guess.psi[j], memory.guess.z[j]
    for j in range(memory.now.size):
        into.now[j] = memory.now[j]


@njit
def march_delay(
    nodes: Nodes,
    physics: Physics,
    lines: Any,
    memory: DelayMemory,
    nodal: Nodal,
    clock: Clock,
    limits: Limits,
    first: int,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March the steps of the `clock`; step i becomes piece `first` + i, or none if that is negative. Returns (steps, Newton
    iterations, verdict of `judge_step`); a rejected step leaves the memory at its start, that of `Alike` at the start of its
    transit."""
    s, (_, forcing, _, rule) = len(nodes), physics
    impedance, origin, iterations = Diagonal(lines.impedance), clock.origin, 0
    guess, now, count = memory.guess, memory.now, clock.length.size
    for k in range(clock.times * count):
        n = k % count
        if n == 0:
            origin = now[TIME] if k else clock.origin
            _begin_clock(lines, memory)
        start, length, left = origin + clock.begin[n], clock.length[n], now[PSI]
        law = law_of_step(physics.law, left)
        begin_step(nodes, physics, start, length, left, nodal)
        for j in range(s):
            nodal.psi[j], nodal.z[j] = guess.psi[j], guess.z[j]
        to_step(law, physics.law, nodal.z)
        receive(lines, nodes, physics, n, length, nodal)
        used = solve(law, nodes, impedance, length * forcing.transit, rule, limits.newton, nodal)
        iterations += used
        verdict = judge_step(nodes, rule.tail, nodal, used, limits)
        if verdict == DONE and not roughness(lines, nodes, rule.tail, nodal) <= limits.resolution:
            verdict = NOT_SMOOTH
        if verdict != DONE:
            _go_back(lines, memory, n)
            return k, iterations, verdict
        predict(nodes, rule, EQUAL, left, Interface(nodal.psi, nodal.z), guess)
        to_own(law, guess.z)
        to_own(law, nodal.z)
        if first + k >= 0:
            elastic, step = now[ELASTIC], (start, length)
            gain = now[LOST] + emit(nodes, forcing.stiffness, impedance, step, rule.integral, nodal, elastic, pieces, first + k)
            now[ELASTIC] = elastic + gain
            now[LOST] = gain - (now[ELASTIC] - elastic)
        leave(lines, nodes, physics, n, start, length, nodal)
        now[PSI], now[TIME] = nodal.psi[s - 1], origin + clock.begin[n + 1]
        if clock.length[n + 1 if n + 1 < count else 0] != length:
            hold(nodes, now[PSI], nodal.z[s - 1], guess)
    return clock.times * count, iterations, DONE


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
    bookkeeping = frozenset(
        {"counts", "levels", "origin", "guess", "waiting", "leaps", "tries", "past", "past.incoming", "arrivals"}
    )
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
        rest = said_of_rest(self.scene.law, self._nodal.incoming, float(self._memory.guess.z[0]), float(psi))
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
