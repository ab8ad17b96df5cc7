"""An orbit of T transits at r is one of T/(1 + k T) transits at r (1 + k T): r enters friction's clock as a delay alone, and the
waves are then late by k periods more (Yanchuk and Perlikowski, Phys. Rev. E 79, 046221, 2009)."""

import numpy as np

from reduced.flows.delay import DelayFlow
from reduced.orbit.closing import Closed
from reduced.parameters import with_parameter
from slipwave.friction import rates
from slipwave.observe.pieces import Array, lagrange_basis, values_at


def in_thicker_slabs(closed: Closed, turns: int, period: float) -> float:
    """Largest difference of psi from that of the delay system's orbit `closed`, after its motion was put into alike slabs
    1 + `turns` * `period` times as thick and marched over a period there."""
    flow, ratio = closed.flow, 1.0 + turns * period
    assert isinstance(flow, DelayFlow)
    other = DelayFlow(with_parameter(flow.scene, "r", flow.scene.transit * ratio), ratio / flow.length)
    ages = ((np.arange(other.kept)[:, None] - other.kept + other.nodes) * other.length).ravel()
    outward, inward = (_left(closed, (ages - earlier) * ratio) for earlier in (0.0, 0.5))  # half a transit ago it went outwards
    start = np.r_[outward, inward, closed.cycle.start[-1]]
    pieces = other.march(start, period / ratio).pieces
    times = (pieces.time[:-1, None] + pieces.length[:-1, None] * other.nodes) * ratio
    return float(np.abs(pieces.psi[:-1] - _motion(closed, times.ravel())[1].reshape(times.shape)).max())


def _left(closed: Closed, times: Array) -> Array:
    """The wave that leaves the interface, mu - S - eps/2 (v - V), at any times (transits of the orbit)."""
    scene = closed.flow.scene
    z, _, mu, _ = _motion(closed, times)
    return np.asarray(mu - scene.steady_stress - 0.5 * scene.upper.epsilon * (rates(scene.law, z) - scene.velocity))


def _motion(closed: Closed, times: Array) -> list[Array]:
    return values_at(closed.cycle.pieces, lagrange_basis(closed.flow.nodes), np.mod(times, closed.cycle.period))
