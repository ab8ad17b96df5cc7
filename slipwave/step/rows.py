"""Rows of the arrays of one collocation step, with one column per node: the guess (2, s) and the scratch (WORK_ROWS, s)."""

from typing import NamedTuple

import numpy as np

from slipwave.observe.pieces import Array

STATE, UNKNOWN = 0, 1  # of the guess: nodal psi and z

RATE, RATE_SLOPE, MISMATCH, RATIO, INCREMENT, SLOPE, WEIGHT, WEIGHT_STATE, CHANGE, PREVIOUS, FRESH, FORCED, INVERSE, BY_Z = range(
    14
)
DRIVE, STRESS = 14, 15
WORK_ROWS = 16


class Scratch(NamedTuple):
    """Arrays of one step of s nodes, for a march to use again: `guess` (2, s), `work` (WORK_ROWS, s), `system` (s, s), and the
    `incoming` stress (1, s)."""

    guess: Array
    work: Array
    system: Array
    incoming: Array


def scratch_of(stages: int) -> Scratch:
    """The scratch of steps with `stages` nodes."""
    return Scratch(*(np.zeros((rows, stages)) for rows in (2, WORK_ROWS, stages, 1)))
