"""One collocated friction step of five nodes, solved by itself."""

import numpy as np

from slipwave.compiled import njit
from slipwave.step.collocation import radau
from slipwave.step.newton import solve_step
from slipwave.step.rows import FORCED, RATE, STATE, UNKNOWN, WORK_ROWS

RULE = radau(5)
NODES = tuple(float(x) for x in RULE.nodes)
S = len(NODES)
COUPLED = np.tril(np.random.default_rng(5).uniform(0.2, 1.0, (S, S)))


@njit
def _solve(nodes, law, impedance, h, psi, incoming, integral, guess, work, system):
    return solve_step(nodes, law, impedance, h, psi, incoming, 0, integral, 1e-13, guess, work, system)


def solved(law, impedance, h, psi, z, incoming, forced):
    """(iterations, psi, z, v) at the nodes, from a guess one unit off in z."""
    guess, work = np.full((2, S), psi), np.zeros((WORK_ROWS, S))
    guess[UNKNOWN] = z + 1.0
    work[FORCED] = forced
    used = _solve(NODES, law, impedance, h, psi, incoming[None], RULE.integral.T.copy(), guess, work, np.empty((S, S)))
    return used, guess[STATE], guess[UNKNOWN], work[RATE]
