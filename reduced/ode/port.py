"""The port of an ODE reduction: its response to the slip rate by collocation on the nodes of the step (`step_tables`)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.observe.pieces import Array
from slipwave.step.port import arrive, take_in
from slipwave.step.rows import DRIVE, RATE

SPRING, SLIP_RATE = 0, 1  # entries of `ReducedPort.face`


class ReducedPort(NamedTuple):
    """Tables of `step_tables`, per level: `length` (L,); `impedance` K (L, s, s) with mass, and `elastic` (L, s, s) without;
    `inertia` m A^-1 1 / h, (L, s); `free` (L, N, 2, s): response to tau_0 and p_0; `forced` (L, N, s, s): response to -u;
    `ready` (L,). Per mode: `offset`, `omega_squared`; and the `spring`. All stresses are in units of the normal stress.

    It remembers `modes` (N, 2), tau and p, and at the interface `face` (2,), the spring's stress and the slip rate."""

    length: Array
    impedance: Array
    elastic: Array
    inertia: Array
    free: Array
    forced: Array
    ready: NDArray[np.bool_]
    offset: Array
    omega_squared: Array
    spring: float
    modes: Array
    face: Array


@arrive.register(ReducedPort)
def _arrive(port, nodes, level, incoming, work):  # type: ignore[no-untyped-def]
    modes, elastic, free = port.modes, port.elastic, port.free
    s = len(nodes)
    for j in range(s):
        total = port.face[SPRING] + port.inertia[level, j] * port.face[SLIP_RATE]
        for n in range(modes.shape[0]):
            total += free[level, n, 0, j] * modes[n, 0] + free[level, n, 1, j] * modes[n, 1]
        for m in range(s):
            total += elastic[level, j, m] * work[DRIVE, m]
        incoming[0, j] = total


@take_in.register(ReducedPort)
def _take_in(port, nodes, level, integral, incoming, work):  # type: ignore[no-untyped-def]
    modes, free, forced, length = port.modes, port.free, port.forced, port.length[level]
    s = len(nodes)
    slip = 0.0
    for j in range(s):
        slip += length * integral[j, s - 1] * (work[RATE, j] - work[DRIVE, j])
    for n in range(modes.shape[0]):
        momentum, tau = 0.0, 0.0
        for j in range(s):
            tau = free[level, n, 0, j] * modes[n, 0] + free[level, n, 1, j] * modes[n, 1]
            for m in range(s):
                tau -= forced[level, n, j, m] * (work[RATE, m] - work[DRIVE, m])
            rate = work[RATE, j] - work[DRIVE, j]
            momentum += integral[j, s - 1] * (port.offset[n] * rate + port.omega_squared[n] * tau)
        modes[n, 0] = tau
        modes[n, 1] -= length * momentum
    port.face[SPRING] -= port.spring * slip
    port.face[SLIP_RATE] = work[RATE, s - 1]
