"""Time derivative of a `System`: the right-hand side that every Runge-Kutta stage of every family evaluates.

`rates` is flat: a stage's values begin at index `at`.
"""

from fullwave.lines.system import (
    ELASTIC,
    FRICTION,
    GRIP,
    INPUT,
    PSI,
    RADIATED,
    VISCOUS,
    GridInterface,
    System,
    Tops,
    Traces,
    apply,
    dissipate,
    retard,
    total_stress,
)
from slipwave.compiled import inlined
from slipwave.friction import respond
from slipwave.friction.interface import solve_interface
from slipwave.observe.pieces import Array
from slipwave.scene.drive import Forcing, nudge_rate, velocity_at


@inlined
def _meet_joints(joints: int, traces: Traces, state: Array) -> None:
    """w* - w on both sides of each joint, from continuity of velocity and stress."""
    for near in range(0, 2 * joints, 2):
        far = near + 1
        pull = traces.impedance[far] * traces.arriving[far] - traces.impedance[near] * traces.arriving[near]
        both = traces.impedance[far] * traces.stiffened[far] + traces.impedance[near] * traces.stiffened[near]
        common = pull / both
        traces.jump[near] = common - state[traces.velocity[near]]
        traces.jump[far] = common - state[traces.velocity[far]]


@inlined
def _meet_interface(
    interface: GridInterface, forcing: Forcing, traces: Traces, state: Array, z: float
) -> tuple[float, float, float, int]:
    """Friction solve at the interface: returns (z, v, mu, iterations) and sets w* - w of each slab."""
    first = 2 * interface.joints
    free = forcing.velocity
    for k in range(first, first + interface.sides):
        free += interface.copies * traces.arriving[k] / traces.stiffened[k]
    incoming = forcing.steady_stress + interface.impedance * free
    psi = state[interface.size + PSI]
    z, iterations = solve_interface(interface.law, interface.impedance, incoming, psi, z)
    v = respond(interface.law, z, psi)[0]
    change = interface.impedance * (free - v)
    for k in range(first, first + interface.sides):
        own = (traces.arriving[k] - change / traces.impedance[k]) / traces.stiffened[k]
        traces.jump[k] = own - state[traces.velocity[k]]
    return z, v, forcing.steady_stress + change, iterations


@inlined
def _meet_tops(
    interface: GridInterface, forcing: Forcing, traces: Traces, tops: Tops, drive: float, state: Array, rates: Array, at: int
) -> None:
    """Sets w* - w at the outer faces, each driven at half of `drive`, and the rates of the springs' loads, of heavy faces'
    velocities, of the input and of the radiation."""
    first, load = 2 * interface.joints + interface.sides, interface.size + GRIP
    steady = 0.5 * forcing.velocity
    change = 0.5 * drive - steady
    power = lost = 0.0
    for side in range(interface.sides):
        k = first + side
        arriving, mass = traces.arriving[k], tops.mass[side]
        if mass > 0.0:
            face = state[interface.heavy + side]
        else:
            face = tops.driven[side] * change + tops.yielding[side] * (state[load + side] - arriving)
        slip = change - face
        rates[at + load + side] = tops.spring[side] * slip
        traction = traces.impedance[k] * (arriving + traces.stiffened[k] * face)
        if mass > 0.0:
            pull = traces.impedance[k] * state[load + side] + tops.dashpot[side] * slip
            rates[at + interface.heavy + side] = (pull - traction) / mass
            traction = pull
        power += (forcing.steady_stress + traction) * (0.5 * drive) - tops.dead[side] * forcing.steady_stress * slip
        lost += tops.dashpot[side] * slip * slip
        traces.jump[k] = face - state[traces.velocity[k]]
    scale = interface.copies * forcing.transit
    rates[at + interface.size + INPUT] = scale * power
    rates[at + interface.size + RADIATED] = scale * lost


@inlined
def _evolve(interface: GridInterface, forcing: Forcing, time: float, z: float, psi: float) -> tuple[float, float]:
    """(d psi/dt~, relaxation rate of psi), per transit, including the nudge."""
    answer = respond(interface.law, z, psi)
    return forcing.transit * answer[5] + nudge_rate(forcing.nudge, time), forcing.transit * abs(answer[7])


@inlined
def rates_of(system: System, time: float, state: Array, rates: Array, at: int, z: float) -> tuple[float, float, float, int]:
    """rates[at:] = d state/dt~ at `time` (transits). Returns (z, mu, state relaxation per transit, iterations of the solve)."""
    operator, medium, interface, forcing = system.operator, system.medium, system.interface, system.forcing
    traces, size, ends = system.traces, system.interface.size, system.traces.lift.size
    velocity = velocity_at(system.drive, time, time)
    apply(operator, state, rates, at)
    for k in range(ends):
        stress = total_stress(medium, traces.stress[k], state, rates, at)
        traces.arriving[k] = stress - traces.sign[k] * traces.stiffened[k] * state[traces.velocity[k]]
    _meet_joints(interface.joints, traces, state)
    _meet_tops(interface, forcing, traces, system.tops, velocity, state, rates, at)
    z, v, mu, iterations = _meet_interface(interface, forcing, traces, state, z)
    for k in range(ends):
        rates[at + traces.stress[k]] += traces.sign[k] * traces.lift[k] * traces.jump[k]
    retard(medium, operator, size, state, rates, at)
    for k in range(ends):
        rates[at + traces.velocity[k]] += traces.lift[k] * traces.jump[k]
    rates[at + size + VISCOUS] = interface.copies * forcing.transit * dissipate(medium, size, state, rates, at)
    rates[at + size + FRICTION] = forcing.transit * mu * v
    rates[at + size + ELASTIC] = forcing.stiffness * (velocity - v)
    rates[at + size + PSI], relaxation = _evolve(interface, forcing, time, z, state[size + PSI])
    return z, mu, relaxation, iterations
