"""The compiled march of `network`: collocation steps of equal length; delayed waves are read from past steps.

Because the step's length is constant, a delay is the same whole number of steps and fraction for every step. What arrives in a
step left in two past ones, with matrices of weights that are computed once. If all delays are whole numbers of steps, it left in
one, at its nodes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.delay.alike_kernel import ELASTIC, PSI, TIME
from slipwave.compiled import njit, overwrite
from slipwave.friction import Law
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene.drive import Constant, Ramps, velocity_at
from slipwave.scene.forcing import Forcing
from slipwave.step.collocation import EQUAL, Nodes, Rule
from slipwave.step.guess import DONE, NOT_SMOOTH, force, judge_step, predict
from slipwave.step.impedance import Diagonal
from slipwave.step.newton import solve
from slipwave.step.record import emit
from slipwave.step.rows import DRIVE, INVERSE, STATE, Scratch

OUTWARD, INWARD = 0, 1
LOAD, VELOCITY = 0, 1  # columns of `NetworkMemory.tops`
Integers = NDArray[np.int64]


class Network(NamedTuple):
    """Lines in compiled form (see `Lines`). Per layer: `impedance` e; `back` (layers, n), how many steps back those lie in which
    waves left, and `weights` (layers, n, s, s) there; `whole` (layers,), whether they left in the first, at its nodes. Per slab:
    `first`, `last` and its top: `spring`, `compliance`
    (s, s) = (m/h A^-1 + Z_g + e + h K A)^-1, `inertia` (s, s) = m/h A^-1 and `remembers` = has a spring or a mass (`tops_for`).
    `base` = mu_ss + Z V_0; `weight` of each slab."""

    impedance: Array
    back: Integers
    weights: Array
    whole: NDArray[np.bool_]
    first: Integers
    last: Integers
    spring: Array
    compliance: Array
    inertia: Array
    remembers: NDArray[np.bool_]
    interface_impedance: float
    base: float
    weight: float


class NetworkMemory(NamedTuple):
    """`waves` (layers, 2, ring, s): ring of the deviations launched outwards and inwards in past steps; `tops` (slabs, 2): spring
    stress and velocity of each outer face; `guess` (2, s); `now`: time, psi, y; `cursor` (1,): ring index of the next step."""

    waves: Array
    tops: Array
    guess: Array
    now: Array
    cursor: Integers


class Passage(NamedTuple):
    """Scratch of a step: the waves that `arrived` and that are `launched` (layers, 2, s); `drive` (s,), change of the velocity
    that drives each face; rows (2, s) of an `outer` face; the interface's `stress` (s,); `guess` and `tops` of `NetworkMemory`
    before the step."""

    arrived: Array
    launched: Array
    drive: Array
    outer: Array
    stress: Array
    guess: Array
    tops: Array


def passage_of(network: Network, stages: int) -> Passage:
    """The scratch of steps of `stages` nodes in `network`."""
    waves = (network.impedance.size, 2, stages)
    shapes = (waves, waves, stages, (2, stages), stages, (2, stages), (network.first.size, 2))
    return Passage(*(np.zeros(shape) for shape in shapes))


@njit
def arrive(nodes: Nodes, network: Network, waves: Array, cursor: int, arrived: Array) -> None:
    """Nodal values of the waves that arrive at the ends of their layers: they were launched one travel time before."""
    s, ring, weights = len(nodes), waves.shape[2], network.weights
    for layer in range(waves.shape[0]):
        whole = network.whole[layer]
        for i in range(1 if whole else weights.shape[1]):
            row = cursor - network.back[layer, i]
            row += ring if row < 0 else 0
            for j in range(s):
                outward = arrived[layer, OUTWARD, j] if i else 0.0
                inward = arrived[layer, INWARD, j] if i else 0.0
                if whole:
                    outward, inward = waves[layer, OUTWARD, row, j], waves[layer, INWARD, row, j]
                else:
                    for k in range(s):
                        outward += weights[layer, i, j, k] * waves[layer, OUTWARD, row, k]
                        inward += weights[layer, i, j, k] * waves[layer, INWARD, row, k]
                arrived[layer, OUTWARD, j], arrived[layer, INWARD, j] = outward, inward


@njit
def reflect_top(nodes: Nodes, network: Network, slab: int, length: float, integral: Array, passage: Passage, tops: Array) -> None:
    """Wave launched inwards by a slab's outer face, and the face's load and velocity at the step's end.

    With u = dV - w at the nodes, collocation of `transmission_lines` is

        (m/h A^-1 + Z_g + e + h K A) u = P + e dV - y_0 + m/h A^-1 (dV - w_0),     y = y_0 + h K A u;

    solved for u, so that the load of a stiff spring loses no digits."""
    s, layer = len(nodes), network.last[slab]
    impedance, compliance, inertia = network.impedance[layer], network.compliance, network.inertia
    arrived, drive, work = passage.arrived, passage.drive, passage.outer
    load, velocity = tops[slab, LOAD], tops[slab, VELOCITY]
    for j in range(s):
        work[0, j] = arrived[layer, OUTWARD, j] + impedance * drive[j] - load
    if network.remembers[slab]:
        for j in range(s):
            for k in range(s):
                work[0, j] += inertia[slab, j, k] * (drive[k] - velocity)
        for j in range(s):
            total = 0.0
            for k in range(s):
                total += compliance[slab, j, k] * work[0, k]
            work[1, j] = total
        for k in range(s):
            tops[slab, LOAD] += length * network.spring[slab] * integral[k, s - 1] * work[1, k]
        tops[slab, VELOCITY] = drive[s - 1] - work[1, s - 1]
    else:
        for j in range(s):
            work[1, j] = compliance[slab, j, j] * work[0, j]
    for j in range(s):
        passage.launched[layer, INWARD, j] = arrived[layer, OUTWARD, j] + 2.0 * impedance * (drive[j] - work[1, j])


@njit
def scatter(nodes: Nodes, inner: float, outer: float, layer: int, arrived: Array, launched: Array) -> None:
    """Waves launched from the joint between `layer` and the next one outwards, of impedances `inner` and `outer`."""
    for j in range(len(nodes)):
        velocity = (arrived[layer + 1, INWARD, j] - arrived[layer, OUTWARD, j]) / (inner + outer)
        launched[layer, INWARD, j] = arrived[layer, OUTWARD, j] + 2.0 * inner * velocity
        launched[layer + 1, OUTWARD, j] = arrived[layer + 1, INWARD, j] - 2.0 * outer * velocity


@njit
def gather(
    nodes: Nodes,
    network: Network,
    cursor: int,
    length: float,
    integral: Array,
    waves: Array,
    tops: Array,
    passage: Passage,
    incoming: Array,
) -> None:
    """Waves that arrive and that leave joints and outer faces in a step; incoming[0] += the stress that they bring to the
    interface."""
    impedance, arrived, launched = network.impedance, passage.arrived, passage.launched
    arrive(nodes, network, waves, cursor, arrived)
    for slab in range(network.first.size):
        first, last = network.first[slab], network.last[slab]
        if network.compliance[slab, 0, 0] == 0.0:  # rigid
            for j in range(len(nodes)):
                launched[last, INWARD, j] = arrived[last, OUTWARD, j] + 2.0 * impedance[last] * passage.drive[j]
        else:
            reflect_top(nodes, network, slab, length, integral, passage, tops)
        for layer in range(last - 1, first - 1, -1):
            scatter(nodes, impedance[layer], impedance[layer + 1], layer, arrived, launched)
        share = network.weight * network.interface_impedance / impedance[first]
        for j in range(len(nodes)):
            incoming[0, j] += share * arrived[first, INWARD, j]


@njit
def launch(nodes: Nodes, network: Network, cursor: int, stress: Array, passage: Passage, waves: Array) -> None:
    """Store the waves launched in a step, with those that leave the interface at its `stress` (deviation)."""
    arrived, launched = passage.arrived, passage.launched
    for slab in range(network.first.size):
        first = network.first[slab]
        for j in range(len(nodes)):
            launched[first, OUTWARD, j] = 2.0 * stress[j] - arrived[first, INWARD, j]
    for layer in range(waves.shape[0]):
        for j in range(len(nodes)):
            waves[layer, OUTWARD, cursor, j] = launched[layer, OUTWARD, j]
            waves[layer, INWARD, cursor, j] = launched[layer, INWARD, j]


@njit
def roughness_from_faces(nodes: Nodes, tail: Array, network: Network, passage: Passage, work: Array) -> float:
    """Highest Legendre coefficient of the waves that springs and masses launch in a step, as a change of z where they arrive. If
    launched with too few nodes, they stay wrong, however short the steps in which they arrive."""
    worst, inverse = 0.0, 0.0
    for j in range(len(nodes)):
        inverse = max(inverse, work[INVERSE, j])
    for slab in range(network.first.size):
        if network.remembers[slab]:
            coefficient, last = 0.0, network.last[slab]
            for j in range(len(nodes)):
                coefficient += tail[j] * passage.launched[last, INWARD, j]
            worst = max(worst, abs(coefficient) * inverse * network.interface_impedance / network.impedance[last])
    return worst


@njit
def march_network(
    nodes: Nodes,
    law: Law,
    network: Network,
    forcing: Forcing,
    velocity: Constant | Ramps,
    rule: Rule,
    memory: NetworkMemory,
    passage: Passage,
    scratch: Scratch,
    origin: float,
    done: int,
    length: float,
    count: int,
    newton_tolerance: float,
    resolution: float,
    steepest: float,
    pieces: Pieces,
) -> tuple[int, int, int]:
    """March `count` steps of `length` transits. Step n begins at `origin` + (`done` + n) `length`, because a sum of steps would
    accumulate rounding. Returns (steps, Newton iterations, verdict) as `march_delay` does, but a rejected step leaves the memory
    at that step's start."""
    s, integral = len(nodes), rule.integral
    waves, tops, guess, now, place = memory.waves, memory.tops, memory.guess, memory.now, memory.cursor
    work, incoming, drive, stress = scratch.work, scratch.incoming, passage.drive, passage.stress
    impedance, h = Diagonal(network.interface_impedance), length * forcing.transit
    iterations = 0
    for n in range(count):
        cursor, start, left = place[0], origin + (done + n) * length, now[PSI]
        overwrite(passage.guess, guess)
        overwrite(passage.tops, tops)
        for j in range(s):
            work[DRIVE, j] = velocity_at(velocity, start + nodes[j] * length, start + 0.5 * length)
            drive[j] = 0.5 * (work[DRIVE, j] - forcing.velocity)
            incoming[0, j] = network.base
        gather(nodes, network, cursor, length, integral, waves, tops, passage, incoming)
        if forcing.nudge != 0.0:
            force(nodes, forcing.nudge, start, length, integral, work)
        used = solve(nodes, law, impedance, h, left, incoming, 0, integral, newton_tolerance, guess, work, scratch.system)
        iterations += used
        verdict = judge_step(nodes, rule.tail, guess, work, used, resolution, steepest)
        if verdict == DONE and not roughness_from_faces(nodes, rule.tail, network, passage, work) <= resolution:
            verdict = NOT_SMOOTH
        if verdict != DONE:
            overwrite(guess, passage.guess)
            overwrite(tops, passage.tops)
            return n, iterations, verdict
        now[ELASTIC] = emit(
            nodes, forcing.stiffness, impedance, start, length, integral, incoming, 0, guess, work, now[ELASTIC], pieces, n
        )
        for j in range(s):
            stress[j] = pieces.mu[n, j] - forcing.steady_stress
        launch(nodes, network, cursor, stress, passage, waves)
        now[PSI], now[TIME] = guess[STATE, s - 1], origin + (done + n + 1) * length
        place[0] = cursor + 1 if cursor + 1 < waves.shape[2] else 0
        overwrite(scratch.guess, guess)
        predict(nodes, rule, EQUAL, left, scratch.guess, guess)
    return count, iterations, DONE
