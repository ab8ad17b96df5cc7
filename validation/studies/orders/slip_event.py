"""The waves of one slip event over time and depth: they cross the slabs unchanged, and the returning one ends the event."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

import slipwave as sw
from fullwave.fields.record import Field, record_field
from validation.models.build import build_full_wave
from validation.report import EXACT, Verdict, claim

STRAIGHT = "Waves cross the slabs on straight characteristics, unchanged"
ENDED = "The wave of the fastest slip, back from the outer face after one transit, ends the event"
_MODEL, _CELLS, _INTERVAL = "dg:7", 16, 1.0 / 96.0
_WINDOW = (67.0, 82.0)  # transits since an event; the next one is at its fastest at 74.0
_CURVED, _LATE = 1e-6, 0.1  # of the wave's range; transits


def recorded_event() -> Field:
    """The fields about one slip event of the periodic orbit, times counted from its fastest moment."""
    solver = build_full_wave(_MODEL, sw.read("paper", {"start.kind": "orbit"}), cells=_CELLS, time="explicit")
    event, _ = record_field(solver, *_WINDOW, _INTERVAL)
    return replace(event, time=event.time - event.time[np.argmax(event.upper.velocity[:, 0])])


def event_verdicts(event: Field) -> Iterator[Verdict]:
    """The outgoing wave, stress - epsilon velocity, at each depth against that of the interface one travel time before; the time
    until the slip rate, twice the velocity at the interface, falls below V."""
    upper = event.upper
    outgoing = upper.stress - event.scene.upper.epsilon * upper.velocity
    source, off = CubicSpline(event.time, outgoing[:, 0]), 0.0
    for depth, wave in zip(upper.depth, outgoing.T, strict=True):
        emitted = event.time - 0.5 * depth
        inside = emitted >= event.time[0]
        off = max(off, float(np.abs(wave - source(emitted))[inside].max()))
    yield claim(
        STRAIGHT, EXACT, off / float(np.ptp(outgoing[:, 0])), _CURVED, f"`{_MODEL}`; the largest difference over the range"
    )
    slow = event.time[(event.time > 0.0) & (2.0 * upper.velocity[:, 0] < event.scene.velocity)]
    stop = float(slow.min(initial=np.inf))
    yield claim(ENDED, EXACT, stop, _LATE, "transits from the fastest moment until v falls below V", near=1.0)
