"""One collocated friction step of five nodes, solved by itself."""

import numpy as np

from slipwave.step.collocation import radau
from slipwave.step.newton import solve
from slipwave.step.nodal import nodal_of

RULE = radau(5)
NODES = tuple(float(x) for x in RULE.nodes)
S = len(NODES)
COUPLED = np.tril(np.random.default_rng(5).uniform(0.2, 1.0, (S, S)))


def solved(law, impedance, h, psi, z, incoming, forced):
    """(iterations, psi, z, v) at the nodes, from a guess one unit off in z."""
    nodal = nodal_of(S)
    nodal.incoming[:], nodal.left[:], nodal.psi[:], nodal.z[:] = incoming, psi + forced, psi, z + 1.0
    used = solve(NODES, law, impedance, h, RULE.integral.T.copy(), 1e-13, nodal)
    return used, nodal.psi.copy(), nodal.z.copy(), nodal.v.copy()
