"""The delay system's marches, begun on an orbit of its flow (`placed`)."""

import numpy as np

from reduced.delay.alike import Delay, next_count
from reduced.delay.network import SAME_PLACE, DelayNetwork
from reduced.delay.transit_mesh import cuts_of, transit_mesh
from reduced.flows.delay import DelayFlow
from slipwave.friction import rates
from slipwave.observe.pieces import Array, lagrange_basis, values_at
from slipwave.solve import State
from slipwave.step.flow import Cycle, Place


def placed(solver: Delay | DelayNetwork, flow: DelayFlow, cycle: Cycle, place: Place) -> State:
    """The state of `solver` at the start of `cycle`, a motion of `flow`, with steps that are at least as short. `place.time` is a
    whole number of transits."""
    saved, now = solver.state(), np.array([place.time, place.psi, place.elastic])
    if isinstance(solver, Delay):
        return _alike(solver, saved, flow, cycle, now)
    return _network(solver, saved, flow, cycle, place, now)


def _alike(solver: Delay, saved: State, flow: DelayFlow, cycle: Cycle, now: Array) -> State:
    """The waves that arrive during the first transit are S = mu + eps v/2 of the motion itself."""
    count = max(int(saved["counts"][0]), round(1.0 / flow.length))
    mesh, basis = transit_mesh(count, cuts_of(solver.scene.drive)), lagrange_basis(flow.nodes)
    times = mesh.starts[:, None] + solver.nodes * mesh.lengths[:, None]
    z, psi, mu, _ = (values.reshape(times.shape) for values in values_at(cycle.pieces, basis, times.ravel()))
    counts = saved["counts"].copy()
    counts[0] = count
    incoming = mu + 0.5 * solver.scene.upper.epsilon * rates(solver.scene.law, z)
    waiting = np.empty((0, saved["waiting"].shape[1]))
    return saved | {"counts": counts, "incoming": incoming, "guess": np.stack([psi[0], z[0]]), "now": now, "waiting": waiting}


def _network(solver: DelayNetwork, saved: State, flow: DelayFlow, cycle: Cycle, place: Place, now: Array) -> State:
    counts = saved["counts"].copy()
    count, per_count = int(counts[0]), solver.steps / counts[0]
    while count * per_count * flow.length < 1.0 - SAME_PLACE:
        count = next_count(count)
    new, start = flow.remeshed(cycle, count * per_count * flow.length)
    waves, tops, cursor = new.memory_of(start)
    counts[:3] = count, 0.0, cursor
    stages = solver.nodes.size
    guess = np.repeat([[place.psi], [place.z]], stages, axis=1)
    origin = np.array([place.time])
    return saved | {"counts": counts, "origin": origin, "waves": waves, "tops": tops, "guess": guess, "now": now}
