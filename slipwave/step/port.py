"""What a slab model supplies to the collocated step: the stress that arrives, its impedance, and how it takes the slip rate in.

A port is a NamedTuple with `length` (L,), the step lengths (transits) that it has tables for, longest first, each half of the one
before; `impedance` (L, s, s), K of each; `ready` (L,), whether the tables of that length were made. Register its versions of the
two functions below.
"""

from typing import Any, TypeAlias

from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes

Port: TypeAlias = Any
"""An instance of a port's class (a NamedTuple)."""


@by_class(inline=True)
def arrive(port: Port, nodes: Nodes, level: int, incoming: Array, work: Array) -> None:
    """incoming[0, j] <- S_j of a step of length `port.length[level]`, from what the port remembers and the drive V at the nodes,
    work[DRIVE]. Changes nothing that is remembered: a step may be tried again with another length."""
    raise NotImplementedError(type(port))


@by_class(inline=True)
def take_in(port: Port, nodes: Nodes, level: int, integral: Array, incoming: Array, work: Array) -> None:
    """Go to the end of the step, with the slip rate work[RATE] and the drive work[DRIVE] at its nodes. `incoming` is that of
    `arrive`."""
    raise NotImplementedError(type(port))
