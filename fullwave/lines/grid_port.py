"""The port of slabs on a grid that is propagated exactly (`propagator`): products of tabulated matrices with its values."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import njit
from slipwave.observe.pieces import Array
from slipwave.scene.forcing import Forcing
from slipwave.step.collocation import Nodes
from slipwave.step.port import arrive, take_in
from slipwave.step.rows import DRIVE, RATE

INPUT, FRICTION, RADIATED, VISCOUS = range(4)  # entries of `GridPort.ledger`


class Power(NamedTuple):
    """What turns the moments of a step into work: `copies` of each marched slab; `sides`, their number; the `dashpots`."""

    copies: float
    sides: int
    dashpots: Array


class GridPort(NamedTuple):
    """Per level: `length` (L,); `ready` (L,); `impedance` K (L, s, s); `steady` (L, s), stress of steady sliding plus K V_0;
    `free` (L, n, s), the stress at the nodes from the grid's values; `driven` (L, s, s), from changes of the drive. From the
    grid's values, v - V_0 and changes of the drive at the nodes: `change` (L, n + 2 s, n) of the grid's values, `moments`
    (L, n + 2 s, m) for the ledger, and as a quadratic form viscous `heat` (L, n + 2 s, n + 2 s), empty in elastic slabs. n counts
    padding of zeros.

    The moments: of all tractions (two), of the slip at faces under a dead load, then those of each dashpot's slip (s each).

    It remembers the grid's `values` (n,) and, where `keeps_ledger` (1,) is true, the `ledger` (4,); `vector` and `spare`
    (n + 2 s,) and `taken` (m,) are scratch."""

    length: Array
    ready: NDArray[np.bool_]
    impedance: Array
    steady: Array
    free: Array
    driven: Array
    change: Array
    moments: Array
    heat: Array
    forcing: Forcing
    power: Power
    constant_drive: bool
    keeps_ledger: NDArray[np.bool_]
    values: Array
    ledger: Array
    vector: Array
    taken: Array
    spare: Array


@arrive.register(GridPort)
def _arrive(port, nodes, level, incoming, work):  # type: ignore[no-untyped-def]
    s = len(nodes)
    free, driven, values = port.free, port.driven, port.values
    for j in range(s):
        incoming[0, j] = port.steady[level, j]
    for i in range(values.size):
        value = values[i]
        for j in range(s):
            incoming[0, j] += free[level, i, j] * value
    if not port.constant_drive:
        for m in range(s):
            change = 0.5 * (work[DRIVE, m] - port.forcing.velocity)
            for j in range(s):
                incoming[0, j] += driven[level, m, j] * change


@take_in.register(GridPort)
def _take_in(port, nodes, level, integral, incoming, work):  # type: ignore[no-untyped-def]
    s, n, vector, values = len(nodes), port.values.size, port.vector, port.values
    rows = n + s if port.constant_drive else n + 2 * s
    for i in range(n):
        vector[i] = values[i]
    for j in range(s):
        vector[n + j] = work[RATE, j] - port.forcing.velocity
        vector[n + s + j] = 0.5 * (work[DRIVE, j] - port.forcing.velocity)
    if port.keeps_ledger[0]:
        _keep_ledger(nodes, port, level, rows, integral, incoming, work)
        if port.heat.size:
            port.ledger[VISCOUS] += (
                port.power.copies * port.length[level] * port.forcing.transit * _heat(port.heat, level, rows, vector, port.spare)
            )
    _propagate(port.change, level, rows, vector, values)


@njit
def _heat(heat: Array, level: int, rows: int, vector: Array, spare: Array) -> float:
    """vector . heat[level] vector."""
    for k in range(spare.size):
        spare[k] = 0.0
    _propagate(heat, level, rows, vector, spare)
    total = 0.0
    for k in range(rows):
        total += vector[k] * spare[k]
    return total


@njit
def _propagate(change: Array, level: int, rows: int, vector: Array, values: Array) -> None:
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


@njit
def _keep_ledger(nodes: Nodes, port: GridPort, level: int, rows: int, integral: Array, incoming: Array, work: Array) -> None:
    """Add the step's work of the drive, heat of friction and radiation. Friction's stress and slip rate are polynomials, and the
    drive is linear, so that their moments give their work exactly; a dashpot's slip is represented by its projection."""
    s, forcing, power, ledger = len(nodes), port.forcing, port.power, port.ledger
    length, moments, taken, vector = port.length[level], port.moments, port.taken, port.vector
    for k in range(taken.size):
        taken[k] = 0.0
    for i in range(rows):
        for k in range(taken.size):
            taken[k] += moments[level, i, k] * vector[i]
    heat = 0.0
    for j in range(s):
        stress = incoming[0, j]
        for m in range(s):
            stress -= port.impedance[level, j, m] * work[RATE, m]
        heat += integral[j, s - 1] * stress * work[RATE, j]
    ledger[FRICTION] += length * forcing.transit * heat
    slope = (work[DRIVE, s - 1] - work[DRIVE, 0]) / (nodes[s - 1] - nodes[0])
    middle = work[DRIVE, s - 1] - 0.5 * slope
    done = 0.5 * (middle * (power.sides * forcing.steady_stress + taken[0]) + 0.5 * slope * taken[1])
    scale = power.copies * length * forcing.transit
    ledger[INPUT] += scale * (done - forcing.steady_stress * taken[2])
    lost = 0.0
    for side in range(power.dashpots.size):
        for k in range(s):
            moment = taken[3 + side * s + k]
            lost += power.dashpots[side] * (2 * k + 1) * moment * moment
    ledger[RADIATED] += scale * lost
