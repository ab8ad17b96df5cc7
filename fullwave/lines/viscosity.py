"""What viscosity adds to the equations of motion (`fullwave.lines.system`); in elastic slabs, nothing."""

from fullwave.lines.system import SCALARS, Elastic, Viscous, apply, dissipate, retard, total_stress
from slipwave.compiled.dispatch import dispatch


def _elastic_stress(medium, slot, state, rates, at):  # type: ignore[no-untyped-def]
    return state[slot]


def _viscous_stress(medium, slot, state, rates, at):  # type: ignore[no-untyped-def]
    return state[slot] + medium.retardation[slot] * rates[at + slot]


def _elastic_retard(medium, operator, size, state, rates, at):  # type: ignore[no-untyped-def]
    return None


def _viscous_retard(medium, operator, size, state, rates, at):  # type: ignore[no-untyped-def]
    total, spare, retardation, is_velocity = medium.total, medium.spare, medium.retardation, medium.is_velocity
    for i in range(size):
        total[i] = state[i] + retardation[i] * rates[at + i]
    apply(operator, total, spare, 0)
    for i in range(size):
        if is_velocity[i]:
            rates[at + i] = spare[i]


def _elastic_dissipate(medium, size, state, rates, at):  # type: ignore[no-untyped-def]
    return 0.0


def _viscous_dissipate(medium, size, state, rates, at):  # type: ignore[no-untyped-def]
    weight, rate, fraction, retardation = medium.weight, medium.rate, medium.fraction, medium.retardation
    lost = 0.0
    memory = size + SCALARS
    for i in range(size):
        lost += weight[i] * retardation[i] * rates[at + i] * rates[at + i]
        rates[at + memory + i] = 0.0
        if rate[i] > 0.0:
            flow = rate[i] * state[memory + i]
            rates[at + memory + i] = fraction[i] * rates[at + i] - flow
            rates[at + i] -= flow
            lost += weight[i] * flow * state[memory + i] / fraction[i]
    return lost


dispatch(total_stress, {Elastic: _elastic_stress, Viscous: _viscous_stress})
dispatch(retard, {Elastic: _elastic_retard, Viscous: _viscous_retard})
dispatch(dissipate, {Elastic: _elastic_dissipate, Viscous: _viscous_dissipate})
