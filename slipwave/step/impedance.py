"""The impedance K of a slab pair over one collocation step: the stress at node j is  mu_j = S_j - sum_l K_jl v_l.

Waves that leave the interface and do not return within the step give a diagonal K with equal entries. States that respond within
the step give a full matrix, for which the functions here are written. Compiled code is specialised by class, so that a diagonal K
costs nothing extra.
"""

from typing import Any, NamedTuple, TypeAlias

from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.nodal import Nodal


class Diagonal(NamedTuple):
    """K = value times the identity."""

    value: float


class Full(NamedTuple):
    """K = matrix (s, s)."""

    matrix: Array


Impedance: TypeAlias = Diagonal | Full


@by_class(inline=True)
def own(impedance: Any, j: int) -> float:
    """K_jj."""
    return float(impedance.matrix[j, j])


@by_class(inline=True)
def others(impedance: Any, nodes: Nodes, j: int, rates: Array) -> float:
    """Sum over l != j of K_jl rates_l."""
    matrix, total = impedance.matrix, 0.0
    for m in range(len(nodes)):
        if m != j:
            total += matrix[j, m] * rates[m]
    return total


@by_class(inline=True)
def influence(impedance: Any, nodes: Nodes, nodal: Nodal) -> float:
    """Add the stress by other nodes' rates to the mismatch of each node. Returns the largest influence of the others on a node's
    z: sum over l != j of |K_jl v_z,l| over F_z,j + K_jj v_z,j."""
    matrix, largest = impedance.matrix, 0.0
    for j in range(matrix.shape[0]):
        stress, size, inverse = 0.0, 0.0, nodal.inverse[j]
        for m in range(len(nodes)):
            if m != j:
                stress += matrix[j, m] * nodal.v[m]
                size += abs(matrix[j, m]) * nodal.v_z[m]
        nodal.mismatch[j] += stress * inverse
        nodal.gain[j] -= nodal.by_z[j] * stress * inverse
        largest = max(largest, size * inverse)
    return largest


@own.register(Diagonal)
def _own_of_diagonal(impedance, j):  # type: ignore[no-untyped-def]
    return impedance.value


@others.register(Diagonal)
def _others_of_diagonal(impedance, nodes, j, rates):  # type: ignore[no-untyped-def]
    return 0.0


@influence.register(Diagonal)
def _influence_in_diagonal(impedance, nodes, nodal):  # type: ignore[no-untyped-def]
    return 0.0
