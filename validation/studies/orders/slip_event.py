"""The waves of one slip event over time and depth: they cross the slabs unchanged, and the returning one ends the event."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

import slipwave as sw
from validation.report import EXACT, Verdict, claim

STRAIGHT = "Waves cross the slabs on straight characteristics, unchanged"
ENDED = "The wave of the fastest slip, back from the outer face after one transit, ends the event"
_DEGREE, _CELLS = 7, 16
_UNTIL = 8.0  # transits; the orbit begins with an event
_CURVED, _LATE = 1e-10, 0.1  # of the wave's range; transits


class EventWaves(NamedTuple):
    """The upper slab about one slip event: time (transits) from its fastest moment, depth of the ends of cells, the `outgoing`
    wave, stress - epsilon velocity, over time and depth, and the slip rate over V."""

    time: np.ndarray
    depth: np.ndarray
    outgoing: np.ndarray
    slip_rate: np.ndarray


def recorded_event() -> EventWaves:
    """The event with which a run from the periodic orbit begins; the time between samples is a wave's through half a cell."""
    scene = sw.read("paper", {"start.kind": "orbit"})
    fields = sw.run(scene, f"dg:{_DEGREE}", cells=_CELLS, until=_UNTIL, fields=True).records.fields
    assert fields
    time, upper = fields.field.time, fields.field.upper
    outgoing, fastest = upper.stress - scene.upper.epsilon * upper.velocity, np.argmax(upper.velocity[:, 0])
    rate = 2.0 * upper.velocity[:, 0] / scene.velocity
    return EventWaves(time - time[fastest], upper.depth[::_DEGREE], outgoing[:, ::_DEGREE], rate)


def event_verdicts(event: EventWaves) -> Iterator[Verdict]:
    """The outgoing wave at each depth against that of the interface one travel time before; the time until the slip rate, twice
    the velocity at the interface, falls below V."""
    source, off = CubicSpline(event.time, event.outgoing[:, 0]), 0.0
    for depth, wave in zip(event.depth, event.outgoing.T, strict=True):
        emitted = event.time - 0.5 * depth
        inside = emitted >= event.time[0]
        off = max(off, float(np.abs(wave - source(emitted))[inside].max()))
    where = f"`dg:{_DEGREE}`; the largest difference over the range"
    yield claim(STRAIGHT, EXACT, off / float(np.ptp(event.outgoing[:, 0])), _CURVED, where)
    slow = event.time[(event.time > 0.0) & (event.slip_rate < 1.0)]
    stop = float(slow.min(initial=np.inf))
    yield claim(ENDED, EXACT, stop, _LATE, "transits from the fastest moment until v falls below V", near=1.0)
