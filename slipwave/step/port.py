"""What a slab model is to the collocated step: a linear map, for every step length, of what it remembers, of the slip rate and of
the drive."""

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


class NoLedger(NamedTuple):
    """The `ledger` of a port that keeps none: `is_kept` (1,) is false."""

    is_kept: NDArray[np.bool_]


class Port(NamedTuple):
    """What is remembered, x (n,), in deviations from steady sliding at V_0, gives per level, with u = v - V_0 and c = V - V_0,

        S = `steady` + x `free` + c `driven`,     x(end) - x = (x, u, c) `change`;

    S, v and the drive V at the s nodes of a step; all are rows. K = `impedance` is that of the stress mu = S - K v. `length`
    (L,), the step lengths (transits), longest first, each half of the one before; `ready` (L,), whether a level's tables were
    made; `impedance` (L, s, s), `steady` (L, s), `free` (L, n, s), `driven` (L, s, s), `change` (L, n + 2 s, n). n
    counts padding.

    It remembers `values` (n,); `vector` (n + 2 s,) is scratch. Its `ledger` adds up work and heat, see `record`."""

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
    """A slab model that friction meets through ports. All that a port remembers are stresses."""

    @property
    def scene(self) -> Scene:
        """Whose slabs."""

    @property
    def model(self) -> str:
        """The model's name."""

    @property
    def stages(self) -> int:
        """Nodes of a step."""

    @property
    def remembered(self) -> int:
        """Number of values that its ports remember."""

    def port(self, longest: float, levels: int = LEVELS) -> Port:
        """A port for steps of `longest` (transits) and its halves, `levels` in all, with a memory of its own, zero. The same
        arguments give the same tables."""

    def prepare(self, port: Port, level: int) -> None:
        """Make the tables of a level that is not ready."""

    def resistance(self, port: Port, levels: Levels, growth: float) -> Array:
        """Impedances Z at s = growth/length of some levels, in units of the normal stress over V*."""

    def next_break(self, time: float) -> float:
        """The first time after `time` (transits) at which a step must end, because the motion has a kink there; inf if none."""

    def of(self, scene: Scene) -> "Slabs":
        """The same model of another scene."""


def blank_port(scene: Scene, longest: float, levels: int, remembered: int, stages: int) -> Port:
    """A port of `levels` step lengths, of which `longest` (transits) is the first, whose tables are zero and not ready."""
    n = padded(remembered)
    return Port(
        np.ldexp(longest, -np.arange(levels)),
        np.zeros(levels, dtype=np.bool_),
        np.empty((levels, stages, stages)),
        np.empty((levels, stages)),
        line_aligned(levels, n, stages),
        np.empty((levels, stages, stages)),
        line_aligned(levels, n + 2 * stages, n),
        scene.velocity,
        scene.drive.is_constant,
        line_aligned(n),
        np.zeros(n + 2 * stages),
        NoLedger(np.zeros(1, dtype=np.bool_)),
    )


def padded(remembered: int) -> int:
    """Number of values of a port that remembers so many: many are padded with zeros to whole lines of the cache."""
    return remembered if remembered < 2 * _LANES else -(-remembered // _LANES) * _LANES


def line_aligned(*shape: int) -> Array:
    """An array of zeros that begins at a cache line."""
    size = int(np.prod(shape))
    memory = np.zeros(size + _LANES)
    first = -(memory.ctypes.data // memory.itemsize) % _LANES
    return memory[first : first + size].reshape(shape)


@by_class()
def record(ledger: Any, port: Port, nodes: Nodes, level: int, rows: int, integral: Array, nodal: Nodal) -> None:
    """Add the work and heat of a step of `level` to the `ledger` of `port`, whose `vector` has (x, u, c) in its first `rows`
    entries. Nothing for `NoLedger`: register a version for the class of a ledger."""


@inlined
def arrive(port: Port, nodes: Nodes, level: int, nodal: Nodal) -> None:
    """nodal.incoming <- S of a step of `level`. Changes nothing that is remembered: a step may be tried again with another
    length."""
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
    """Go to the end of the solved step."""
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
