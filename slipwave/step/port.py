"""A slab model in the collocation step: for every step length a linear map of its memory, the slip rate and the drive."""

import math
from collections.abc import Iterable
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import inlined, njit
from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.step.collocation import Nodes
from slipwave.step.nodal import Nodal

LEVELS = 32
"""Step lengths of a march, each half of the one before."""

Levels: TypeAlias = NDArray[np.int64]

_LANES = 8  # doubles in a cache line; rows of the tables begin and end with a line, otherwise a long step costs twice as much


class _NoLedger(NamedTuple):
    """The `ledger` of a port without an energy balance: `is_kept` (1,) is false."""

    is_kept: NDArray[np.bool_]


NO_LEDGER = _NoLedger(np.zeros(1, dtype=np.bool_))


class Port(NamedTuple):
    """The memory x (n,), a deviation from steady sliding at V_0, gives at each level, with u = v - V_0 and c = V - V_0,

        S = `steady` + x `free` + c `driven`,     x(end) - x = (x, u, c) `change`;

    S, v and the drive V at the s nodes of a step; all are rows. K = `impedance` is that of the stress mu = S - K v. `length`
    (L,), the step lengths (transits), longest first, each half of the one before; `ready` (L,), whether a level's tables were
    made; `impedance` (L, s, s), `steady` (L, s), `free` (L, n, s), `driven` (L, s, s), `change` (L, n + 2 s, n). n
    counts padding.

    `values` (n,) is the present x; `vector` (n + 2 s,) is scratch; `ledger` sums work and heat (`record`)."""

    length: Array
    ready: NDArray[np.bool_]
    impedance: Array
    steady: Array
    free: Array
    driven: Array
    change: Array
    velocity: float
    drive_is_constant: bool
    values: Array
    vector: Array
    ledger: Any


class Slabs(Protocol):
    """A slab model that couples to friction through ports. The memory of a port consists of stresses."""

    @property
    def scene(self) -> Scene:
        """The scene of the slabs."""

    @property
    def model(self) -> str:
        """The model's name."""

    @property
    def stages(self) -> int:
        """Nodes of a step."""

    @property
    def remembered(self) -> int:
        """Number of values in the memory of a port."""

    def port(self, longest: float, levels: int = LEVELS) -> Port:
        """A port for steps of `longest` (transits) and its halves, `levels` in all, with its own memory, zero. Tables are shared
        between ports of the same arguments."""

    def prepare(self, port: Port, level: int) -> None:
        """Make the tables of a level that is not ready."""

    def resistance(self, port: Port, levels: Levels, growth: float) -> Array:
        """Impedances Z at s = growth/length of some levels, in units of the normal stress over V*."""

    @property
    def follows_drive(self) -> bool:
        """Whether the port's tables also hold for a drive that changes, though that of the scene does not."""

    def next_break(self, time: float) -> float:
        """The first time after `time` (transits) at which a step must end, because the motion has a kink there; inf if none."""

    def of(self, scene: Scene) -> "Slabs":
        """The same model of another scene."""


def prepared(slabs: Slabs, port: Port, levels: Iterable[int]) -> Port:
    """`port` with the tables of these `levels`, made where they are not ready."""
    for level in levels:
        if not port.ready[level]:
            slabs.prepare(port, level)
    return port


def padded(remembered: int) -> int:
    """Length of the memory of `remembered` values, padded with zeros to whole cache lines if it is long."""
    return remembered if remembered < 2 * _LANES else -(-remembered // _LANES) * _LANES


def line_aligned(*shape: int) -> Array:
    """An array of zeros that begins at a cache line."""
    size = math.prod(shape)
    memory = np.zeros(size + _LANES)
    first = -(memory.ctypes.data // memory.itemsize) % _LANES
    return memory[first : first + size].reshape(shape)


@by_class()
def record(ledger: Any, port: Port, nodes: Nodes, level: int, rows: int, integral: Array, nodal: Nodal) -> None:
    """Add the work and heat of a step of `level` to the `ledger` of `port`, whose `vector` has (x, u, c) in its first `rows`
    entries. Does nothing for `_NoLedger`; each class of ledger registers its own version."""


@inlined
def arrive(port: Port, nodes: Nodes, level: int, nodal: Nodal) -> None:
    """nodal.incoming <- S of a step of `level`. The memory does not change: a step may be tried again with another length."""
    s, incoming = len(nodes), nodal.incoming
    free, driven, values = port.free, port.driven, port.values
    for j in range(s):
        incoming[j] = port.steady[level, j]
    for i in range(values.size):
        value = values[i]
        for j in range(s):
            incoming[j] += free[level, i, j] * value
    if not port.drive_is_constant:
        for m in range(s):
            change = nodal.drive[m] - port.velocity
            for j in range(s):
                incoming[j] += driven[level, m, j] * change


@inlined
def take_in(port: Port, nodes: Nodes, level: int, integral: Array, nodal: Nodal) -> None:
    """Advance the memory to the end of the solved step."""
    s, n, vector, values = len(nodes), port.values.size, port.vector, port.values
    rows = n + s if port.drive_is_constant else n + 2 * s
    for i in range(n):
        vector[i] = values[i]
    for j in range(s):
        vector[n + j] = nodal.v[j] - port.velocity
        vector[n + s + j] = nodal.drive[j] - port.velocity
    if port.ledger.is_kept[0]:
        record(port.ledger, port, nodes, level, rows, integral, nodal)
    propagate(port.change, level, rows, vector, values)


@njit
def propagate(change: Array, level: int, rows: int, vector: Array, values: Array) -> None:
    """values += vector @ change[level], four rows at a time: a fifth of the loads and stores of one at a time."""
    whole = rows - rows % 4
    for i in range(0, whole, 4):
        a, b, c, d = vector[i], vector[i + 1], vector[i + 2], vector[i + 3]
        for k in range(values.size):
            values[k] += (a * change[level, i, k] + b * change[level, i + 1, k]) + (
                c * change[level, i + 2, k] + d * change[level, i + 3, k]
            )
    for i in range(whole, rows):
        for k in range(values.size):
            values[k] += vector[i] * change[level, i, k]
