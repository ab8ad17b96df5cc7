"""The semi-discrete equations of motion, written once for every family that is marched by the method of lines.

A slab is cut into blocks. Depth is travel time x (transits of the upper slab) from the interface, velocity w and scaled stress
s = sigma/eps are deviations from steady sliding, each in the slab's own direction of drive, so that in either slab

    w_t = s_x,    s_t = w_x    (d'Alembert's pair),       v = w_upper + w_lower at the interface.

A block answers with a summation-by-parts operator D = H^-1 Q, Q + Q^T = diag(-1, 0, .., 0, 1) (`apply`: discontinuous Galerkin,
finite difference or finite element), and is held at both ends only through the characteristic states w* of its faces:

    w_t = D s + sum_ends l (w* - w),     s_t = D w +- l (w* - w)     (+ at the end away from the interface).

l = H^-1 e, e the unit vector of the end: 1/h_0 at the end node where h_0 stands alone in H (a diagonal norm, or the differences'
restricted full one); a consistent mass spreads it over the block (`finish`). With s* = s +- (w* - w), the stress that belongs to
w*, the energy eps (w.H w + s.H s)/2 then changes by

    sum_ends +- eps s* w* - eps (w - w*)^2,

the power of what is outside less what upwinding takes: nothing grows, and no friction stiffness enters the step limit.
Three kinds of face, all solved for w* from the characteristic o = s -+ w that arrives at them (MODEL.md section 3):
    joint      between two blocks: stress and velocity continuous;
    interface  one scalar friction solve (scene.interface) for both slabs;
    top        rigid, grip or bare reflection: w* = A V + B (y_g - o).

Viscosity. Standard linear: a memory stress m per node, s_t = D w + ... - rate m, m_t = fraction (D w + ...) - rate m.
Kelvin-Voigt: s is the elastic part and s + tau s_t the stress; the ends' impedances gain the factor 1 + tau l, which solves for
w* and the end's own strain rate together.
"""

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fullwave.leapfrog.drives import Constant, Ramps
from slipwave.compiled.dispatch import dispatch
from slipwave.friction import Law
from slipwave.observe.pieces import Array

Operator: TypeAlias = Any
"""An instance of a family's operator class (a NamedTuple)."""

# scalars carried behind the grid values, integrated by the same Runge-Kutta method (GRIP: one load per slab); SCALARS of them,
# a multiple of panels.LANES
PSI, ELASTIC, GRIP, INPUT, FRICTION, RADIATED, VISCOUS, SCALARS = 0, 1, 2, 4, 5, 6, 7, 8

# rows of `System.slots` and `System.facts`, one column per trace (an end of a block): first the joints' ends in pairs (near the
# interface, far), then the ends at the interface, then those at the tops. LIFT is l, SIGN -1 at a near end and 1 at a far one,
# STIFFENED 1 + tau l
VELOCITY, STRESS = 0, 1
LIFT, SIGN, STIFFENED, IMPEDANCE = 0, 1, 2, 3

# rows of `System.tops`, one column per slab: A and B of w* = A V + B (y_g - o); spring over impedance (per transit); dashpot Z_g
# in units of stress/V*; 1 where the steady load hangs on the face itself (a bare reflection coefficient)
DRIVEN, YIELDING, SPRING, DASHPOT, DEAD = 0, 1, 2, 3, 4

# rows of `System.arrivals` (scratch), one column per trace: the characteristic that arrives over eps, and w* - w
ARRIVING, JUMP = 0, 1


class Elastic(NamedTuple):
    """No viscosity anywhere: nothing of it is compiled in."""

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


class Interface(NamedTuple):
    """Law, Z, stress and slip rate of steady sliding, copies (2 when one slab stands for both), one transit on the friction
    clock, stiffness of both slabs per transit, nudge size; joints, marched slabs and slots of the grid."""

    law: Law
    impedance: float
    steady_stress: float
    velocity: float
    copies: float
    transit: float
    stiffness: float
    nudge: float
    joints: int
    sides: int
    size: int


class System(NamedTuple):
    """Everything the compiled march needs to know. Arrays reach the inner functions as arguments of their own: taken out of a
    tuple there, each would be counted in and out at every call, which was measured to cost more than the arithmetic."""

    operator: Operator
    medium: Elastic | Viscous
    interface: Interface
    drive: Constant | Ramps
    slots: NDArray[np.int64]
    facts: Array
    tops: Array
    arrivals: Array


def apply(operator: Operator, state: Array, rates: Array, at: int) -> None:
    """rates[at + velocity slots] = D s, rates[at + stress slots] = D w (before `finish`)."""
    raise NotImplementedError(type(operator))


def finish(operator: Operator, rates: Array, at: int) -> None:
    """Complete the rates once the faces' terms are in (a consistent mass matrix is solved here)."""
    raise NotImplementedError(type(operator))


def nothing_left(operator: Operator, rates: Array, at: int) -> None:
    """`finish` of an operator whose norm is diagonal."""


def total_stress(medium: Elastic | Viscous, slot: int, state: Array, rates: Array, at: int) -> float:
    """s + tau s_t at a stress slot, before the faces' terms (s in elastic slabs)."""
    raise NotImplementedError(type(medium))


def retard(medium: Elastic | Viscous, operator: Operator, size: int, state: Array, rates: Array, at: int) -> None:
    """Kelvin-Voigt: replace D s in the velocity slots by D (s + tau s_t)."""
    raise NotImplementedError(type(medium))


def dissipate(medium: Elastic | Viscous, size: int, state: Array, rates: Array, at: int) -> float:
    """Rates of the memory stresses (standard linear), and the power turned into heat in the marched slabs, over one transit."""
    raise NotImplementedError(type(medium))


_APPLY: dict[type, Any] = {}
_FINISH: dict[type, Any] = {}
dispatch(apply, _APPLY)
dispatch(finish, _FINISH)


def register_operator(kind: type, apply: Any, finish: Any = nothing_left) -> None:
    """Let the compiled march know a family's operator class."""
    _APPLY[kind] = apply
    _FINISH[kind] = finish
