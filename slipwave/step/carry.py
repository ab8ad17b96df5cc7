"""The compiled derivative of a march on planned steps: what it does with small changes of what a port remembers and of psi."""

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import allocating
from slipwave.friction import Law
from slipwave.observe.pieces import Array
from slipwave.step.collocation import Nodes
from slipwave.step.impedance import Full
from slipwave.step.port import Port
from slipwave.step.tangent import SLOPES, step_answer


@allocating
def carry(
    nodes: Nodes,
    law: Law,
    port: Port,
    impedance: Full,
    transit: float,
    integral: Array,
    plan: NDArray[np.int64],
    z: Array,
    psi: Array,
    frozen: bool,
    values: Array,
    state: Array,
) -> None:
    """Carry m changes, of the port's `values` (m, n) and of psi, `state` (m,), along the motion with nodal `z` and `psi`
    (steps, s) in steps of the levels `plan`. `frozen`: psi is held. One `transit` on the friction clock; `integral` is A
    transposed; `impedance` is scratch."""
    s, count = len(nodes), state.size
    answer, slopes, system = np.empty((2 * s, 2 * s + 1)), np.empty((SLOPES, s)), np.empty((s, 2 * s + 1))
    n = values.shape[1]
    stress, rate = np.empty((count, s)), np.empty((count, s))
    kept, gained = np.empty_like(values), np.empty_like(values)
    for k in range(plan.size):
        level = plan[k]
        h = port.length[level] * transit
        for j in range(s):
            for m in range(s):
                impedance.matrix[j, m] = port.impedance[level, j, m]
        step_answer(nodes, law, impedance, h, integral, z[k], psi[k], frozen, slopes, system, answer)
        np.dot(values, port.free[level], stress)
        for c in range(count):
            for j in range(s):
                rate[c, j] = answer[j, s] * state[c]
                for m in range(s):
                    rate[c, j] += answer[j, m] * stress[c, m]
            end = answer[2 * s - 1, s] * state[c]
            for m in range(s):
                end += answer[2 * s - 1, m] * stress[c, m]
            state[c] = end
        np.dot(values, port.change[level, :n], kept)
        np.dot(rate, port.change[level, n : n + s], gained)
        for c in range(count):
            for i in range(n):
                values[c, i] += kept[c, i] + gained[c, i]
