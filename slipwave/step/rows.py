"""Rows of the arrays of one collocation step, with one column per node: the guess (2, s) and the scratch (WORK_ROWS, s)."""

STATE, UNKNOWN = 0, 1  # of the guess: nodal psi and z

RATE, RATE_SLOPE, MISMATCH, RATIO, INCREMENT, SLOPE, WEIGHT, WEIGHT_STATE, CHANGE, PREVIOUS, FRESH, FORCED, INVERSE, BY_Z = range(
    14
)
DRIVE, STRESS = 14, 15
WORK_ROWS = 16
