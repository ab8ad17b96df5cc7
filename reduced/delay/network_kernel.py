"""The lines of a network in the march (`march`): delayed waves are read from past steps.

Because the step's length is constant, a delay is the same whole number of steps and fraction for every step. The waves that
arrive in a step were emitted in two past ones and follow by weight matrices computed once; if all delays are whole numbers of
steps, in one, at its nodes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reduced.delay.march import leave, receive, roughness
from slipwave.compiled import njit
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes

OUTWARD, INWARD = 0, 1
LOAD, VELOCITY = 0, 1  # columns of `NetworkLines.tops`
Integers = NDArray[np.int64]


class Network(NamedTuple):
    """Lines in compiled form (see `Lines`). Per layer: `impedance` e; `back` (layers, n), the number of steps since the arriving
    wave was emitted, and the `weights` (layers, n, s, s) of these steps, or (layers, s, 1, s) if each node reads from a step of
    its own; `whole` (layers,), whether it was emitted at the nodes of the first alone. Per slab: `first`, `last` and its top:
    `spring`, `compliance` (s, s) = (m/h A^-1 + Z_g + e + h K A)^-1, `inertia` (s, s) = m/h A^-1 and `remembers` = has a spring or
    a mass (`tops_for`). `base` = mu_ss + Z V_0; `weight` of each slab."""

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


class Passage(NamedTuple):
    """Scratch of a step: the waves that `arrived` and that are `launched` (layers, 2, s); `drive` (s,), change of the velocity
    that drives each face; rows (2, s) of an `outer` face; the interface's `stress` (s,), as a deviation; `tops` of `NetworkLines`
    after the step."""

    arrived: Array
    launched: Array
    drive: Array
    outer: Array
    stress: Array
    tops: Array


class NetworkLines(NamedTuple):
    """A `network`, its `impedance` at the interface, and its memory. `waves` (layers, 2, ring, s): ring of the deviations
    launched outwards and inwards in past steps; `tops` (slabs, 2): spring stress and velocity of each outer face; `cursor` (1,):
    ring index of the next step."""

    impedance: float
    network: Network
    waves: Array
    tops: Array
    cursor: Integers
    passage: Passage


def passage_of(network: Network, stages: int) -> Passage:
    """The scratch of steps of `stages` nodes in `network`."""
    waves = (network.impedance.size, 2, stages)
    return Passage(*(np.zeros(shape) for shape in (waves, waves, stages, (2, stages), stages, (network.first.size, 2))))


def lines_with(network: Network, waves: Array, tops: Array, cursor: int = 0) -> NetworkLines:
    """The lines of `network` with `waves` and `tops` as memory."""
    return NetworkLines(
        network.interface_impedance, network, waves, tops, np.array([cursor]), passage_of(network, waves.shape[-1])
    )


@njit
def _read(nodes: Nodes, network: Network, waves: Array, cursor: int, arrived: Array) -> None:
    """arrived <- nodal values of the waves launched one travel time before, at the ends of their layers."""
    s, ring, weights = len(nodes), waves.shape[2], network.weights
    by_node = weights.shape[2] == 1
    for layer in range(waves.shape[0]):
        whole = network.whole[layer]
        for i in range(1 if whole else weights.shape[1]):
            row = cursor - network.back[layer, i]
            row += ring if row < 0 else 0
            for j in range(i if by_node else 0, i + 1 if by_node else s):
                outward = arrived[layer, OUTWARD, j] if i and not by_node else 0.0
                inward = arrived[layer, INWARD, j] if i and not by_node else 0.0
                if whole:
                    outward, inward = waves[layer, OUTWARD, row, j], waves[layer, INWARD, row, j]
                else:
                    m = 0 if by_node else j
                    for k in range(s):
                        outward += weights[layer, i, m, k] * waves[layer, OUTWARD, row, k]
                        inward += weights[layer, i, m, k] * waves[layer, INWARD, row, k]
                arrived[layer, OUTWARD, j], arrived[layer, INWARD, j] = outward, inward


@njit
def _reflect_top(nodes: Nodes, lines: NetworkLines, slab: int, length: float, integral: Array) -> None:
    """Wave launched inwards by a slab's outer face, and the face's load and velocity at the step's end.

    With u = dV - w at the nodes, collocation of `transmission_lines` is

        (m/h A^-1 + Z_g + e + h K A) u = P + e dV - y_0 + m/h A^-1 (dV - w_0),     y = y_0 + h K A u;

    solved for u, so that the load of a stiff spring loses no digits."""
    s, (_, network, _, tops, _, passage) = len(nodes), lines
    layer = network.last[slab]
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
            load += length * network.spring[slab] * integral[k, s - 1] * work[1, k]
        passage.tops[slab, LOAD], passage.tops[slab, VELOCITY] = load, drive[s - 1] - work[1, s - 1]
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
def gather(nodes: Nodes, lines: NetworkLines, length: float, integral: Array, incoming: Array) -> None:
    """Waves that arrive and that leave joints and outer faces in a step; `passage.stress` <- the stress that they bring to the
    interface, and incoming += this."""
    network, passage = lines.network, lines.passage
    impedance, arrived, launched = network.impedance, passage.arrived, passage.launched
    _read(nodes, network, lines.waves, lines.cursor[0], arrived)
    passage.stress[:] = 0.0
    for slab in range(network.first.size):
        first, last = network.first[slab], network.last[slab]
        passage.tops[slab, LOAD], passage.tops[slab, VELOCITY] = lines.tops[slab, LOAD], lines.tops[slab, VELOCITY]
        if network.compliance[slab, 0, 0] == 0.0:  # rigid
            for j in range(len(nodes)):
                launched[last, INWARD, j] = arrived[last, OUTWARD, j] + 2.0 * impedance[last] * passage.drive[j]
        else:
            _reflect_top(nodes, lines, slab, length, integral)
        for layer in range(last - 1, first - 1, -1):
            scatter(nodes, impedance[layer], impedance[layer + 1], layer, arrived, launched)
        share = network.weight * network.interface_impedance / impedance[first]
        for j in range(len(nodes)):
            passage.stress[j] += share * arrived[first, INWARD, j]
    for j in range(len(nodes)):
        incoming[j] += passage.stress[j]


@njit
def launch(nodes: Nodes, lines: NetworkLines) -> None:
    """Store the waves launched in a step, with those that leave the interface at its stress, and advance to the step's end."""
    waves, (arrived, launched, _, _, stress, tops) = lines.waves, lines.passage
    cursor, first = lines.cursor[0], lines.network.first
    for slab in range(first.size):
        lines.tops[slab, LOAD], lines.tops[slab, VELOCITY] = tops[slab, LOAD], tops[slab, VELOCITY]
        for j in range(len(nodes)):
            launched[first[slab], OUTWARD, j] = 2.0 * stress[j] - arrived[first[slab], INWARD, j]
    for layer in range(waves.shape[0]):
        for j in range(len(nodes)):
            waves[layer, OUTWARD, cursor, j] = launched[layer, OUTWARD, j]
            waves[layer, INWARD, cursor, j] = launched[layer, INWARD, j]
    lines.cursor[0] = cursor + 1 if cursor + 1 < waves.shape[2] else 0


@receive.register(NetworkLines)
def _arrive_through_network(lines, nodes, physics, n, length, nodal):  # type: ignore[no-untyped-def]
    for j in range(len(nodes)):
        lines.passage.drive[j] = 0.5 * (nodal.drive[j] - physics.forcing.velocity)
        nodal.incoming[j] = lines.network.base
    gather(nodes, lines, length, physics.rule.integral, nodal.incoming)


@roughness.register(NetworkLines)
def _roughness_of_faces(lines, nodes, tail, nodal):  # type: ignore[no-untyped-def]
    """Highest Legendre coefficient of the waves that springs and masses launch in a step, as a change of z where they arrive.
    Waves launched with too few nodes stay inaccurate, however short the steps in which they arrive."""
    network, passage, worst, inverse = lines.network, lines.passage, 0.0, 0.0
    for j in range(len(nodes)):
        inverse = max(inverse, nodal.inverse[j])
    for slab in range(network.first.size):
        if network.remembers[slab]:
            coefficient, last = 0.0, network.last[slab]
            for j in range(len(nodes)):
                coefficient += tail[j] * passage.launched[last, INWARD, j]
            worst = max(worst, abs(coefficient) * inverse * network.interface_impedance / network.impedance[last])
    return worst


@leave.register(NetworkLines)
def _leave_into_network(lines, nodes, physics, n, start, length, nodal):  # type: ignore[no-untyped-def]
    for j in range(len(nodes)):
        # not from the stress itself, whose rounding, of some 1e-16 a step, would add up in the waves
        lines.passage.stress[j] -= lines.impedance * (nodal.v[j] - physics.forcing.velocity)
    launch(nodes, lines)
