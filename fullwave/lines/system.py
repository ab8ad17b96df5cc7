"""The semi-discrete equations of motion, the same for every family that is marched by the method of lines.

A slab is divided into blocks. Depth is travel time x (transits of the upper slab) from the interface. Velocity w and scaled
stress s = sigma/eps are deviations from steady sliding, each in the slab's own direction of drive, so that in both slabs

    w_t = s_x,    s_t = w_x    (d'Alembert's pair),       v = w_upper + w_lower at the interface.

A block has a summation-by-parts operator D = H^-1 Q, Q + Q^T = diag(-1, 0, .., 0, 1) (`apply`: discontinuous Galerkin, finite
difference or finite element). It is coupled at both ends only through the characteristic states w* of its faces:

    w_t = D s + sum_ends l (w* - w),     s_t = D w +- l (w* - w)     (+ at the end away from the interface).

l = H^-1 e with the unit vector e of the end. It is 1/h_0 at the end node if h_0 is the only entry of its row in H (a diagonal
norm, or the restricted full norm of the differences). With the stress s* = s +- (w* - w) that belongs to w*, the energy
eps (w.H w + s.H s)/2 then changes by

    sum_ends +- eps s* w* - eps (w - w*)^2,

the power from outside minus the dissipation by upwinding. So energy does not grow by itself, and the stiffness of friction does
not enter the step limit. There are three kinds of ends, all solved for w* from the characteristic o = s -+ w that arrives
(MODEL.md section 3):
    joint      between two blocks: stress and velocity are continuous;
    interface  one scalar friction solve (`slipwave.friction.interface`) for both slabs;
    top        rigid, spring or dashpot: w* = A V + B (y_g - o); with a mass on the face, w* is a state of its own.

Viscosity. Standard linear: a memory stress m per node, s_t = D w + ... - rate m, m_t = fraction (D w + ...) - rate m.
Kelvin-Voigt: s is the elastic part and s + tau s_t the stress; the impedance at an end gets the factor 1 + tau l, which accounts
for the dependence of the end's strain rate on w*.

The terms that viscosity adds to the equations of motion (`fullwave.lines.system`); in elastic slabs there are none.
"""

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled.dispatch import by_class
from slipwave.friction import Law
from slipwave.observe.pieces import Array
from slipwave.scene.drive import Constant, Forcing, Ramps

Operator: TypeAlias = Any
"""An instance of a family's operator class (a NamedTuple)."""

Medium: TypeAlias = Any
"""What viscosity adds: an instance of `viscosity.Elastic` or `viscosity.Viscous`."""

# scalars after the grid values, integrated by the same Runge-Kutta method (GRIP: one load per slab); their number SCALARS is a
# multiple of panels.LANES
PSI, ELASTIC, GRIP, INPUT, FRICTION, RADIATED, VISCOUS, SCALARS = 0, 1, 2, 4, 5, 6, 7, 8


class Traces(NamedTuple):
    """The ends of all blocks (traces,): the joints' ends in pairs (near the interface, far), those at the interface, those at the
    tops. Slots of their `velocity` and `stress`; l; -1 at a near end and 1 at a far one; 1 + tau l; eps. Scratch: the arriving
    characteristic over eps, and w* - w."""

    velocity: NDArray[np.int64]
    stress: NDArray[np.int64]
    lift: Array
    sign: Array
    stiffened: Array
    impedance: Array
    arriving: Array
    jump: Array


class OuterFaces(NamedTuple):
    """The outer faces of the marched slabs (sides,): A and B of w* = A V + B (y_g - o); spring over impedance (per transit);
    dashpot Z_g in units of stress/V*; 1 if the steady load acts on the face itself (no spring); mass in units of stress/V* times
    a transit."""

    driven: Array
    yielding: Array
    spring: Array
    dashpot: Array
    dead: Array
    mass: Array


class GridInterface(NamedTuple):
    """Law, Z, copies (2 if only one slab is marched); joints, marched slabs and slots of the grid; `heavy`: the slot, after all
    others, of w* at the first slab's face (one slot per slab); 0 if no face has a mass."""

    law: Law
    impedance: float
    copies: float
    joints: int
    sides: int
    size: int
    heavy: int


class System(NamedTuple):
    """All data of the compiled march."""

    operator: Operator
    medium: Medium
    interface: GridInterface
    forcing: Forcing
    drive: Constant | Ramps
    traces: Traces
    tops: OuterFaces


@by_class()
def apply(operator: Operator, state: Array, rates: Array, at: int) -> None:
    """rates[at + velocity slots] = D s, rates[at + stress slots] = D w."""
    raise NotImplementedError(type(operator))


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
def total_stress(medium: Any, slot: int, state: Array, rates: Array, at: int) -> float:
    """s + tau s_t at a stress slot, before the faces' terms (s in elastic slabs)."""
    return float(state[slot] + medium.retardation[slot] * rates[at + slot])


@by_class()
def retard(medium: Any, operator: Operator, size: int, state: Array, rates: Array, at: int) -> None:
    """Kelvin-Voigt: replace D s in the velocity slots by D (s + tau s_t)."""
    total, spare, retardation, is_velocity = medium.total, medium.spare, medium.retardation, medium.is_velocity
    for i in range(size):
        total[i] = state[i] + retardation[i] * rates[at + i]
    apply(operator, total, spare, 0)
    for i in range(size):
        if is_velocity[i]:
            rates[at + i] = spare[i]


@by_class()
def dissipate(medium: Any, size: int, state: Array, rates: Array, at: int) -> float:
    """Sets the rates of the memory stresses (standard linear); returns the dissipated power in the marched slabs, per transit."""
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


@total_stress.register(Elastic)
def _elastic_stress(medium, slot, state, rates, at):  # type: ignore[no-untyped-def]
    return state[slot]


@retard.register(Elastic)
def _elastic_retard(medium, operator, size, state, rates, at):  # type: ignore[no-untyped-def]
    return None


@dissipate.register(Elastic)
def _elastic_dissipate(medium, size, state, rates, at):  # type: ignore[no-untyped-def]
    return 0.0
