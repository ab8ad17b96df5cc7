"""Measurements of a model on a scene, shared by studies: its onset, its own orbit, its settled run. Each is computed once per
process and cached by model, scene and settings; errors are not.
"""

import math
from functools import cache

import numpy as np

from reduced.orbit import PeriodicOrbit
from reduced.orbit.closing import Closed
from reduced.stability import critical_round_trip
from slipwave.errors import NumericsError
from slipwave.observe.history import values_at
from slipwave.observe.pieces import lagrange_basis
from slipwave.scene import Scene
from validation.models.build import build
from validation.models.by_name import one_port_of
from validation.models.cycle import OneCycle, cut
from validation.models.orbit_start import first_event
from validation.models.orbits import find_orbit
from validation.models.settle import MOST_TRANSITS, Settled, settle
from validation.models.settle import WINDOW as WINDOW

_PER_PIECE = 12  # samples
_TURNS = (-1, 0, 1, 2)  # periods of an orbit, of which a cycle needs some


@cache
def own_orbit(model: str, scene: Scene, tolerance: float = 1e-10, cells: int | None = None) -> PeriodicOrbit:
    """The orbit of `model` that its run from the start of `scene` comes near to, by Newton's method, with relative errors of the
    figures below `tolerance`. Raises NumericsError if there is none."""
    return find_orbit(model, scene, tolerance, cells).periodic


@cache
def critical_r(model: str, scene: Scene) -> float:
    """The upper slab's r from which on steady sliding is unstable, both slabs scaled together; NaN if there is none. For a full
    wave that of its equations, independent of the grid."""
    try:
        return critical_round_trip(scene, one_port_of(model))[0]
    except NumericsError:
        return math.nan


@cache
def settled(
    model: str,
    scene: Scene,
    tolerance: float | None = 1e-9,
    to: float = 1e-8,
    most: float = MOST_TRANSITS,
    cells: int | None = None,
    cfl: float | None = None,
) -> Settled:
    """The settled run of `model` at this `tolerance`: its cycles agree `to` this relative accuracy (`settle`). Do not move its
    solver, which is shared. Raises NoCycle and NumericsError as `settle`."""
    return settle(build(model, scene, tolerance=tolerance, cells=cells, cfl=cfl), to, most)


def cycle_of(closed: Closed, before: float, after: float) -> OneCycle:
    """A closed orbit as the cycle of its first slip event, with `before` transits ahead of it and `after` transits past its end;
    its elastic stress is known up to a constant."""
    period, pieces = closed.cycle.period, closed.cycle.pieces
    points = (np.arange(_PER_PIECE) + 0.5) / _PER_PIECE
    once = (pieces.time[:, None] + pieces.length[:, None] * points).ravel()
    once = once[once < period]
    times = np.concatenate([once + turn * period for turn in _TURNS])
    law = closed.flow.scene.law
    values = values_at(pieces, lagrange_basis(closed.flow.nodes), np.mod(times, period), law)
    samples = np.stack([times, *values])
    return cut(law, samples, first_event(closed), period, before, after)
