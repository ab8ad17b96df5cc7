"""The derivative of a march by parameters of its scene, along the steps that it took: exact for these steps.

A parameter p changes the inputs of a step (`slipwave.step.tangent`): the stress by S_p - F_p, where S_p is that of the slabs'
tables at fixed memory, the state's rate by (h G)_p, and then the memory of the slabs. The derivatives of the law's formula and of
the tables are differences between scenes on either side of the present one: both are smooth, and free of a march's noise. Steps
are fixed in time, not in transits, so that a parameter may change the transit too.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipwave.compiled import allocating, njit
from slipwave.friction import Law, rates, respond
from slipwave.observe.pieces import SAME, Array, Pieces
from slipwave.scene import Scene
from slipwave.scene.drive import Constant, Ramps, velocity_at
from slipwave.step.collocation import Nodes, rule_of
from slipwave.step.impedance import Full
from slipwave.step.port import Port, Slabs, prepared, propagate
from slipwave.step.tangent import Answer, Motion, blank_answer, step_answer


class ShiftedScenes(NamedTuple):
    """The scenes at p + `step` and p - `step`, and the number of their transits per transit of the present scene."""

    scenes: tuple[Scene, Scene]
    clocks: tuple[float, float]
    step: float


class DirectDerivatives(NamedTuple):
    """Direct derivatives of k steps of s nodes by m parameters: of the `stress` and of h G, `gain` (k, m, s), and of the `memory`
    (k, m, n) by the step. The responses: of v, `rate`, and of psi, `state` (k, m, s)."""

    stress: Array
    gain: Array
    memory: Array
    rate: Array
    state: Array


def _law_along(law: Law, pieces: Pieces) -> Array:
    """v, v_z, F, F_z, F_psi and G of `law` (6, k, s) at the nodes of a motion."""
    answers = np.empty((6, *pieces.z.shape))
    _respond_all(law, pieces.z, pieces.psi, answers)
    return answers


@njit
def _respond_all(law: Law, z: Array, psi: Array, answers: Array) -> None:
    for k in range(z.shape[0]):
        for j in range(z.shape[1]):
            v, v_z, friction, by_z, by_psi, growth, _, _ = respond(law, z[k, j], psi[k, j])
            answers[0, k, j], answers[1, k, j], answers[2, k, j] = v, v_z, friction
            answers[3, k, j], answers[4, k, j], answers[5, k, j] = by_z, by_psi, growth


def drive_on(scene: Scene, pieces: Pieces, nodes: Array, clock: float = 1.0, late: float = 0.0) -> Array:
    """V of `scene` (in its V*) at the nodes of `pieces` (k, s), shifted by `late` transits; `clock`: transits of `scene` per
    transit of the pieces."""
    velocity = np.empty_like(pieces.z)
    times, lengths = clock * (pieces.time + late), clock * pieces.length
    _drive_at(scene.drive.compiled, times, lengths, nodes, velocity)
    return velocity


@njit
def _drive_at(drive: Constant | Ramps, times: Array, lengths: Array, nodes: Array, velocity: Array) -> None:
    for k in range(times.size):
        for j in range(nodes.size):
            velocity[k, j] = velocity_at(drive, times[k] + nodes[j] * lengths[k], times[k] + 0.5 * lengths[k])


def given_by(scene: Scene, sides: Sequence[ShiftedScenes], pieces: Pieces, remembered: int) -> tuple[DirectDerivatives, Array]:
    """Direct derivatives along `pieces` through the law and the clock, zero through the slabs; and v, v_z, F, F_z, F_psi and G
    along them (6, k, s)."""
    (steps, stages), count, here = pieces.z.shape, len(sides), _law_along(scene.law, pieces)
    stress, gain = np.zeros((2, steps, count, stages))
    for i, (scenes, clocks, step) in enumerate(sides):
        for moved, clock, sign in zip(scenes, clocks, (0.5, -0.5), strict=True):
            _, _, friction, _, _, growth = here if moved.law == scene.law else _law_along(moved.law, pieces)
            stress[:, i] -= sign / step * friction
            gain[:, i] += (sign / step * clock * moved.transit * pieces.length)[:, None] * growth
    rate, state = np.empty((2, steps, count, stages))
    return DirectDerivatives(stress, gain, np.zeros((steps, count, remembered)), rate, state), here


def start_by(sides: Sequence[ShiftedScenes]) -> Array:
    """Derivatives of psi at the start (m,); those of the memory, zero in steady sliding, vanish."""
    ends = [(a.steady_psi + a.start.jump_size - b.steady_psi - b.start.jump_size) / (2.0 * step) for (a, b), _, step in sides]
    return np.array(ends)


def stress_by(law: Array, given: DirectDerivatives, direct: Array) -> Array:
    """d mu/dp at the nodes (k, m, s) from the responses, with F_p = `direct` (k, m, s); `law` as from `given_by`."""
    _, v_z, _, by_z, by_psi, _ = law[:, :, None]
    stress: Array = by_z / v_z * given.rate + by_psi * given.state + direct
    return stress


@njit
def answer_given(nodes: Nodes, answer: Answer, k: int, given: DirectDerivatives, psi: Array) -> None:
    """given.rate and given.state of step `k` <- `answer` applied to its direct derivatives and to the derivatives `psi` (m,) at
    its start, which are replaced by those at its end."""
    s, rows, matrix = len(nodes), given.stress.shape[2], answer.matrix
    for c in range(psi.size):
        for j in range(rows):
            rate, state = matrix[j, s] * psi[c], matrix[s + j, s] * psi[c]
            for m in range(s):
                rate += matrix[j, m] * given.stress[k, c, m] + matrix[j, s + 1 + m] * given.gain[k, c, m]
                state += matrix[s + j, m] * given.stress[k, c, m] + matrix[s + j, s + 1 + m] * given.gain[k, c, m]
            given.rate[k, c, j], given.state[k, c, j] = rate, state
        psi[c] = given.state[k, c, s - 1]


@allocating
def _carry(
    nodes: Nodes,
    law: Law,
    port: Port,
    transit: float,
    integral: Array,
    plan: NDArray[np.int64],
    motion: Motion,
    given: DirectDerivatives,
    changes: tuple[Array, Array],
) -> None:
    """Carry the `changes`, of the memory (m, n) and of psi (m,), along the `motion` in steps of the levels `plan`, one `transit`
    on the friction clock; `integral` is A transposed. given.stress <- the total derivative of the incoming stress."""
    s, (memory, psi), answer = len(nodes), changes, blank_answer(nodes)
    n = memory.shape[1]
    for k in range(plan.size):
        level = plan[k]
        step_answer(nodes, law, Full(port.impedance[level]), port.length[level] * transit, integral, motion, k, answer)
        given.stress[k] += np.dot(memory, port.free[level])
        answer_given(nodes, answer, k, given, psi)
        memory += np.dot(memory, port.change[level, :n]) + np.dot(given.rate[k], port.change[level, n : n + s]) + given.memory[k]


@njit
def _remember(change: Array, plan: NDArray[np.int64], moved: Array, values: Array, memory: Array) -> None:
    """memory (k, n) <- the memory at the start of each step; `values` (n,) <- that at the end. moved (k, n + 2 s): the rows of
    `propagate`, of which the first n are scratch."""
    for k in range(plan.size):
        for i in range(values.size):
            memory[k, i] = moved[k, i] = values[i]
        propagate(change, plan[k], moved.shape[1], moved[k], values)


def port_sensitivity(slabs: Slabs, sides: Sequence[ShiftedScenes], pieces: Pieces) -> Array:
    """d mu/dp (k, m, s) at the nodes of all `pieces` of a march of `slabs` from the start of their scene, without a nudge."""
    scene, (rule, compiled, shape) = slabs.scene, rule_of(slabs.stages)
    remembered = slabs.port(1.0, 1).values.size
    given, law = given_by(scene, sides, pieces, remembered)
    changes = np.zeros((len(sides), remembered)), start_by(sides)
    values = np.zeros(remembered)
    direct = -given.stress
    pairs = [tuple(slabs.of(moved) for moved in scenes) for scenes, _, _ in sides]
    cuts = np.searchsorted(pieces.time, np.array(scene.drive.knots) - SAME)
    for begin, end in pairwise(np.unique([0, *cuts, pieces.time.size])):  # between knots: one length over powers of two
        part = slice(begin, end)
        here, own = pieces.part(part), DirectDerivatives(*(array[part] for array in given))
        longest = float(here.length.max())
        plan = np.rint(np.log2(longest / here.length)).astype(np.int64)
        levels = int(plan.max()) + 1
        port = prepared(slabs, slabs.port(longest, levels), range(levels))
        v, memory = rates(scene.law, here.z), np.empty((plan.size, remembered))
        moved = np.column_stack([memory, v - scene.velocity, drive_on(scene, here, rule.nodes) - scene.velocity])
        _remember(port.change, plan, moved, values, memory)
        for i, (pair, (_, clocks, step)) in enumerate(zip(pairs, sides, strict=True)):
            for side, clock, sign in zip(pair, clocks, (1.0, -1.0), strict=True):
                table, velocity = prepared(side, side.port(longest * clock, levels), range(levels)), side.scene.velocity
                drive = drive_on(side.scene, here, rule.nodes, clock) - velocity
                _add(table, plan, (memory, v, v - velocity, drive), sign / (2.0 * step), (own.stress[:, i], own.memory[:, i]))
        motion = Motion(here.z, here.psi, False)
        _carry(shape, scene.law, port, scene.transit, compiled.integral, plan, motion, own, changes)
    return stress_by(law, given, direct)


def _add(port: Port, plan: NDArray[np.int64], motion: Sequence[Array], weight: float, sums: tuple[Array, Array]) -> None:
    """Add to `sums`, stress (k, s) and memory (k, n), `weight` times the product of a port's tables with one `motion`: memory, v,
    u and c."""
    (memory, v, u, c), (stress, kept) = motion, sums
    rows = np.column_stack([memory, u, c])
    for level in np.unique(plan):
        here = plan == level
        arrived = port.steady[level] + memory[here] @ port.free[level] + c[here] @ port.driven[level]
        stress[here] += weight * (arrived - v[here] @ port.impedance[level].T)
        kept[here] += weight * (rows[here] @ port.change[level])
