"""The marching kernel: slab - interface - slab, sample by sample.

A step from the whole time t_n to t_n+1 has three parts: stresses advance with the velocities at n + 1/2, friction is solved at
t_n+1, velocities advance to n + 3/2. A sample (z, psi, mu, y) is taken at each whole time; four steps make a piece. Nothing is
allocated. Of alike slabs `lower` is None: the kernel compiled for that marches one slab only.
"""

import numpy as np

from fullwave.leapfrog.friction import solve_friction
from fullwave.leapfrog.media import Side, accelerate, load, strain
from slipwave.compiled import inlined, njit
from slipwave.friction import Law, unknown_of
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.scene.drive import Constant, Forcing, Ramps, nudge_rate, velocity_at

STEPS_PER_PIECE = 4
"""Steps in one piece: a quartic, so that reading events and extrema has an error of order 5, in a scheme of order 2."""

MOST_PIECES = 1024
"""Pieces in one chunk: they take some 200 kB, and the cost of leaving compiled code is shared by 4096 steps."""

# slots of the interface's memory
STATE, STRESS, ELASTIC, DRIVE, INPUT, FRICTION = 0, 1, 2, 3, 4, 5
Z, PSI = 6, 11  # the last five samples of each, latest first, for the friction solve's starting values
RATE = 16  # the upper slab's interface velocity at the last sample
MEMORY = 17

COARSEST_HALF_STEP = 1.0
"""Largest change of psi over half a step that the midpoint rule can follow. A step with a larger change counts as failed, and the
change is limited to this, so that the run stays near the quasi-steady state and does not oscillate."""


def steady_memory(scene: Scene) -> Array:
    """Interface memory of steady sliding half a step before t = 0, psi shifted if the start is a jump."""
    memory = np.zeros(MEMORY)
    psi = scene.steady_psi + scene.start.jump_size
    memory[STATE] = psi
    memory[Z:PSI] = unknown_of(scene.law, scene.velocity)
    memory[PSI : PSI + 5] = psi
    memory[[STRESS, ELASTIC]] = scene.steady_stress
    memory[DRIVE] = scene.drive.initial
    return memory


@inlined
def _take_step(
    law: Law, dt: float, forcing: Forcing, drive: Constant | Ramps, upper: Side, lower: Side | None, memory: Array, n: int
) -> bool:
    """March to sample `n` (time n dt, in transits). Returns False if the friction solve did not converge or the step was too long
    to follow the state."""
    previous = memory[DRIVE]
    following = velocity_at(drive, (n + 0.5) * dt, (n + 0.5) * dt)
    mean = 0.25 * (previous + following)
    memory[DRIVE] = following
    strain(upper.medium)
    slip_rate = 2.0 * upper.medium.velocity[0]
    own, own_load = load(upper.medium, upper.face, mean, 0.5 * following)
    impedance, incoming = 0.5 * own, own_load
    if lower is not None:
        strain(lower.medium)
        slip_rate = upper.medium.velocity[0] + lower.medium.velocity[0]
        other, other_load = load(lower.medium, lower.face, mean, 0.5 * following)
        impedance, incoming = own * other / (own + other), (own_load * other + other_load * own) / (own + other)
    memory[ELASTIC] += dt * forcing.stiffness * (previous - slip_rate)
    z, psi, v, converged = solve_friction(
        law,
        impedance,
        incoming + forcing.steady_stress,
        memory[STATE],
        0.5 * dt * forcing.transit,
        0.5 * dt * nudge_rate(forcing.nudge, n * dt),
        _extrapolated(memory, Z),
        _extrapolated(memory, PSI),
    )
    stress = incoming - impedance * v
    rate = 0.5 * v if lower is None else (own_load - stress) / own
    power = accelerate(upper.medium, upper.face, rate, mean, 0.5 * following)
    power += power if lower is None else accelerate(lower.medium, lower.face, v - rate, mean, 0.5 * following)
    change = psi - memory[STATE]
    memory[STATE] = psi + min(COARSEST_HALF_STEP, max(-COARSEST_HALF_STEP, change))
    memory[RATE] = rate
    memory[STRESS] = forcing.steady_stress + stress
    memory[INPUT] += power + 2.0 * forcing.steady_stress * mean
    memory[FRICTION] += memory[STRESS] * v
    _shift(memory, Z, z)
    _shift(memory, PSI, psi)
    return converged and abs(change) < COARSEST_HALF_STEP


@inlined
def _extrapolated(memory: Array, slot: int) -> float:
    """The quartic through the last five samples, extrapolated by one step."""
    outer, inner = memory[slot] - memory[slot + 3], memory[slot + 1] - memory[slot + 2]
    return float(5.0 * outer - 10.0 * inner + memory[slot + 4])


@inlined
def _shift(memory: Array, slot: int, value: float) -> None:
    for i in range(4, 0, -1):
        memory[slot + i] = memory[slot + i - 1]
    memory[slot] = value


@njit
def march_leapfrog(
    law: Law,
    dt: float,
    forcing: Forcing,
    drive: Constant | Ramps,
    upper: Side,
    lower: Side | None,
    memory: Array,
    first: int,
    pieces: Pieces,
) -> tuple[int, int]:
    """Fill `pieces` with the steps after sample `first` (-1: no sample was taken yet, so begin with sample 0). Returns how many
    of these steps failed (`_take_step`), and the sample of the first failed one (-1 if none). Neighbouring pieces both hold the
    sample that they share."""
    failures, failed = 0, -1
    start = max(first, 0)
    if first >= 0:
        _record(memory, pieces, 0, 0)
    for n in range(first + 1, start + STEPS_PER_PIECE * pieces.time.size + 1):
        if not _take_step(law, dt, forcing, drive, upper, lower, memory, n):
            failures += 1
            failed = n if failed < 0 else failed
        k = (n - start) // STEPS_PER_PIECE
        j = (n - start) - STEPS_PER_PIECE * k
        if j == 0 and k > 0:
            _record(memory, pieces, k - 1, STEPS_PER_PIECE)
        if k < pieces.time.size:
            _record(memory, pieces, k, j)
    return failures, failed


@inlined
def _record(memory: Array, pieces: Pieces, k: int, j: int) -> None:
    pieces.z[k, j] = memory[Z]
    pieces.psi[k, j] = memory[PSI]
    pieces.mu[k, j] = memory[STRESS]
    pieces.y[k, j] = memory[ELASTIC]
