"""What the lines of a network do to waves in a step: linear, the same in every step, and so a matrix (`Exchange`).

It is found by sending unit waves through the functions of the march itself.
"""

from typing import NamedTuple

import numpy as np

from reduced.delay.network_kernel import Integers, Network, Passage, gather, launch, passage_of
from slipwave.compiled import njit
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes


class Exchange(NamedTuple):
    """What leaves a step and what the interface receives in it, from what arrives and what the interface does.

    Rows of the matrix: the waves that leave (layers, 2, s), the outer faces' state (slabs, 2) and psi at the step's end; the
    stress that waves bring to the interface (s), and psi at the start. Columns: the waves that arrive, the faces' state and psi
    at the start; the interface's stress (s), and psi at the end. The nonzero entries of row i are [starts[i], starts[i + 1]),
    with their columns, `sources`, and values, `factors`; no row is empty.

    What leaves arrives `back` (rows, n) steps later; waves with the `weights` (waves, n, s) of the nodes of these steps, others
    at once in the first."""

    starts: Integers
    sources: Integers
    factors: Array
    back: Integers
    weights: Array


def exchange_of(nodes: Nodes, network: Network, length: float, integral: Array) -> Exchange:
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
    return Exchange(starts, columns, matrix[rows, columns], back, weights)


def exchange_matrix(nodes: Nodes, network: Network, length: float, integral: Array) -> Array:
    """The matrix of `Exchange`."""
    s, layers, slabs = len(nodes), network.impedance.size, network.first.size
    near = network._replace(back=np.zeros_like(network.back), whole=np.ones(layers, dtype=np.bool_))
    faces, psi, stress = 2 * layers * s, 2 * (layers * s + slabs), 2 * (layers * s + slabs) + 1
    units = np.eye(stress + s + 1)
    waves, tops, moved = units[:, :faces].copy(), units[:, faces:psi].copy(), units[:, stress:-1].copy()
    received = np.zeros_like(moved)
    lines = (waves.reshape(-1, layers, 2, 1, s), tops.reshape(-1, slabs, 2))
    exchange_units(nodes, near, length, integral, *lines, moved, passage_of(near, s), received[:, None])
    return np.column_stack([waves, tops, units[:, -1], received, units[:, psi]]).T


@njit
def exchange_units(
    nodes: Nodes,
    network: Network,
    length: float,
    integral: Array,
    waves: Array,
    tops: Array,
    stress: Array,
    passage: Passage,
    incoming: Array,
) -> None:
    """Send each of n states through a `network` without delays: waves (n, layers, 2, 1, s) and tops (n, slabs, 2), in place, with
    the interface's stress (n, s); incoming (n, 1, s) += the stress that waves bring to the interface."""
    for c in range(waves.shape[0]):
        gather(nodes, network, 0, length, integral, waves[c], tops[c], passage, incoming[c])
        launch(nodes, network, 0, stress[c], passage, waves[c])
