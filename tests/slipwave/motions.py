"""Motions with known turning points of the elastic stress, as the pieces that a solver would emit."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

import slipwave
from slipwave.observe import EventObserver, Pieces

Array = NDArray[np.float64]
SCENE = slipwave.read("paper", ["slab.log10_r=0.0"])
"""Of slabs so thick that each fall of these motions is long enough for a slip event."""
V = 100.0
RADAU = np.array([0.0885879595127, 0.4094668644407, 0.7876594617608, 1.0])
EQUISPACED = np.linspace(1 / 6, 1.0, 6)


class Motion(NamedTuple):
    """Elastic stress and ln v over time (transits), from t = 0 to `until`; the friction stress, if it is asked for."""

    elastic: Callable[[Array], Array]
    unknown: Callable[[Array], Array]
    until: float
    stress: Callable[[Array], Array] = np.zeros_like


def through(turns, step=5.0, velocity=V):
    """Elastic stress that turns at t = 0, `step`, 2 `step`, ... at the values `turns` and is monotone between; v from
    y' = k (V - v) with k so large that v > V/5."""
    curve = PchipInterpolator(step * np.arange(len(turns)), turns)
    slope = curve.derivative()
    steepest = float(np.max(slope(np.linspace(0.0, curve.x[-1], 20 * len(turns)))))
    stiffness = 1.25 * max(steepest, 1e-30) / velocity
    return Motion(curve, lambda t: np.log(velocity - slope(t) / stiffness), float(curve.x[-1]))


def watch(motion, nodes=RADAU, pieces=2000, chunk=7, resumed=False, scene=SCENE):
    """The observer after `motion` was shown to it in chunks of `chunk` of equally long `pieces`; if `resumed`, another goes on
    after each."""
    observer = EventObserver(scene, nodes)
    edges = np.linspace(0.0, motion.until, pieces + 1)
    for first in range(0, pieces, chunk):
        if resumed:
            before, observer = observer, EventObserver(scene, nodes)
            observer.restore(before.state())
        left, length = edges[:-1][first : first + chunk], np.diff(edges)[first : first + chunk]
        times = left[:, None] + length[:, None] * nodes
        state = np.zeros_like(times)
        observer.scan(Pieces(left, length, motion.unknown(times), state, motion.stress(times), motion.elastic(times)))
        _ = observer.count  # a look at the run so far changes nothing
    return observer
