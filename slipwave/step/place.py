"""A run that begins in the middle of a motion that is known, as on a periodic orbit: what the interface must remember there."""

from typing import NamedTuple

import numpy as np

from slipwave.observe.solver import State
from slipwave.step.march import TIME, begin


class Place(NamedTuple):
    """The interface where a run is to begin: `time` (transits), the rate unknown `z`, `psi`, and the elastic stress."""

    time: float
    z: float
    psi: float
    elastic: float


def stepper_state(saved: State, place: Place) -> State:
    """The state `saved` of a `Stepper`, with the interface at `place` and no step before it."""
    memory = begin(place.psi, place.elastic, place.z, saved["last"].shape[1])
    memory.now[TIME] = place.time
    following, _, iterations = saved["counts"]
    counts = np.array([following, -1.0, iterations])
    return saved | {"counts": counts, "stretch": np.array([place.time]), "last": memory.last, "now": memory.now}
