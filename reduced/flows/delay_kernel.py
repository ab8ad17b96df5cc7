"""The compiled derivative of `march_network`: what the waves of equal steps do with small changes of their state.

All changes are carried at once, each in a column, the last axis of every array: loops over columns are what the compiler
vectorises. Friction's part is `step_answer`, the slabs' part `Exchange`.
"""

import numpy as np

from reduced.flows.exchange import Exchange
from slipwave.compiled import allocating, njit
from slipwave.friction import Law, respond
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.impedance import Diagonal
from slipwave.step.tangent import SLOPES, step_answer


@allocating
def march_tangent(
    nodes: Nodes,
    law: Law,
    impedance: float,
    exchange: Exchange,
    h: float,
    integral: Array,
    z: Array,
    psi: Array,
    frozen: bool,
    memory: Array,
    cursor: int,
    last: Array,
) -> int:
    """Carry n changes of the state along the motion with nodal `z` and `psi` (steps, s).

    `memory` (ring, rows, n): what left past steps, in rows as in `exchange`; the next step is `cursor`. `h` is the length of a
    step on the friction clock. psi is taken within the last step, by the weights `last` (s + 1,) of psi at its start and nodes;
    all else at its end. Returns the ring index of the step after the last."""
    s, count, stress = len(nodes), z.shape[0], memory.shape[1]
    slopes, by_state = np.empty((SLOPES, s)), np.empty((s, 2 * s + 1))
    answer, matrix, at_end = np.empty((2 * s, 2 * s + 1)), np.empty((s + 1, s + 1)), np.zeros(s + 1)
    before, received = np.zeros((stress + s + 1, memory.shape[2])), np.zeros((s + 1, memory.shape[2]))
    at_end[s] = 1.0
    for n in range(count):
        step_answer(nodes, law, Diagonal(impedance), h, integral, z[n], psi[n], frozen, slopes, by_state, answer)
        step_matrix(nodes, impedance, answer, last if n == count - 1 else at_end, matrix)
        arrive_columns(nodes, exchange, memory, cursor, before)
        combine(exchange, stress, before, received)
        multiply(nodes, matrix, received, before, stress)
        combine(exchange, 0, before, memory[cursor])
        cursor = cursor + 1 if cursor + 1 < memory.shape[0] else 0
    return cursor


@njit
def step_matrix(nodes: Nodes, impedance: float, answer: Array, weights: Array, matrix: Array) -> None:
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
def arrive_columns(nodes: Nodes, exchange: Exchange, memory: Array, cursor: int, arrived: Array) -> None:
    """Rows of arrived <- what left earlier steps and arrives in the step at `cursor`."""
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
def multiply(nodes: Nodes, matrix: Array, source: Array, target: Array, first: int) -> None:
    """Rows of target from `first` <- matrix (s + 1, s + 1) times source."""
    s = len(nodes)
    for j in range(matrix.shape[0]):
        for c in range(source.shape[1]):
            total = matrix[j, s] * source[s, c]
            for m in range(s):
                total += matrix[j, m] * source[m, c]
            target[first + j, c] = total


@njit
def combine(exchange: Exchange, first: int, source: Array, target: Array) -> None:
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
