"""The derivative of a march of the delay system by parameters of its scene (`slipwave.step.sensitivity`), for plain slabs of
equal round trips.

With the wave S that arrives, S(t + 1) = S(t) - 2 Z v(t) + 2 Z V(t + 1/2), a change dS meets friction and returns one transit
later: dS(t + 1) = dS(t) - 2 Z dv(t) + the direct derivative by p. Parameters that change the transit are left out: they shift the
arrival of each jump, so that the derivative does not exist there.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from reduced.delay.alike import Delay, TransitMesh, first_waves, plain_impedance
from slipwave.compiled import allocating
from slipwave.errors import SceneError
from slipwave.friction import Law
from slipwave.observe.pieces import SAME, Array, Pieces
from slipwave.scene import Scene
from slipwave.step.collocation import Nodes, rule_of
from slipwave.step.impedance import Diagonal
from slipwave.step.sensitivity import DirectDerivatives, ShiftedScenes, answer_given, drive_on, given_by, start_by, stress_by
from slipwave.step.tangent import Motion, blank_answer, step_answer


@allocating
def _carry_waves(
    nodes: Nodes,
    law: Law,
    impedance: float,
    lengths: Array,
    integral: Array,
    motion: Motion,
    waves: Array,
    given: DirectDerivatives,
    psi: Array,
) -> None:
    """Carry the derivatives, of the arriving `waves` at the nodes of one transit's steps (steps, m, s) and of `psi` (m,), along
    the `motion` in steps of the lengths `lengths` (friction clock); `integral` is A transposed. The memory of `given` is the wave
    that is launched."""
    s, count, answer = len(nodes), waves.shape[0], blank_answer(nodes)
    for k in range(lengths.size):
        arriving = waves[k % count]
        for c in range(psi.size):
            for j in range(s):
                given.stress[k, c, j] += arriving[c, j]
        step_answer(nodes, law, Diagonal(impedance), lengths[k], integral, motion, k, answer)
        answer_given(nodes, answer, k, given, psi)
        for c in range(psi.size):
            for j in range(s):
                arriving[c, j] += given.memory[k, c, j] - 2.0 * impedance * given.rate[k, c, j]


def delay_sensitivity(
    scene: Scene, sides: Sequence[ShiftedScenes], until: float, tolerance: float
) -> Iterator[tuple[Pieces, Array]]:
    """Yield the motion up to `until` (transits), in whole transits, each part with d mu/dp (k, m, s) at its nodes. Raises
    SceneError for a parameter that changes the transit, NumericsError where the march fails."""
    if any(abs(clock - 1.0) > SAME for _, clocks, _ in sides for clock in clocks):
        raise SceneError("delay: the derivative by a parameter that changes the transit does not exist at every moment")
    solver = Delay(scene, tolerance=tolerance)
    psi, mesh, arriving = start_by(sides), None, np.empty(0)
    end = np.ceil(until - SAME)
    while solver.time < end - SAME:
        pieces = solver.advance(end)
        count = int(np.searchsorted(pieces.time, pieces.time[0] + 1.0 - SAME))  # steps of the first transit
        now = TransitMesh(count, pieces.length[:count].copy(), pieces.time[:count] - pieces.time[0])
        if mesh is None:
            changes = [
                first_waves(plus, now, solver.nodes) - first_waves(minus, now, solver.nodes) for (plus, minus), _, _ in sides
            ]
            arriving, mesh = np.stack([change / (2.0 * side.step) for change, side in zip(changes, sides, strict=True)], 1), now
        elif now.steps != mesh.steps or not np.allclose(now.lengths, mesh.lengths):
            arriving, mesh = np.moveaxis(mesh.resample(np.moveaxis(arriving, 0, 1), solver.nodes, now), 1, 0).copy(), now
        yield pieces, _carried_along(scene, sides, pieces, arriving, psi)


def _carried_along(scene: Scene, sides: Sequence[ShiftedScenes], pieces: Pieces, arriving: Array, psi: Array) -> Array:
    """d mu/dp along `pieces`; `arriving` and `psi` are advanced to their end."""
    _, rule, shape = rule_of(pieces.z.shape[1])
    nodes, own = np.array(shape), plain_impedance(scene)
    given, here = given_by(scene, sides, pieces, nodes.size)
    v, direct = here[0], -given.stress
    for i, (scenes, _, step) in enumerate(sides):
        for moved, sign in zip(scenes, (0.5, -0.5), strict=True):
            impedance = plain_impedance(moved)
            if impedance != own or moved.velocity != scene.velocity:
                drive = drive_on(moved, pieces, nodes, 1.0, 0.5)
                given.memory[:, i] += sign / step * 2.0 * impedance * (drive - v)
                given.stress[:, i] -= sign / step * impedance * v
    motion, lengths = Motion(pieces.z, pieces.psi, False), pieces.length * scene.transit
    _carry_waves(shape, scene.law, own, lengths, rule.integral, motion, arriving, given, psi)
    return stress_by(here, given, direct)
