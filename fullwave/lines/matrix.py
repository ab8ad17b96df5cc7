"""The equations of motion without friction as matrices, for the exact march, for the step limit of scenes with viscosity or a
mass on a face, and as a simple reference for `fullwave.lines.explicit`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fullwave.lines.blocks import state_size
from fullwave.lines.system import GRIP, SCALARS, Operator, System, Viscous, apply
from slipwave.compiled import njit
from slipwave.observe.pieces import Array


@njit
def _columns(operator: Operator, states: Array, derivatives: Array) -> None:
    """Row k of `derivatives` <- `apply` to row k of `states`."""
    for k in range(states.shape[0]):
        apply(operator, states[k], derivatives[k], 0)


def derivative_of(operator: Operator, size: int) -> Array:
    """What `apply` does as a matrix (size, size) over the slots of a grid."""
    columns = np.zeros((size, size))
    _columns(operator, np.eye(size), columns)
    return columns.T


class LinearMotion(NamedTuple):
    """Linear forms, as rows, in (q, u, c): the state q = (grid, scalars, memory stresses, heavy faces) in deviations from steady
    sliding, the slip rate u = v - V_0 and the change c = (V - V_0)/2 of the drive of each face.

    `rates` (n, n + 2) gives d q/dt~; rows and columns of psi and of the ledger are zero. `stress` (n + 2,) is mu - mu_ss. Per
    marched slab: `traction` (sides, n + 2) on the driven end of the termination, minus the steady one; `slip` (sides, n + 2) of
    the drive ahead of the face."""

    rates: Array
    stress: Array
    traction: Array
    slip: Array

    @property
    def moving(self) -> NDArray[np.int64]:
        """Indices in q of the entries that move. The load of a face without a spring is constant; kept, it would be a neutral
        mode that makes orbits degenerate."""
        return np.flatnonzero(np.abs(self.rates).sum(axis=1))


def motion_matrix(system: System, locked: bool) -> Array:
    """A (n, n) of d q/dt~ = A q for constant drive and the interface either locked (v = 0: unlike slabs are welded, alike slabs
    do not move there) or free (mu constant): every friction law lies between these two."""
    motion = motion_of(system)
    n = motion.rates.shape[0]
    rates: Array = motion.rates[:, :n]
    if not locked:  # the slip rate at constant stress
        rates = rates - np.outer(motion.rates[:, n], motion.stress[:n] / motion.stress[n])
    return rates


def motion_of(system: System) -> LinearMotion:
    """The equations of motion of `system`."""
    size = system.interface.size
    viscous = system.medium if isinstance(system.medium, Viscous) else None
    total = state_size(system)
    derivative = derivative_of(system.operator, size)
    state = np.eye(total, total + 2)  # every row below is a linear form in (q, u, c)
    strong = np.zeros((size, total + 2))
    strong[:, :size] = derivative
    stress = state[:size].copy()
    if viscous is not None:
        stress += viscous.retardation[:, None] * strong
    traces, tops = system.traces, system.tops
    arriving = stress[traces.stress] - traces.sign[:, None] * traces.stiffened[:, None] * state[traces.velocity]
    star, at_interface = _star(system, state, arriving)
    jump = star - state[traces.velocity]
    rates = strong
    np.add.at(rates, traces.stress, (traces.sign * traces.lift)[:, None] * jump)
    if viscous is not None:
        total_stress = state[:size] + viscous.retardation[:, None] * rates
        rates[viscous.is_velocity] = (derivative @ total_stress)[viscous.is_velocity]
    np.add.at(rates, traces.velocity, traces.lift[:, None] * jump)
    matrix = np.zeros((total, total + 2))
    if viscous is not None:
        memory = state[size + SCALARS : 2 * size + SCALARS]
        matrix[size + SCALARS : 2 * size + SCALARS] = viscous.fraction[:, None] * rates - viscous.rate[:, None] * memory
        rates = rates - viscous.rate[:, None] * memory
    matrix[:size] = rates
    sides, grip = system.interface.sides, size + GRIP
    face = star[-sides:]
    slip = -face
    slip[:, -1] += 1.0
    matrix[grip : grip + sides] = tops.spring[:, None] * slip
    impedance = traces.impedance[-sides:, None]
    traction = impedance * (arriving[-sides:] + traces.stiffened[-sides:, None] * face)
    for side in np.flatnonzero(tops.mass):
        pull = impedance[side] * state[grip + side] + tops.dashpot[side] * slip[side]
        matrix[system.interface.heavy + side] = (pull - traction[side]) / tops.mass[side]
        traction[side] = pull
    return LinearMotion(matrix, at_interface, traction, slip)


def _star(system: System, state: Array, arriving: Array) -> tuple[Array, Array]:
    """w* at every trace, from the characteristics that arrive there, and mu - mu_ss, as linear forms."""
    traces, interface = system.traces, system.interface
    stiffened = traces.stiffened[:, None]
    star = np.zeros((traces.lift.size, state.shape[1]))
    pairs = 2 * interface.joints
    near, far = slice(0, pairs, 2), slice(1, pairs, 2)
    impedance = traces.impedance[:, None]
    common = impedance[far] * arriving[far] - impedance[near] * arriving[near]
    common /= impedance[far] * stiffened[far] + impedance[near] * stiffened[near]
    star[near] = star[far] = common
    ends = slice(pairs, pairs + interface.sides)
    free = interface.copies * (arriving[ends] / stiffened[ends]).sum(axis=0)
    free[-2] -= 1.0
    stress = interface.impedance * free
    star[ends] = (arriving[ends] - stress / impedance[ends]) / stiffened[ends]
    tops = slice(pairs + interface.sides, None)
    load = state[interface.size + GRIP : interface.size + GRIP + interface.sides]
    star[tops] = system.tops.yielding[:, None] * (load - arriving[tops])
    star[tops, -1] += system.tops.driven
    for side in np.flatnonzero(system.tops.mass):
        star[side - interface.sides] = state[interface.heavy + side]
    return star, stress
