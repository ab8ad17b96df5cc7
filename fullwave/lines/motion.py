"""Time derivative of a `System`: the one right-hand side that every Runge-Kutta stage of every family evaluates.

`rates` is flat: a stage's values begin at index `at`. `arrivals` is scratch.
"""

import math

import numpy as np
from numpy.typing import NDArray

import fullwave.lines.viscosity  # noqa: F401  (registers what the compiled calls below are bound to)
from fullwave.leapfrog.drives import Constant, Ramps, velocity_at
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
    PSI,
    RADIATED,
    SIGN,
    SPRING,
    STIFFENED,
    STRESS,
    VELOCITY,
    VISCOUS,
    YIELDING,
    Elastic,
    Interface,
    Operator,
    Viscous,
    apply,
    dissipate,
    finish,
    retard,
    total_stress,
)
from slipwave.compiled import inlined
from slipwave.friction import respond
from slipwave.friction.interface import solve_interface
from slipwave.observe.pieces import Array
from slipwave.scene.start import NUDGE_CENTRE

_NUDGE_REACH = 7.0  # transits; exp(-49) is beyond rounding


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
    interface: Interface, slots: NDArray[np.int64], facts: Array, state: Array, z: float, arrivals: Array
) -> tuple[float, float, float, int]:
    """Friction solve at the interface: (z, v, mu, iterations); w* - w of each slab."""
    first = 2 * interface.joints
    free = interface.velocity
    for k in range(first, first + interface.sides):
        free += interface.copies * arrivals[ARRIVING, k] / facts[STIFFENED, k]
    incoming = interface.steady_stress + interface.impedance * free
    psi = state[interface.size + PSI]
    z, iterations = solve_interface(interface.law, interface.impedance, incoming, psi, z)
    v = respond(interface.law, z, psi)[0]
    change = interface.impedance * (free - v)
    for k in range(first, first + interface.sides):
        own = (arrivals[ARRIVING, k] - change / facts[IMPEDANCE, k]) / facts[STIFFENED, k]
        arrivals[JUMP, k] = own - state[slots[VELOCITY, k]]
    return z, v, interface.steady_stress + change, iterations


@inlined
def _meet_tops(
    interface: Interface,
    slots: NDArray[np.int64],
    facts: Array,
    tops: Array,
    drive: float,
    state: Array,
    rates: Array,
    at: int,
    arrivals: Array,
) -> None:
    """w* - w at the outer faces, driven at half of `drive` each; rates of the grips' loads, of the input and of the radiation."""
    first, load = 2 * interface.joints + interface.sides, interface.size + GRIP
    steady = 0.5 * interface.velocity
    change = 0.5 * drive - steady
    power = lost = 0.0
    for side in range(interface.sides):
        k = first + side
        arriving = arrivals[ARRIVING, k]
        face = tops[DRIVEN, side] * change + tops[YIELDING, side] * (state[load + side] - arriving)
        slip = change - face
        rates[at + load + side] = tops[SPRING, side] * slip
        traction = facts[IMPEDANCE, k] * (arriving + facts[STIFFENED, k] * face)
        power += (interface.steady_stress + traction) * (0.5 * drive) - tops[DEAD, side] * interface.steady_stress * slip
        lost += tops[DASHPOT, side] * slip * slip
        arrivals[JUMP, k] = face - state[slots[VELOCITY, k]]
    scale = interface.copies * interface.transit
    rates[at + interface.size + INPUT] = scale * power
    rates[at + interface.size + RADIATED] = scale * lost


@inlined
def _evolve(interface: Interface, time: float, z: float, psi: float) -> tuple[float, float]:
    """(d psi/dt~, relaxation rate of psi), per transit, the nudge of a smooth start included."""
    answer = respond(interface.law, z, psi)
    growth = interface.transit * answer[5]
    late = time - NUDGE_CENTRE
    if interface.nudge != 0.0 and abs(late) < _NUDGE_REACH:
        growth += interface.nudge * math.exp(-late * late)
    return growth, interface.transit * abs(answer[7])


@inlined
def rates_of(
    operator: Operator,
    medium: Elastic | Viscous,
    interface: Interface,
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
    velocity = velocity_at(drive, time)
    apply(operator, state, rates, at)
    for k in range(traces):
        stress = total_stress(medium, slots[STRESS, k], state, rates, at)
        arrivals[ARRIVING, k] = stress - facts[SIGN, k] * facts[STIFFENED, k] * state[slots[VELOCITY, k]]
    _meet_joints(interface.joints, slots, facts, state, arrivals)
    _meet_tops(interface, slots, facts, tops, velocity, state, rates, at, arrivals)
    z, v, mu, iterations = _meet_interface(interface, slots, facts, state, z, arrivals)
    for k in range(traces):
        rates[at + slots[STRESS, k]] += facts[SIGN, k] * facts[LIFT, k] * arrivals[JUMP, k]
    retard(medium, operator, size, state, rates, at)
    for k in range(traces):
        rates[at + slots[VELOCITY, k]] += facts[LIFT, k] * arrivals[JUMP, k]
    finish(operator, rates, at)
    rates[at + size + VISCOUS] = interface.copies * interface.transit * dissipate(medium, size, state, rates, at)
    rates[at + size + FRICTION] = interface.transit * mu * v
    rates[at + size + ELASTIC] = interface.stiffness * (velocity - v)
    rates[at + size + PSI], relaxation = _evolve(interface, time, z, state[size + PSI])
    return z, mu, relaxation, iterations
