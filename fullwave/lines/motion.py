"""Time derivative of a `System`: the right-hand side that every Runge-Kutta stage of every family evaluates.

`rates` is flat: a stage's values begin at index `at`. `arrivals` is scratch.
"""

import numpy as np
from numpy.typing import NDArray

from fullwave.lines.system import (
    ARRIVING,
    DASHPOT,
    DEAD,
    DRIVEN,
    ELASTIC,
    FRICTION,
    GRIP,
    IMPEDANCE,
    INPUT,
    JUMP,
    LIFT,
    MASS,
    PSI,
    RADIATED,
    SIGN,
    SPRING,
    STIFFENED,
    STRESS,
    VELOCITY,
    VISCOUS,
    YIELDING,
    Interface,
    Medium,
    Operator,
    apply,
    finish,
)
from fullwave.lines.viscosity import dissipate, retard, total_stress
from slipwave.compiled import inlined
from slipwave.friction import respond
from slipwave.friction.interface import solve_interface
from slipwave.observe.pieces import Array
from slipwave.scene.drive import Constant, Ramps, velocity_at
from slipwave.scene.forcing import Forcing
from slipwave.scene.start import nudge_rate


@inlined
def _meet_joints(joints: int, slots: NDArray[np.int64], facts: Array, state: Array, arrivals: Array) -> None:
    """w* - w on both sides of each joint, from continuity of velocity and stress."""
    for near in range(0, 2 * joints, 2):
        far = near + 1
        pull = facts[IMPEDANCE, far] * arrivals[ARRIVING, far] - facts[IMPEDANCE, near] * arrivals[ARRIVING, near]
        both = facts[IMPEDANCE, far] * facts[STIFFENED, far] + facts[IMPEDANCE, near] * facts[STIFFENED, near]
        common = pull / both
        arrivals[JUMP, near] = common - state[slots[VELOCITY, near]]
        arrivals[JUMP, far] = common - state[slots[VELOCITY, far]]


@inlined
def _meet_interface(
    interface: Interface, forcing: Forcing, slots: NDArray[np.int64], facts: Array, state: Array, z: float, arrivals: Array
) -> tuple[float, float, float, int]:
    """Friction solve at the interface: returns (z, v, mu, iterations) and sets w* - w of each slab."""
    first = 2 * interface.joints
    free = forcing.velocity
    for k in range(first, first + interface.sides):
        free += interface.copies * arrivals[ARRIVING, k] / facts[STIFFENED, k]
    incoming = forcing.steady_stress + interface.impedance * free
    psi = state[interface.size + PSI]
    z, iterations = solve_interface(interface.law, interface.impedance, incoming, psi, z)
    v = respond(interface.law, z, psi)[0]
    change = interface.impedance * (free - v)
    for k in range(first, first + interface.sides):
        own = (arrivals[ARRIVING, k] - change / facts[IMPEDANCE, k]) / facts[STIFFENED, k]
        arrivals[JUMP, k] = own - state[slots[VELOCITY, k]]
    return z, v, forcing.steady_stress + change, iterations


@inlined
def _meet_tops(
    interface: Interface,
    forcing: Forcing,
    slots: NDArray[np.int64],
    facts: Array,
    tops: Array,
    drive: float,
    state: Array,
    rates: Array,
    at: int,
    arrivals: Array,
) -> None:
    """Sets w* - w at the outer faces, each driven at half of `drive`, and the rates of the springs' loads, of heavy faces'
    velocities, of the input and of the radiation."""
    first, load = 2 * interface.joints + interface.sides, interface.size + GRIP
    steady = 0.5 * forcing.velocity
    change = 0.5 * drive - steady
    power = lost = 0.0
    for side in range(interface.sides):
        k = first + side
        arriving, mass = arrivals[ARRIVING, k], tops[MASS, side]
        if mass > 0.0:
            face = state[interface.heavy + side]
        else:
            face = tops[DRIVEN, side] * change + tops[YIELDING, side] * (state[load + side] - arriving)
        slip = change - face
        rates[at + load + side] = tops[SPRING, side] * slip
        traction = facts[IMPEDANCE, k] * (arriving + facts[STIFFENED, k] * face)
        if mass > 0.0:
            pull = facts[IMPEDANCE, k] * state[load + side] + tops[DASHPOT, side] * slip
            rates[at + interface.heavy + side] = (pull - traction) / mass
            traction = pull
        power += (forcing.steady_stress + traction) * (0.5 * drive) - tops[DEAD, side] * forcing.steady_stress * slip
        lost += tops[DASHPOT, side] * slip * slip
        arrivals[JUMP, k] = face - state[slots[VELOCITY, k]]
    scale = interface.copies * forcing.transit
    rates[at + interface.size + INPUT] = scale * power
    rates[at + interface.size + RADIATED] = scale * lost


@inlined
def _evolve(interface: Interface, forcing: Forcing, time: float, z: float, psi: float) -> tuple[float, float]:
    """(d psi/dt~, relaxation rate of psi), per transit, including the nudge."""
    answer = respond(interface.law, z, psi)
    return forcing.transit * answer[5] + nudge_rate(forcing.nudge, time), forcing.transit * abs(answer[7])


@inlined
def rates_of(
    operator: Operator,
    medium: Medium,
    interface: Interface,
    forcing: Forcing,
    drive: Constant | Ramps,
    slots: NDArray[np.int64],
    facts: Array,
    tops: Array,
    arrivals: Array,
    time: float,
    state: Array,
    rates: Array,
    at: int,
    z: float,
) -> tuple[float, float, float, int]:
    """rates[at:] = d state/dt~ at `time` (transits). Returns (z, mu, state relaxation per transit, iterations of the solve)."""
    size, traces = interface.size, arrivals.shape[1]
    velocity = velocity_at(drive, time, time)
    apply(operator, state, rates, at)
    for k in range(traces):
        stress = total_stress(medium, slots[STRESS, k], state, rates, at)
        arrivals[ARRIVING, k] = stress - facts[SIGN, k] * facts[STIFFENED, k] * state[slots[VELOCITY, k]]
    _meet_joints(interface.joints, slots, facts, state, arrivals)
    _meet_tops(interface, forcing, slots, facts, tops, velocity, state, rates, at, arrivals)
    z, v, mu, iterations = _meet_interface(interface, forcing, slots, facts, state, z, arrivals)
    for k in range(traces):
        rates[at + slots[STRESS, k]] += facts[SIGN, k] * facts[LIFT, k] * arrivals[JUMP, k]
    retard(medium, operator, size, state, rates, at)
    for k in range(traces):
        rates[at + slots[VELOCITY, k]] += facts[LIFT, k] * arrivals[JUMP, k]
    finish(operator, rates, at)
    rates[at + size + VISCOUS] = interface.copies * forcing.transit * dissipate(medium, size, state, rates, at)
    rates[at + size + FRICTION] = forcing.transit * mu * v
    rates[at + size + ELASTIC] = forcing.stiffness * (velocity - v)
    rates[at + size + PSI], relaxation = _evolve(interface, forcing, time, z, state[size + PSI])
    return z, mu, relaxation, iterations
