"""The marching kernel: slab - interface - slab, sample by sample.

A step from the whole time t_n to t_n+1 has three parts: stresses advance with the velocities at n + 1/2, friction is solved at
t_n+1, velocities advance to n + 3/2. A sample (z, psi, mu, y) is taken at each whole time; four steps make a piece. Nothing is
allocated. Of alike slabs `lower` is None: the kernel compiled for that marches one slab only.

Friction over one step is the interface condition together with the state, by the implicit midpoint rule,

    F(z, psi) + Z v(z) = R,      psi - psi_old = (dt/2) (r G(z, psi) + nudge)

with the state psi at the whole time, psi_old half a step before, and dt in transits. Newton solves both equations together from
extrapolated values (usually two iterations). If that fails, psi is bracketed, and for each psi the first equation is solved by
`slipwave.friction.interface.solve_interface`, which cannot fail. None of this limits the step, however large a/v is. If the step
is so long that the pair has more than one solution (b dt r v/2 > (a + Z v)(1 + r dt/(2 phi)) for the ageing law), it is reported
as not converged.
"""

import math

import numpy as np

from fullwave.leapfrog.media import MarchedSlab, accelerate, load, strain
from slipwave.compiled import inlined, njit
from slipwave.friction import Law, respond, unknown_of
from slipwave.friction.interface import solve_interface
from slipwave.observe.pieces import Array, Pieces
from slipwave.scene import Scene
from slipwave.scene.drive import Constant, Forcing, Ramps, nudge_rate, velocity_at

_NEWTON_ITERATIONS = 8
_CONVERGED = 1e-7  # a Newton step this small leaves an error of half its square, 5e-15
_LARGEST_STEP = 2.0
_BRACKETINGS = 200

STEPS_PER_PIECE = 4
"""Steps in one piece: a quartic, so that reading events and extrema has an error of order 5, in a scheme of order 2."""

MOST_PIECES = 1024
"""Pieces in one chunk: they take some 200 kB, and the cost of leaving compiled code is shared by 4096 steps."""

# slots of the interface's memory
STATE, STRESS, ELASTIC, DRIVE, INPUT, FRICTION = 0, 1, 2, 3, 4, 5
Z, PSI = 6, 11  # the last five samples of each, latest first, for the friction solve's starting values
RATE, SLIP_RATE = 16, 17  # the upper slab's interface velocity, and v, at the last sample
MEMORY = 18

COARSEST_HALF_STEP = 1.0
"""Largest change of psi over half a step that the midpoint rule can follow. A step with a larger change counts as failed, and the
change is limited to this, so that the run stays near the quasi-steady state and does not oscillate."""


@njit
def _solve_friction(
    law: Law, impedance: float, incoming: float, old: float, half: float, push: float, z: float, psi: float
) -> tuple[float, float, float, bool]:
    """(z, psi, v, converged) at the whole time, half a step after psi = `old`; `half` = r dt/2, `push` = nudge dt/2."""
    for _ in range(_NEWTON_ITERATIONS):
        v, v_z, friction, friction_z, friction_psi, rate, rate_z, rate_psi = respond(law, z, psi)
        balance = friction + impedance * v - incoming
        evolution = psi - old - half * rate - push
        slope = friction_z + impedance * v_z
        own = 1.0 - half * rate_psi
        determinant = slope * own + friction_psi * half * rate_z
        inverse = 1.0 / determinant
        z_step = (friction_psi * evolution - own * balance) * inverse
        psi_step = -(slope * evolution + half * rate_z * balance) * inverse
        size = abs(z_step) + abs(psi_step)
        if not (determinant > 0.0 and size < _LARGEST_STEP):
            break
        z += z_step
        psi += psi_step
        if size < _CONVERGED * (1.0 + abs(z)):
            return z, psi, v + v_z * z_step, True
    return _bracketed(law, impedance, incoming, old, half, push, z)


@njit
def _mismatch(
    law: Law, impedance: float, incoming: float, old: float, half: float, push: float, z: float, psi: float
) -> tuple[float, float, bool]:
    """(residual of the state equation, z, solved) at a trial psi, with z from the interface condition."""
    z, iterations = solve_interface(law, impedance, incoming, psi, z)
    return psi - old - half * respond(law, z, psi)[5] - push, z, iterations > 0


@njit
def _bracketed(
    law: Law, impedance: float, incoming: float, old: float, half: float, push: float, z: float
) -> tuple[float, float, float, bool]:
    """Bisection of the residual, which goes from -inf to +inf with psi; fails if its slope at the root is not positive."""
    if not math.isfinite(z):
        z = 0.0
    reach = 1.0
    low, high = old - reach, old + reach
    while reach < 1e3 and _mismatch(law, impedance, incoming, old, half, push, z, low)[0] > 0.0:
        reach *= 2.0
        low = old - reach
    while reach < 1e3 and _mismatch(law, impedance, incoming, old, half, push, z, high)[0] < 0.0:
        reach *= 2.0
        high = old + reach
    psi = old
    solved = True
    for _ in range(_BRACKETINGS):
        psi = 0.5 * (low + high)
        if not low < psi < high:
            break
        residual, z, solved = _mismatch(law, impedance, incoming, old, half, push, z, psi)
        if residual > 0.0:
            high = psi
        else:
            low = psi
    v, v_z, _, friction_z, friction_psi, _, rate_z, rate_psi = respond(law, z, psi)
    determinant = (friction_z + impedance * v_z) * (1.0 - half * rate_psi) + friction_psi * half * rate_z
    return z, psi, v, solved and determinant > 0.0 and reach < 1e3


def steady_memory(scene: Scene) -> Array:
    """Interface memory of steady sliding half a step before t = 0, psi shifted if the start is a jump."""
    memory = np.zeros(MEMORY)
    psi = scene.steady_psi + scene.start.jump_size
    memory[STATE] = psi
    memory[Z:PSI] = unknown_of(scene.law, scene.velocity)
    memory[PSI : PSI + 5] = psi
    memory[[STRESS, ELASTIC]] = scene.steady_stress
    memory[DRIVE] = memory[SLIP_RATE] = scene.drive.initial
    return memory


@inlined
def _take_step(
    law: Law,
    dt: float,
    forcing: Forcing,
    drive: Constant | Ramps,
    upper: MarchedSlab,
    lower: MarchedSlab | None,
    memory: Array,
    n: int,
) -> bool:
    """March to sample `n` (time n dt, in transits). Returns False if the friction solve did not converge or the step was too long
    to follow the state."""
    previous = memory[DRIVE]
    following = velocity_at(drive, (n + 0.5) * dt, (n + 0.5) * dt)
    mean = 0.25 * (previous + following)
    memory[DRIVE] = following
    strain(upper.medium)
    own, own_load = load(upper.medium, upper.face, mean, 0.5 * following)
    impedance, incoming = 0.5 * own, own_load
    if lower is not None:
        strain(lower.medium)
        other, other_load = load(lower.medium, lower.face, mean, 0.5 * following)
        impedance, incoming = own * other / (own + other), (own_load * other + other_load * own) / (own + other)
    z, psi, v, converged = _solve_friction(
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
    # by samples of v: velocities at half times, whose means these are, alternate for ever behind a jump
    memory[ELASTIC] += dt * forcing.stiffness * (previous - 0.5 * (memory[SLIP_RATE] + v))
    memory[SLIP_RATE] = v
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
    upper: MarchedSlab,
    lower: MarchedSlab | None,
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
