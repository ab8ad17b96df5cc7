"""The compiled derivative of `march_delay` through a network in equal steps.

All changes are carried at once, each in a column, the last axis of every array: loops over columns are what the compiler
vectorises. Friction's part is `step_answer`, the slabs' part `_Exchange`: a matrix, the same for every step, computed by sending
unit waves through the march's own functions.
"""

from typing import NamedTuple

import numpy as np

from reduced.delay.network_kernel import Integers, Network, NetworkLines, Passage, gather, launch, passage_of
from slipwave.compiled import allocating, njit
from slipwave.friction import Law, respond
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.impedance import Diagonal
from slipwave.step.tangent import Motion, blank_answer, step_answer


class _Exchange(NamedTuple):
    """Linear map of the slabs over a step.

    Rows of the matrix: the waves that leave (layers, 2, s), the outer faces' state (slabs, 2) and psi at the step's end; the
    stress that waves bring to the interface (s), and psi at the start. Columns: the waves that arrive, the faces' state and psi
    at the start; the interface's stress (s), and psi at the end. The nonzero entries of row i are [starts[i], starts[i + 1]),
    with their columns, `sources`, and values, `factors`; no row is empty.

    `impedance` is that of the interface. Row i receives what was emitted `back[i]` (n,) steps before; waves with the `weights`
    (waves, n, s) of the nodes of these steps, other rows at the first."""

    impedance: float
    starts: Integers
    sources: Integers
    factors: Array
    back: Integers
    weights: Array


def exchange_of(nodes: Nodes, network: Network, length: float, integral: Array) -> _Exchange:
    """The exchange in steps of `length` (transits); `integral` is A transposed."""
    matrix = exchange_matrix(nodes, network, length, integral)
    present = matrix != 0.0
    present[:, 0] |= ~present.any(axis=1)
    rows, columns = np.nonzero(present)
    s, (layers, n) = len(nodes), network.back.shape
    back = np.ones((matrix.shape[0] - s - 1, n), dtype=np.int64)
    back[: 2 * layers * s] = np.repeat(network.back, 2 * s, axis=0)
    weights = np.ascontiguousarray(np.repeat(network.weights, 2, axis=0).swapaxes(1, 2)).reshape(-1, n, s)
    starts = np.searchsorted(rows, np.arange(matrix.shape[0] + 1))
    return _Exchange(network.interface_impedance, starts, columns, matrix[rows, columns], back, weights)


def exchange_matrix(nodes: Nodes, network: Network, length: float, integral: Array) -> Array:
    """The matrix of `_Exchange`."""
    s, layers, slabs = len(nodes), network.impedance.size, network.first.size
    near = network._replace(back=np.zeros_like(network.back), whole=np.ones(layers, dtype=np.bool_))
    faces, psi, stress = 2 * layers * s, 2 * (layers * s + slabs), 2 * (layers * s + slabs) + 1
    units = np.eye(stress + s + 1)
    waves, tops, moved = units[:, :faces].copy(), units[:, faces:psi].copy(), units[:, stress:-1].copy()
    received = np.zeros_like(moved)
    lines = (near, waves.reshape(-1, layers, 2, 1, s), tops.reshape(-1, slabs, 2), passage_of(near, s))
    send(nodes, *lines, length, integral, moved, received)
    return np.ascontiguousarray(np.column_stack([waves, tops, units[:, -1], received, units[:, psi]]).T)


def driven_matrix(nodes: Nodes, network: Network, length: float, integral: Array) -> Array:
    """Derivatives of what a step of `length` (transits) puts into the memory, rows of `_Exchange`, by the drive at its nodes."""
    s, slabs = len(nodes), network.first.size
    passage, waves, tops = passage_of(network, s), np.zeros((s, network.impedance.size, 2, 1, s)), np.zeros((s, slabs, 2))
    near, nothing = network._replace(back=np.zeros_like(network.back)), np.zeros((1, s))
    for j in range(s):
        passage.drive[:] = 0.5 * np.eye(s)[j]  # each face takes half
        send(nodes, near, waves[j : j + 1], tops[j : j + 1], passage, length, integral, nothing, nothing.copy())
    return np.ascontiguousarray(np.column_stack([waves.reshape(s, -1), tops.reshape(s, -1), np.zeros(s)]).T)


@allocating
def send(
    nodes: Nodes,
    network: Network,
    waves: Array,
    tops: Array,
    passage: Passage,
    length: float,
    integral: Array,
    stress: Array,
    incoming: Array,
) -> None:
    """Send each of n states through a step of a `network`: waves (n, layers, 2, ring, s), oldest first, tops (n, slabs, 2), in
    place, with the interface's stress (n, s); incoming (n, s) += the stress that waves bring to the interface."""
    cursor = np.zeros(1, dtype=np.int64)
    for c in range(waves.shape[0]):
        cursor[0] = 0
        lines = NetworkLines(network.interface_impedance, network, waves[c], tops[c], cursor, passage)
        gather(nodes, lines, length, integral, incoming[c])
        for j in range(len(nodes)):
            passage.stress[j] = stress[c, j]
        launch(nodes, lines)


@allocating
def march_tangent(
    nodes: Nodes,
    law: Law,
    exchange: _Exchange,
    h: float,
    integral: Array,
    motion: Motion,
    memory: Array,
    cursor: int,
    last: Array,
) -> int:
    """Carry n changes of the state along the `motion`.

    `memory` (ring, rows, n): output of past steps, in rows as in `exchange`; `cursor` is the next step. `h` is the length of a
    step on the friction clock. psi is evaluated within the last step, by the weights `last` (s + 1,) of psi at its start and
    nodes; all else at its end. Returns the ring index of the step after the last."""
    s, count, stress, impedance = len(nodes), motion.z.shape[0], memory.shape[1], exchange.impedance
    answer, matrix, at_end = blank_answer(nodes), np.empty((s + 1, s + 1)), np.zeros(s + 1)
    before, received = np.zeros((stress + s + 1, memory.shape[2])), np.zeros((s + 1, memory.shape[2]))
    at_end[s] = 1.0
    for n in range(count):
        step_answer(nodes, law, Diagonal(impedance), h, integral, motion, n, answer)
        _step_matrix(nodes, impedance, answer.matrix, last if n == count - 1 else at_end, matrix)
        _arrive_columns(nodes, exchange, memory, cursor, before)
        _combine(exchange, stress, before, received)
        _multiply(nodes, matrix, received, before, stress)
        _combine(exchange, 0, before, memory[cursor])
        cursor = cursor + 1 if cursor + 1 < memory.shape[0] else 0
    return cursor


@allocating
def march_back(
    nodes: Nodes,
    law: Law,
    exchange: _Exchange,
    matrices: tuple[Array, Array],
    h: float,
    integral: Array,
    motion: Motion,
    memory: Array,
    pulses: Array,
) -> None:
    """The adjoint of `march_tangent` in whole steps: pulses (2, k, s) <- derivatives of a functional of the memory after the
    motion, `memory` (ring, rows) with an empty last row, by shear stress on the interface and by the drive. `matrices`:
    `exchange_matrix` and `driven_matrix`. The stress acts on friction only: slabs feel the slip that it causes."""
    s, cursor, (passed, driven) = len(nodes), memory.shape[0] - 1, matrices
    stress, answer, matrix, at_end = memory.shape[1], blank_answer(nodes), np.empty((s + 1, s + 1)), np.zeros(s + 1)
    at_end[s] = 1.0
    for n in range(motion.z.shape[0] - 1, -1, -1):
        cursor = cursor - 1 if cursor else memory.shape[0] - 1
        step_answer(nodes, law, Diagonal(exchange.impedance), h, integral, motion, n, answer)
        _step_matrix(nodes, exchange.impedance, answer.matrix, at_end, matrix)
        before = np.dot(memory[cursor], passed[:stress])
        received = np.dot(before[stress:], matrix)
        pulses[0, n], pulses[1, n] = received[:s] - before[stress:-1], np.dot(memory[cursor], driven)
        before += np.dot(received, passed[stress:])
        memory[cursor] = 0.0
        _depart(nodes, exchange, before, cursor, memory)


@njit
def _depart(nodes: Nodes, exchange: _Exchange, before: Array, cursor: int, memory: Array) -> None:
    """The adjoint of `_arrive_columns`, added to `memory` (ring, rows)."""
    s, ring, weights = len(nodes), memory.shape[0], exchange.weights
    for i in range(memory.shape[1]):
        j = i % s
        alone = i >= weights.shape[0] or weights[i, 0, j] == 1.0
        for n in range(1 if alone else weights.shape[1]):
            row = cursor - exchange.back[i, n]
            row += ring if row < 0 else 0
            if alone:
                memory[row, i] += before[i]
            else:
                for k in range(s):
                    memory[row, i - j + k] += weights[i, n, k] * before[i]


@njit
def _step_matrix(nodes: Nodes, impedance: float, answer: Array, weights: Array, matrix: Array) -> None:
    """matrix (s + 1, s + 1) <- d(stress at the nodes, psi at the end)/d(incoming stress at the nodes, psi at the start), where
    `weights` (s + 1,) of psi at its start and nodes give psi at the end."""
    s = len(nodes)
    for m in range(weights.size):
        end = 0.0
        for j in range(s):
            matrix[j, m] = -impedance * answer[j, m]
            end += weights[1 + j] * answer[s + j, m]
        matrix[s, m] = end
    for j in range(s):
        matrix[j, j] += 1.0
    matrix[s, s] += weights[0]


@njit
def _arrive_columns(nodes: Nodes, exchange: _Exchange, memory: Array, cursor: int, arrived: Array) -> None:
    """Rows of arrived <- output of earlier steps that arrives in the step at `cursor`."""
    s, ring, weights = len(nodes), memory.shape[0], exchange.weights
    for i in range(memory.shape[1]):
        j = i % s
        alone = i >= weights.shape[0] or weights[i, 0, j] == 1.0
        for n in range(1 if alone else weights.shape[1]):
            row = cursor - exchange.back[i, n]
            row += ring if row < 0 else 0
            for c in range(memory.shape[2]):
                total = arrived[i, c] if n else 0.0
                if alone:
                    total = memory[row, i, c]
                else:
                    for k in range(s):
                        total += weights[i, n, k] * memory[row, i - j + k, c]
                arrived[i, c] = total


@njit
def _multiply(nodes: Nodes, matrix: Array, source: Array, target: Array, first: int) -> None:
    """Rows of target from `first` <- matrix (s + 1, s + 1) times source."""
    s = len(nodes)
    for j in range(matrix.shape[0]):
        for c in range(source.shape[1]):
            total = matrix[j, s] * source[s, c]
            for m in range(s):
                total += matrix[j, m] * source[m, c]
            target[first + j, c] = total


@njit
def _combine(exchange: _Exchange, first: int, source: Array, target: Array) -> None:
    """target <- rows of the matrix from `first`, times source."""
    for i in range(target.shape[0]):
        for k in range(exchange.starts[first + i], exchange.starts[first + i + 1]):
            factor, m = exchange.factors[k], exchange.sources[k]
            if k == exchange.starts[first + i]:
                for c in range(source.shape[1]):
                    target[i, c] = factor * source[m, c]
            else:
                for c in range(source.shape[1]):
                    target[i, c] += factor * source[m, c]


@allocating
def logs_of_return(law: Law, impedance: float, z: Array, psi: Array) -> Array:
    """Sums over the rows of `z` and `psi` (steps, m) of ln |(F_v - Z)/(F_v + Z)|: the factor with which an interface of
    slabs of impedance Z returns a wave while psi is held."""
    total = np.zeros(z.shape[1])
    for k in range(z.shape[0]):
        for j in range(z.shape[1]):
            _, v_z, _, friction_z, _, _, _, _ = respond(law, z[k, j], psi[k, j])
            total[j] += np.log(abs((friction_z - impedance * v_z) / (friction_z + impedance * v_z)))
    return total
