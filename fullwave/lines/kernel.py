"""The compiled loop of the method-of-lines march: equal Runge-Kutta steps, with a sample of the interface after each."""

from typing import NamedTuple

from fullwave.lines.motion import rates_of
from fullwave.lines.runge_kutta import RungeKutta, combine_stages
from fullwave.lines.system import ELASTIC, PSI, System
from slipwave.compiled import njit
from slipwave.observe.pieces import Array, Pieces

STEPS_PER_PIECE = 8
"""Steps in one piece: its nine samples make a polynomial of degree 8, so observers never limit a scheme of order 8 or less."""

MOST_PIECES = 512
"""Pieces in one chunk, fewer on big grids (`budget.MOST_WORK`): they take some 200 kB, and the cost of leaving compiled code is
shared by 4096 steps."""


class Integrated(NamedTuple):
    """All integrated values, `state` (n,), and z of the last three steps' stages, `unknowns` (3, stages), latest first: a
    parabola through them starts each friction solve, which saves two of four iterations. Scratch: the state of a stage, `trial`
    (n,), and the `rates` of all stages, flat (stages n,)."""

    state: Array
    unknowns: Array
    trial: Array
    rates: Array


@njit
def march_lines(
    system: System,
    method: RungeKutta,
    step: float,
    first: int,
    begin: int,
    end: int,
    values: Integrated,
    pieces: Pieces,
    frames: Array,
) -> tuple[int, int, float]:
    """March steps `begin` to `end` (excluded) of those that fill `pieces`, which begin at step number `first`. The step after the
    last piece is evaluated only to record the last sample. `method` is that of steps of this length (`scaled_method`). `frames`,
    if it has rows, receives the state at the beginning of every step. Returns (failed solves, step n of the first one or -1,
    fastest relaxation of the state per transit)."""
    weight, abscissae = method.weight, method.abscissae
    state, unknowns, trial, rates = values.state, values.unknowns, values.trial, values.rates
    unknown, psis, stress, elastic = pieces.z, pieces.psi, pieces.mu, pieces.y
    stages, size, count = method.stages, system.interface.size, pieces.time.size
    failures, failed = 0, -1
    fastest = 0.0
    for n in range(begin, end):
        time = (first + n) * step
        if n < frames.shape[0]:
            for i in range(state.size):
                frames[n, i] = state[i]
        for stage in range(stages):
            combine_stages(weight, stages, stage, state, rates, trial)
            guess = 3.0 * (unknowns[0, stage] - unknowns[1, stage]) + unknowns[2, stage]
            at = stage * state.size
            z, mu, relaxation, iterations = rates_of(system, time + abscissae[stage], trial, rates, at, guess)
            fastest = max(fastest, relaxation)
            if stage == 0:
                sample = (z, state[size + PSI], mu, state[size + ELASTIC])
                for k in range(max(0, (n - 1) // STEPS_PER_PIECE), min(count, n // STEPS_PER_PIECE + 1)):
                    j = n - STEPS_PER_PIECE * k
                    unknown[k, j], psis[k, j], stress[k, j], elastic[k, j] = sample
                if n == STEPS_PER_PIECE * count:
                    return failures, failed, fastest  # the next call evaluates this step again and counts its failures
            if iterations == 0:
                failures += 1
                failed = n if failed < 0 else failed
            unknowns[2, stage] = unknowns[1, stage]
            unknowns[1, stage] = unknowns[0, stage]
            unknowns[0, stage] = z
        combine_stages(weight, stages, stages, state, rates, state)
    return failures, failed, fastest
