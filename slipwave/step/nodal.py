"""Data of one collocation step of friction (values at its nodes, limits), and its parts other than Newton's method
(`slipwave.step.newton`): first guess, nudge, acceptance."""

import math
from functools import cache
from typing import NamedTuple, Protocol, cast

import numpy as np

from slipwave.compiled import inlined, njit
from slipwave.friction import Law
from slipwave.observe.pieces import Array
from slipwave.scene.drive import Constant, Forcing, Ramps, nudge_rate, velocity_at
from slipwave.step.collocation import Nodes, Rule

DONE, NOT_SOLVED, NOT_SMOOTH, TOO_STEEP = range(4)
"""Verdicts on a step."""

TIME, PSI, ELASTIC = range(3)
"""Entries of a march's `now`: transits since the start, psi, elastic stress."""


class Interface(NamedTuple):
    """`psi` and rate unknown `z` (s,) at the nodes of a step."""

    psi: Array
    z: Array


class Nodal(Protocol):
    """Values (s,) at the nodes of a step. Given: `incoming` stress S; `left`, psi at the step's start and the integral of the
    nudge; the `drive` V. Solved for: `psi`, `z` of the law of the step, and the slip rate `v`.

    Of the linearised step: `v_z`; `inverse`, 1/(F_z + K_jj v_z); `mismatch` of the stress and `ratio`, F_psi, times that;
    `by_z`, h G_z; `slope`, h dG/dpsi at given stress; `change` of psi. `missed`: what `left` contains because v changes its sign
    (`slipwave.step.newton`). Scratch: `gain`, `stress`, `trial`, `state` (s, 2 s + 1),
    `rate` (s, s + 1).

    It is a numpy record (`nodal_of`): compiled code then knows that no two of its arrays overlap."""

    incoming: Array
    left: Array
    drive: Array
    psi: Array
    z: Array
    v: Array
    v_z: Array
    inverse: Array
    mismatch: Array
    ratio: Array
    by_z: Array
    slope: Array
    change: Array
    missed: Array
    gain: Array
    stress: Array
    trial: Array
    state: Array
    rate: Array


class Physics(NamedTuple):
    """Law, nudge, drive and collocation rule of a march."""

    law: Law
    forcing: Forcing
    drive: Constant | Ramps
    rule: Rule


class Limits(NamedTuple):
    """`newton` and `resolution`: allowed error of the iteration and highest Legendre coefficient of a step; `growth`: largest
    growth of a disturbance, as an exponent, that a step reproduces; `swing`: largest angle of one that may grow."""

    newton: float
    resolution: float
    growth: float
    swing: float = math.inf


def nodal_of(stages: int) -> Nodal:
    """Values of a step of `stages` nodes, zero."""
    return cast(Nodal, np.zeros(1, dtype=_kind_of(stages))[0])


@cache
def _kind_of(stages: int) -> np.dtype[np.void]:
    shapes = {"state": (stages, 2 * stages + 1), "rate": (stages, stages + 1)}
    kind = np.dtype([(name, np.float64, shapes.get(name, (stages,))) for name in Nodal.__annotations__], align=True)
    return np.dtype((np.record, kind))  # a record's fields are its attributes too


def constant_guess(psi: float, z: float, stages: int) -> Interface:
    """The same values at all nodes."""
    return Interface(np.full(stages, psi), np.full(stages, z))


@inlined
def begin_step(nodes: Nodes, physics: Physics, start: float, length: float, psi: float, nodal: Nodal) -> None:
    """nodal.drive <- V, and nodal.left <- `psi` at the step's start and the integral of the nudge from there, outside the Newton
    loop, which it would slow down by a quarter."""
    s, nudge, integral = len(nodes), physics.forcing.nudge, physics.rule.integral
    for j in range(s):
        nodal.drive[j] = velocity_at(physics.drive, start + nodes[j] * length, start + 0.5 * length)
        nodal.left[j] = psi
    if nudge != 0.0:
        for k in range(s):
            gain = length * nudge_rate(nudge, start + nodes[k] * length)
            for j in range(s):
                nodal.left[j] += integral[k, j] * gain


@inlined
def tail_of(nodes: Nodes, tail: Array, values: Array) -> float:
    """Highest Legendre coefficient of the polynomial with these nodal `values`."""
    coefficient = 0.0
    for j in range(len(nodes)):
        coefficient += tail[j] * values[j]
    return coefficient


@inlined
def judge_step(nodes: Nodes, tail: Array, nodal: Nodal, used: int, limits: Limits) -> int:
    """NOT_SOLVED if `used`, Newton's iterations, is 0. NOT_SMOOTH if the highest Legendre coefficient of z in the step is above
    the resolution. TOO_STEEP if a disturbance would grow by more than e^growth within the step (by the slopes of the linearised
    step): an implicit step damps such growth and would follow an unstable smooth solution. Otherwise DONE."""
    growth = 0.0
    for j in range(len(nodes)):
        growth = max(growth, nodal.slope[j])
    if used == 0:
        return NOT_SOLVED
    if not abs(tail_of(nodes, tail, nodal.z)) <= limits.resolution:
        return NOT_SMOOTH
    return TOO_STEEP if growth > limits.growth else DONE


@njit
def predict(nodes: Nodes, rule: Rule, ratio: int, left: float, last: Interface, guess: Interface) -> None:
    """Guess of a step: the polynomials of the `last` one, at whose start psi was `left`, extrapolated. RATIOS[`ratio`]: its
    length over that of the one before."""
    s = len(nodes)
    for j in range(s):
        guess.psi[j] = rule.predict_state[ratio, 0, j] * left
        guess.z[j] = 0.0
    for k in range(s):
        psi, z = last.psi[k], last.z[k]
        for j in range(s):
            guess.psi[j] += rule.predict_state[ratio, k + 1, j] * psi
            guess.z[j] += rule.predict[ratio, k, j] * z


@njit
def hold(nodes: Nodes, psi: float, z: float, guess: Interface) -> None:
    """guess <- the values at a step's end, for a next step of another length."""
    for j in range(len(nodes)):
        guess.psi[j], guess.z[j] = psi, z
