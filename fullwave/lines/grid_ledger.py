"""The energy balance of an exactly propagated grid: work of the drive and heat of each step, from quantities of its port."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import njit
from slipwave.observe.pieces import Array
from slipwave.scene.drive import Forcing
from slipwave.step.collocation import Nodes
from slipwave.step.nodal import Nodal
from slipwave.step.port import Port, propagate, record

INPUT, FRICTION, RADIATED, VISCOUS = range(4)  # entries of `GridLedger.entries`


class GridLedger(NamedTuple):
    """If `is_kept` (1,), the `entries` (4,) are summed. Per level, from (x, u, c) of the `Port`: `moments` (L, n + 2 s, m), and
    as a quadratic form viscous `heat` (L, n + 2 s, n + 2 s), empty in elastic slabs. `copies` of each marched slab; `sides`,
    their number; the `dashpots`. `taken` (m,) and `spare` (n + 2 s,) are scratch.

    The moments: of all tractions (two), of the slip at faces under a dead load, then those of each dashpot's slip (s each)."""

    is_kept: NDArray[np.bool_]
    entries: Array
    moments: Array
    heat: Array
    forcing: Forcing
    copies: float
    sides: int
    dashpots: Array
    taken: Array
    spare: Array


@record.register(GridLedger)
def _record_step(ledger, port, nodes, level, rows, integral, nodal):  # type: ignore[no-untyped-def]
    _add_work(ledger, port, nodes, level, rows, integral, nodal)
    if ledger.heat.size:
        scale = ledger.copies * port.length[level] * ledger.forcing.transit
        ledger.entries[VISCOUS] += scale * _heat(ledger.heat, level, rows, port.vector, ledger.spare)


@njit
def _heat(heat: Array, level: int, rows: int, vector: Array, spare: Array) -> float:
    """vector . heat[level] vector."""
    for k in range(spare.size):
        spare[k] = 0.0
    propagate(heat, level, rows, vector, spare)
    total = 0.0
    for k in range(rows):
        total += vector[k] * spare[k]
    return total


@njit
def _add_work(ledger: GridLedger, port: Port, nodes: Nodes, level: int, rows: int, integral: Array, nodal: Nodal) -> None:
    """Add the step's work of the drive, heat of friction and radiation. Friction's stress and slip rate are polynomials, and the
    drive is linear, so that their moments give their work exactly; a dashpot's slip is represented by its projection."""
    s, forcing, entries, dashpots = len(nodes), ledger.forcing, ledger.entries, ledger.dashpots
    length, moments, taken, vector = port.length[level], ledger.moments, ledger.taken, port.vector
    for k in range(taken.size):
        taken[k] = 0.0
    for i in range(rows):
        for k in range(taken.size):
            taken[k] += moments[level, i, k] * vector[i]
    heat = 0.0
    for j in range(s):
        stress = nodal.incoming[j]
        for m in range(s):
            stress -= port.impedance[level, j, m] * nodal.v[m]
        heat += integral[j, s - 1] * stress * nodal.v[j]
    entries[FRICTION] += length * forcing.transit * heat
    slope = (nodal.drive[s - 1] - nodal.drive[0]) / (nodes[s - 1] - nodes[0])
    middle = nodal.drive[s - 1] - 0.5 * slope
    done = 0.5 * (middle * (ledger.sides * forcing.steady_stress + taken[0]) + 0.5 * slope * taken[1])
    scale = ledger.copies * length * forcing.transit
    entries[INPUT] += scale * (done - forcing.steady_stress * taken[2])
    lost = 0.0
    for side in range(dashpots.size):
        for k in range(s):
            moment = taken[3 + side * s + k]
            lost += dashpots[side] * (2 * k + 1) * moment * moment
    entries[RADIATED] += scale * lost
