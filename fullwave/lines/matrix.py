"""The equations of motion without friction, as a matrix: a simple reference for `fullwave.lines.motion`, and the basis of the
step limit of scenes with viscosity or a mass on a face.

The interface is either locked (v = 0: unlike slabs are welded, alike slabs do not move there) or free (mu constant): every
friction law lies between these two.
"""

import numpy as np

from fullwave.lines.blocks import state_size
from fullwave.lines.system import (
    DASHPOT,
    GRIP,
    IMPEDANCE,
    LIFT,
    MASS,
    SCALARS,
    SIGN,
    SPRING,
    STIFFENED,
    STRESS,
    VELOCITY,
    YIELDING,
    Operator,
    System,
    apply,
    finish,
)
from fullwave.lines.viscosity import Viscous
from slipwave.compiled import njit
from slipwave.observe.pieces import Array


@njit
def _columns(operator: Operator, states: Array, at_apply: Array, at_finish: Array) -> None:
    """Row k of `at_apply` <- `apply` to row k of `states`; row k of `at_finish` <- `finish` of it (M^-1 of a consistent mass)."""
    for k in range(states.shape[0]):
        apply(operator, states[k], at_apply[k], 0)
        at_finish[k] = states[k]
        finish(operator, at_finish[k], 0)


def motion_matrix(system: System, locked: bool) -> Array:
    """A (n, n) of d q/dt~ = A q for q = (grid, scalars, memory stresses, heavy faces) in deviations from steady sliding, without
    friction, drive, state and ledger (their rows and columns are zero)."""
    size = system.interface.size
    viscous = system.medium if isinstance(system.medium, Viscous) else None
    total = state_size(system)
    derivative, completion = np.zeros((size, size)), np.zeros((size, size))
    _columns(system.operator, np.eye(size), derivative, completion)
    state = np.eye(total)  # every row below is a linear form in the state
    strong = np.zeros((size, total))
    strong[:, :size] = derivative.T
    stress = state[:size].copy()
    if viscous is not None:
        stress += viscous.retardation[:, None] * strong
    slots, facts = system.slots, system.facts
    arriving = stress[slots[STRESS]] - facts[SIGN][:, None] * facts[STIFFENED][:, None] * state[slots[VELOCITY]]
    jump = _jumps(system, state, arriving, locked)
    rates = strong
    np.add.at(rates, slots[STRESS], (facts[SIGN] * facts[LIFT])[:, None] * jump)
    if viscous is not None:
        total_stress = state[:size] + viscous.retardation[:, None] * rates
        rates[viscous.is_velocity] = (derivative.T @ total_stress)[viscous.is_velocity]
    np.add.at(rates, slots[VELOCITY], facts[LIFT][:, None] * jump)
    rates = completion.T @ rates
    matrix = np.zeros((total, total))
    if viscous is not None:
        memory = state[size + SCALARS : 2 * size + SCALARS]
        matrix[size + SCALARS : 2 * size + SCALARS] = viscous.fraction[:, None] * rates - viscous.rate[:, None] * memory
        rates = rates - viscous.rate[:, None] * memory
    matrix[:size] = rates
    sides, grip = system.interface.sides, size + GRIP
    tops = slots[VELOCITY, -sides:]
    matrix[grip : grip + sides] = -system.tops[SPRING][:, None] * (jump[-sides:] + state[tops])
    for side in np.flatnonzero(system.tops[MASS]):
        k, own = side - sides, state[system.interface.heavy + side]
        pull = facts[IMPEDANCE, k] * (state[grip + side] - arriving[k] - facts[STIFFENED, k] * own)
        matrix[system.interface.heavy + side] = (pull - system.tops[DASHPOT, side] * own) / system.tops[MASS, side]
    return matrix


def _jumps(system: System, state: Array, arriving: Array, locked: bool) -> Array:
    """w* - w at every trace, as linear forms in the state, from the characteristics that arrive there."""
    slots, facts, interface = system.slots, system.facts, system.interface
    velocity, stiffened = state[slots[VELOCITY]], facts[STIFFENED][:, None]
    star = np.zeros_like(velocity)
    pairs = 2 * interface.joints
    near, far = slice(0, pairs, 2), slice(1, pairs, 2)
    impedance = facts[IMPEDANCE][:, None]
    common = impedance[far] * arriving[far] - impedance[near] * arriving[near]
    common /= impedance[far] * stiffened[far] + impedance[near] * stiffened[near]
    star[near] = star[far] = common
    ends = slice(pairs, pairs + interface.sides)
    star[ends] = arriving[ends] / stiffened[ends]
    if locked:
        free = interface.copies * star[ends].sum(axis=0)
        star[ends] -= interface.impedance * free / (impedance[ends] * stiffened[ends])
    tops = slice(pairs + interface.sides, None)
    load = state[interface.size + GRIP : interface.size + GRIP + interface.sides]
    star[tops] = system.tops[YIELDING][:, None] * (load - arriving[tops])
    for side in np.flatnonzero(system.tops[MASS]):
        star[side - interface.sides] = state[interface.heavy + side]
    jumps: Array = star - velocity
    return jumps
