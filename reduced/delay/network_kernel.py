"""The compiled march of `network`: collocation steps of equal length; delayed waves are read from past steps.

Because the step's length is constant, a delay is the same whole number of steps and fraction for every step. What arrives in a
step left in two past ones, with matrices of weights that are computed once. If all delays are whole numbers of steps, it left in
one, at its nodes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.delay.alike_kernel import ELASTIC, PSI, TIME
from slipwave.compiled import allocating, inlined, njit, overwrite
from slipwave.friction import Law
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene.drive import Constant, Ramps, velocity_at
from slipwave.scene.forcing import Forcing
from slipwave.step.collocation import Nodes
from slipwave.step.guess import DONE, force, judge_step, predict
from slipwave.step.impedance import Diagonal
from slipwave.step.newton import solve
from slipwave.step.record import emit
from slipwave.step.rows import DRIVE, STATE, UNKNOWN, WORK_ROWS

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


@njit
def arrive(
    nodes: Nodes, back: Integers, weights: Array, whole: NDArray[np.bool_], waves: Array, cursor: int, arrived: Array
) -> None:
    """Nodal values of the waves that arrive at the ends of their layers: they were launched one travel time before."""
    s, ring = len(nodes), waves.shape[2]
    for layer in range(waves.shape[0]):
        for i in range(1 if whole[layer] else back.shape[1]):
            row = cursor - back[layer, i]
            row += ring if row < 0 else 0
            for j in range(s):
                outward = arrived[layer, OUTWARD, j] if i else 0.0
                inward = arrived[layer, INWARD, j] if i else 0.0
                if whole[layer]:
                    outward, inward = waves[layer, OUTWARD, row, j], waves[layer, INWARD, row, j]
                else:
                    for k in range(s):
                        outward += weights[layer, i, j, k] * waves[layer, OUTWARD, row, k]
                        inward += weights[layer, i, j, k] * waves[layer, INWARD, row, k]
                arrived[layer, OUTWARD, j], arrived[layer, INWARD, j] = outward, inward


@njit
def reflect_top(
    nodes: Nodes,
    slab: int,
    layer: int,
    impedance: float,
    remembers: bool,
    stiffness: float,
    compliance: Array,
    inertia: Array,
    integral: Array,
    drive: Array,
    arrived: Array,
    launched: Array,
    tops: Array,
    work: Array,
) -> None:
    """Wave launched inwards by a slab's outer face, and the face's load and velocity at the step's end.

    With u = dV - w at the nodes, collocation of `transmission_lines` is

        (m/h A^-1 + Z_g + e + h K A) u = P + e dV - y_0 + m/h A^-1 (dV - w_0),     y = y_0 + h K A u;

    solved for u, so that the load of a stiff spring loses no digits. `impedance` is e, `stiffness` is h K."""
    s = len(nodes)
    load, velocity = tops[slab, LOAD], tops[slab, VELOCITY]
    for j in range(s):
        work[0, j] = arrived[layer, OUTWARD, j] + impedance * drive[j] - load
    if remembers:
        for j in range(s):
            for k in range(s):
                work[0, j] += inertia[slab, j, k] * (drive[k] - velocity)
        for j in range(s):
            total = 0.0
            for k in range(s):
                total += compliance[slab, j, k] * work[0, k]
            work[1, j] = total
        for k in range(s):
            tops[slab, LOAD] += stiffness * integral[k, s - 1] * work[1, k]
        tops[slab, VELOCITY] = drive[s - 1] - work[1, s - 1]
    else:
        for j in range(s):
            work[1, j] = compliance[slab, j, j] * work[0, j]
    for j in range(s):
        launched[layer, INWARD, j] = arrived[layer, OUTWARD, j] + 2.0 * impedance * (drive[j] - work[1, j])


@njit
def scatter(nodes: Nodes, inner: float, outer: float, layer: int, arrived: Array, launched: Array) -> None:
    """Waves launched from the joint between `layer` and the next one outwards, of impedances `inner` and `outer`."""
    for j in range(len(nodes)):
        velocity = (arrived[layer + 1, INWARD, j] - arrived[layer, OUTWARD, j]) / (inner + outer)
        launched[layer, INWARD, j] = arrived[layer, OUTWARD, j] + 2.0 * inner * velocity
        launched[layer + 1, OUTWARD, j] = arrived[layer + 1, INWARD, j] - 2.0 * outer * velocity


@inlined
def gather(
    nodes: Nodes,
    impedance: Array,
    back: Integers,
    weights: Array,
    whole: NDArray[np.bool_],
    firsts: Integers,
    lasts: Integers,
    springs: Array,
    remembers: NDArray[np.bool_],
    compliance: Array,
    inertia: Array,
    scale: float,
    cursor: int,
    length: float,
    integral: Array,
    drive: Array,
    waves: Array,
    tops: Array,
    arrived: Array,
    launched: Array,
    outer: Array,
    incoming: Array,
) -> None:
    """Waves that arrive and that leave joints and outer faces in a step; incoming[0] += the stress that they bring to the
    interface. Arrays of a `Network` are taken one by one, since each use of a tuple's array in a loop costs reference counting;
    `scale` is its weight times the interface's impedance."""
    arrive(nodes, back, weights, whole, waves, cursor, arrived)
    for slab in range(firsts.size):
        first, last = firsts[slab], lasts[slab]
        if compliance[slab, 0, 0] == 0.0:  # rigid
            for j in range(len(nodes)):
                launched[last, INWARD, j] = arrived[last, OUTWARD, j] + 2.0 * impedance[last] * drive[j]
        else:
            face = (impedance[last], remembers[slab], length * springs[slab])
            reflect_top(nodes, slab, last, *face, compliance, inertia, integral, drive, arrived, launched, tops, outer)
        for layer in range(last - 1, first - 1, -1):
            scatter(nodes, impedance[layer], impedance[layer + 1], layer, arrived, launched)
        share = scale / impedance[first]
        for j in range(len(nodes)):
            incoming[0, j] += share * arrived[first, INWARD, j]


@inlined
def launch(nodes: Nodes, firsts: Integers, cursor: int, stress: Array, arrived: Array, launched: Array, waves: Array) -> None:
    """Store the waves launched in a step, with those that leave the interface, above the layers `firsts`, at its `stress`
    (deviation)."""
    for slab in range(firsts.size):
        first = firsts[slab]
        for j in range(len(nodes)):
            launched[first, OUTWARD, j] = 2.0 * stress[j] - arrived[first, INWARD, j]
    for layer in range(waves.shape[0]):
        for j in range(len(nodes)):
            waves[layer, OUTWARD, cursor, j] = launched[layer, OUTWARD, j]
            waves[layer, INWARD, cursor, j] = launched[layer, INWARD, j]


@allocating
def march_network(
    nodes: Nodes,
    law: Law,
    network: Network,
    forcing: Forcing,
    velocity: Constant | Ramps,
    integral: Array,
    predict_rate: Array,
    predict_state: Array,
    tail: Array,
    memory: NetworkMemory,
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
    s = len(nodes)
    waves, tops, guess, now = memory.waves, memory.tops, memory.guess, memory.now
    layers, ring = waves.shape[0], waves.shape[2]
    arrived, launched, outer = np.empty((layers, 2, s)), np.empty((layers, 2, s)), np.empty((2, s))
    work, system, incoming, drive = np.zeros((WORK_ROWS, s)), np.empty((s, s)), np.empty((1, s)), np.zeros(s)
    stress = np.empty(s)
    saved_guess, saved_tops = np.empty_like(guess), np.empty_like(tops)
    impedance, h = Diagonal(network.interface_impedance), length * forcing.transit
    lines, back, weights, whole = network.impedance, network.back, network.weights, network.whole
    firsts, lasts, springs, remembers = network.first, network.last, network.spring, network.remembers
    compliance, inertia, scale = network.compliance, network.inertia, network.weight * network.interface_impedance
    iterations, place, base = 0, memory.cursor, network.base
    for n in range(count):
        cursor, start, left = place[0], origin + (done + n) * length, now[PSI]
        for j in range(s):
            saved_guess[STATE, j], saved_guess[UNKNOWN, j] = guess[STATE, j], guess[UNKNOWN, j]
        for slab in range(tops.shape[0]):
            saved_tops[slab, LOAD], saved_tops[slab, VELOCITY] = tops[slab, LOAD], tops[slab, VELOCITY]
        for j in range(s):
            work[DRIVE, j] = velocity_at(velocity, start + nodes[j] * length, start + 0.5 * length)
            drive[j] = 0.5 * (work[DRIVE, j] - forcing.velocity)
        for j in range(s):
            incoming[0, j] = base
        gather(
            nodes,
            lines,
            back,
            weights,
            whole,
            firsts,
            lasts,
            springs,
            remembers,
            compliance,
            inertia,
            scale,
            cursor,
            length,
            integral,
            drive,
            waves,
            tops,
            arrived,
            launched,
            outer,
            incoming,
        )
        if forcing.nudge != 0.0:
            force(nodes, forcing.nudge, start, length, integral, work)
        used = solve(nodes, law, impedance, h, left, incoming, 0, integral, newton_tolerance, guess, work, system)
        iterations += used
        verdict = judge_step(nodes, tail, guess, work, used, resolution, steepest)
        if verdict != DONE:
            overwrite(guess, saved_guess)
            overwrite(tops, saved_tops)
            return n, iterations, verdict
        now[ELASTIC] = emit(
            nodes, forcing.stiffness, impedance, start, length, integral, incoming, 0, guess, work, now[ELASTIC], pieces, n
        )
        for j in range(s):
            stress[j] = pieces.mu[n, j] - forcing.steady_stress
        launch(nodes, firsts, cursor, stress, arrived, launched, waves)
        now[PSI], now[TIME] = guess[STATE, s - 1], origin + (done + n + 1) * length
        place[0] = cursor + 1 if cursor + 1 < ring else 0
        predict(nodes, predict_rate, predict_state, left, guess, work)
    return count, iterations, DONE
