"""The terms that viscosity adds to the equations of motion (`fullwave.lines.system`); in elastic slabs there are none."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fullwave.lines.system import SCALARS, Operator, apply
from slipwave.compiled.dispatch import by_class
from slipwave.observe.pieces import Array


class Elastic(NamedTuple):
    """No viscosity: none of its terms are compiled."""

    nothing: float = 0.0


class Viscous(NamedTuple):
    """Per slot of the grid (size,): energy weight eps h, relaxation rate and relaxed fraction (standard linear, else 0), tau
    (Kelvin-Voigt, else 0), True at velocity slots; scratch for the total stress and its derivative."""

    weight: Array
    rate: Array
    fraction: Array
    retardation: Array
    is_velocity: NDArray[np.bool_]
    total: Array
    spare: Array


@by_class()
def total_stress(medium: Elastic | Viscous, slot: int, state: Array, rates: Array, at: int) -> float:
    """s + tau s_t at a stress slot, before the faces' terms (s in elastic slabs)."""
    raise NotImplementedError(type(medium))


@by_class()
def retard(medium: Elastic | Viscous, operator: Operator, size: int, state: Array, rates: Array, at: int) -> None:
    """Kelvin-Voigt: replace D s in the velocity slots by D (s + tau s_t)."""
    raise NotImplementedError(type(medium))


@by_class()
def dissipate(medium: Elastic | Viscous, size: int, state: Array, rates: Array, at: int) -> float:
    """Sets the rates of the memory stresses (standard linear); returns the dissipated power in the marched slabs, per transit."""
    raise NotImplementedError(type(medium))


@total_stress.register(Elastic)
def _elastic_stress(medium, slot, state, rates, at):  # type: ignore[no-untyped-def]
    return state[slot]


@total_stress.register(Viscous)
def _viscous_stress(medium, slot, state, rates, at):  # type: ignore[no-untyped-def]
    return state[slot] + medium.retardation[slot] * rates[at + slot]


@retard.register(Elastic)
def _elastic_retard(medium, operator, size, state, rates, at):  # type: ignore[no-untyped-def]
    return None


@retard.register(Viscous)
def _viscous_retard(medium, operator, size, state, rates, at):  # type: ignore[no-untyped-def]
    total, spare, retardation, is_velocity = medium.total, medium.spare, medium.retardation, medium.is_velocity
    for i in range(size):
        total[i] = state[i] + retardation[i] * rates[at + i]
    apply(operator, total, spare, 0)
    for i in range(size):
        if is_velocity[i]:
            rates[at + i] = spare[i]


@dissipate.register(Elastic)
def _elastic_dissipate(medium, size, state, rates, at):  # type: ignore[no-untyped-def]
    return 0.0


@dissipate.register(Viscous)
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
