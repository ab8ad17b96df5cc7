"""The compiled march of the delay system: collocation steps for any lines that carry the waves.

With one slab's incoming characteristic S = mu + eps v/2 (MODEL.md section 3), the equations of alike plain slabs are, on the t~
clock,

    F(z, psi) + (eps/2) v(z) = S,     psi' = r G(z, psi) + nudge(t),     S(t + 1) = S(t) - eps v(t) + eps V(t + 1/2),

which is (29, 35) with S = mu_ss + eps V/2 - 2 eps g(t - 1). Their steps divide the transit, so that delayed values lie on the
same collocation nodes and nothing is interpolated. The functions of lines that the march calls are defined here for these,
`Alike`, and in `network_kernel` for all others.
"""

from typing import Any, NamedTuple

import numpy as np

from slipwave.compiled import njit
from slipwave.compiled.dispatch import by_class
from slipwave.friction import law_of_step, to_own, to_step
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene.drive import velocity_at
from slipwave.step.collocation import EQUAL, Nodes
from slipwave.step.impedance import Diagonal
from slipwave.step.newton import emit, solve
from slipwave.step.nodal import (
    DONE,
    ELASTIC,
    NOT_SMOOTH,
    PSI,
    TIME,
    Interface,
    Limits,
    Nodal,
    Physics,
    begin_step,
    hold,
    judge_step,
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
