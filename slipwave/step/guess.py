"""Parts of a collocation step of the delay system besides its Newton iteration: the first guess, the nudge, and the verdict on
the step. See `slipwave.step.rows` for the rows of `guess` and `work`."""

from slipwave.compiled import inlined, njit
from slipwave.friction import Law
from slipwave.friction.interface import solve_interface
from slipwave.observe.pieces import Array
from slipwave.scene.start import nudge_rate
from slipwave.step.collocation import Nodes, Rule
from slipwave.step.rows import FORCED, SLOPE, STATE, UNKNOWN

DONE, NOT_SOLVED, NOT_SMOOTH, TOO_STEEP = range(4)
"""Verdicts on a step."""


@njit
def first_guess(law: Law, impedance: float, incoming: Array, psi: float, z: float, guess: Array) -> int:
    """Nodal z for constant psi; returns the number of unconverged solves. Used where there is no earlier step to extend."""
    failures = 0
    for j in range(guess.size):
        z, iterations = solve_interface(law, impedance, incoming[j], psi, z)
        guess[j] = z
        failures += iterations == 0
    return failures


@njit
def force(nodes: Nodes, nudge: float, start: float, length: float, integral: Array, work: Array) -> None:
    """work[FORCED] <- integral of the nudge from the step's start to each node; done outside the Newton loop, which it would slow
    down by a quarter."""
    for j in range(len(nodes)):
        work[FORCED, j] = 0.0
    for k in range(len(nodes)):
        gain = length * nudge_rate(nudge, start + nodes[k] * length)
        if gain != 0.0:
            for j in range(len(nodes)):
                work[FORCED, j] += integral[k, j] * gain


@inlined
def judge_step(nodes: Nodes, tail: Array, guess: Array, work: Array, used: int, resolution: float, steepest: float) -> int:
    """NOT_SOLVED if `used`, Newton's iterations, is 0. NOT_SMOOTH if the highest Legendre coefficient of z in the step (`tail`
    times the nodal values) is above `resolution`. TOO_STEEP if a disturbance would grow by more than e^`steepest` within the step
    (by the slopes of the linearised step): an implicit step damps such growth, so that it would follow an unstable smooth
    solution. Otherwise DONE."""
    coefficient, growth = 0.0, 0.0
    for j in range(len(nodes)):
        coefficient += tail[j] * guess[UNKNOWN, j]
        growth = max(growth, work[SLOPE, j])
    if used == 0:
        return NOT_SOLVED
    if not abs(coefficient) <= resolution:
        return NOT_SMOOTH
    return TOO_STEEP if growth > steepest else DONE


@inlined
def predict(nodes: Nodes, rule: Rule, ratio: int, left: float, last: Array, guess: Array) -> None:
    """Guess of a step from the nodal values `last` of the one before, at whose start psi was `left`: their polynomials, extended.
    RATIOS[`ratio`]: its length over that of the one before."""
    s = len(nodes)
    for j in range(s):
        guess[STATE, j] = rule.predict_state[ratio, 0, j] * left
        guess[UNKNOWN, j] = 0.0
    for k in range(s):
        psi, z = last[STATE, k], last[UNKNOWN, k]
        for j in range(s):
            guess[STATE, j] += rule.predict_state[ratio, k + 1, j] * psi
            guess[UNKNOWN, j] += rule.predict[ratio, k, j] * z


@njit
def hold(nodes: Nodes, psi: float, z: float, guess: Array) -> None:
    """Take the values at a step's end as the guess for the next step if its length differs, so that polynomials do not extend."""
    for j in range(len(nodes)):
        guess[STATE, j] = psi
        guess[UNKNOWN, j] = z
