"""A port without a drive: for every step length, the linear map of what a slab model remembers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.observe.pieces import Array
from slipwave.scene.forcing import Forcing
from slipwave.step.port import arrive, take_in
from slipwave.step.rows import RATE


class LinearPort(NamedTuple):
    """What is remembered, x (n,), in deviations from steady sliding at V and mu_ss, gives per level

        S = mu_ss + K V + x `free`,     x(end) - x = x `change` + (v - V) `gain`,

    S and v at the s nodes of a step; x, S and v are rows. `length` (L,), `ready` (L,), `impedance` K (L, s, s), `free` (L, n, s),
    `change` (L, n, n), `gain` (L, s, n). It remembers `values` (n,); `before` (n,) is scratch."""

    length: Array
    ready: NDArray[np.bool_]
    impedance: Array
    free: Array
    change: Array
    gain: Array
    steady_stress: float
    velocity: float
    values: Array
    before: Array


def blank_port(forcing: Forcing, longest: float, levels: int, remembered: int, stages: int) -> LinearPort:
    """A port of `levels` step lengths, of which `longest` (transits) is the first, whose tables are not made yet."""
    return LinearPort(
        np.ldexp(longest, -np.arange(levels)),
        np.zeros(levels, dtype=np.bool_),
        np.empty((levels, stages, stages)),
        np.empty((levels, remembered, stages)),
        np.empty((levels, remembered, remembered)),
        np.empty((levels, stages, remembered)),
        forcing.steady_stress,
        forcing.velocity,
        np.zeros(remembered),
        np.zeros(remembered),
    )


@arrive.register(LinearPort)
def _arrive(port, nodes, level, incoming, work):  # type: ignore[no-untyped-def]
    s = len(nodes)
    free, values = port.free, port.values
    for j in range(s):
        incoming[0, j] = port.steady_stress
        for m in range(s):
            incoming[0, j] += port.impedance[level, j, m] * port.velocity
    for i in range(values.size):
        for j in range(s):
            incoming[0, j] += free[level, i, j] * values[i]


@take_in.register(LinearPort)
def _take_in(port, nodes, level, integral, incoming, work):  # type: ignore[no-untyped-def]
    values, before, change, gain = port.values, port.before, port.change, port.gain
    for i in range(values.size):
        before[i] = values[i]
    for i in range(values.size):
        for k in range(values.size):
            values[k] += before[i] * change[level, i, k]
    for j in range(len(nodes)):
        rate = work[RATE, j] - port.velocity
        for k in range(values.size):
            values[k] += rate * gain[level, j, k]
