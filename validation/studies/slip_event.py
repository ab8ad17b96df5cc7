"""The waves of one slip event in the (time, depth) plane."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

import slipwave
from fullwave.fields.files import picture
from fullwave.fields.record import Field, record_field
from slipwave.observe.pieces import Array
from validation.compute.build import build_full_wave
from validation.measure.cycle import watch
from validation.study import EXACT, Budget, Figure, StudyResult, Table, Verdict, claim, stated, table
from validation.study.drawing import Drawing

NAME = "slip-event"
QUESTION = "What do the slabs do during one slip event?"
SCENES = ("paper",)
SECONDS = (5.0, 8.0)

_MODEL, _SETTLED = "dg:7", 1600.0
_BEFORE, _AFTER, _SEARCHED, _INTERVAL = 5.0, 7.0, 24.0, 1.0 / 96.0
_CURVED, _MOVED = 1e-6, 1e-10
_LATE = 0.1  # transits
_DEPTHS = (0.0, 0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True)
class Event:
    """The fields about one slip event, `time` counted from its fastest moment (transits), and the cells used."""

    field: Field
    cells: int

    @property
    def slip_rate(self) -> Array:
        """v at the interface (V*)."""
        return 2.0 * self.field.upper.velocity[:, 0]


def run(budget: Budget) -> StudyResult:
    """Record one event, draw it, and compare its waves with straight characteristics."""
    event = _record(16 if budget.quick else 24)
    budget.report(0.8)
    largest, stress = float(event.slip_rate.max()), event.field.upper.stress[:, 0]
    return StudyResult(
        answer=f"The interface slips at up to {largest:,.0f} V*, stays above 10 V for {_lasting(event):.1f} transits and "
        f"falls below V {_stop(event):.2f} transits after its fastest moment, when the wave that it sent out has come back.",
        figures=(Figure("event", _CAPTION, lambda: _draw(event)),),
        tables=(_arrivals(event),),
        verdicts=tuple(_verdicts(event, characteristics(event.field))),
        numbers={
            "largest slip rate": stated(largest, _missed(event.slip_rate)),
            "stress swing": stated(float(np.ptp(stress)), _missed(stress) + _missed(-stress)),
        },
    )


def _missed(values: Array) -> float:
    """Most by which the largest sample may fall short of the maximum between samples: by the parabola through its neighbours,
    half an interval away."""
    most = int(np.argmax(values[1:-1]))
    return float(2.0 * values[most + 1] - values[most] - values[most + 2]) / 8.0


def _record(cells: int) -> Event:
    """March to the orbit, predict the next event from the last period, keep the fields about its fastest moment."""
    scene = slipwave.read("paper")
    solver = build_full_wave(_MODEL, scene, cells=cells, time="explicit")
    events = watch(solver, _SETTLED).events()
    period = float(events.period[-1])
    start = float(events.time[-1]) + period
    while start - _BEFORE <= solver.time:
        start += period
    recorded, _ = record_field(solver, start - _BEFORE, start + _SEARCHED, _INTERVAL)
    fastest = recorded.time[int(np.argmax(recorded.upper.velocity[:, 0]))]
    return Event(_window(recorded, float(fastest)), cells)


def _window(recorded: Field, origin: float) -> Field:
    """The part of the record about `origin`, times counted from it."""
    time = recorded.time - origin
    kept = (time >= -_BEFORE) & (time <= _AFTER)
    upper = replace(recorded.upper, velocity=recorded.upper.velocity[kept], stress=recorded.upper.stress[kept])
    return replace(recorded, time=time[kept], upper=upper)


def characteristics(field: Field) -> float:
    """Largest change of the outgoing wave, stress - epsilon velocity, between the interface and any depth, over its range."""
    slab, upper = field.scene.upper, field.upper
    outgoing = upper.stress - slab.epsilon * upper.velocity
    source = CubicSpline(field.time, outgoing[:, 0])
    worst = 0.0
    for depth, wave in zip(upper.depth, outgoing.T, strict=True):
        emitted = field.time - 0.5 * depth
        inside = emitted >= field.time[0]
        worst = max(worst, float(np.abs(wave - source(emitted))[inside].max()))
    return worst / float(np.ptp(outgoing[:, 0]))


def _verdicts(event: Event, off: float) -> Iterator[Verdict]:
    """`off`: the value of `characteristics`."""
    field, stop = event.field, _stop(event)
    drive = field.upper.velocity[:, -1] / (0.5 * field.scene.velocity)
    remark = (
        f"`{_MODEL}`, {event.cells} cells a slab: outgoing wave at each depth against that of the interface one travel time "
        "before; largest difference over its range"
    )
    yield claim("Waves cross the slabs on straight characteristics, unchanged", EXACT, off, _CURVED, remark)
    title = "The rigid outer face keeps the drive’s velocity through the event"
    remark = "largest relative difference from V/2 in the window; the scheme imposes the face weakly"
    yield claim(title, EXACT, float(np.abs(drive - 1.0).max()), _MOVED, remark)
    title = "The wave of the fastest slip, back from the outer face after one transit, ends the event"
    remark = "shown: transits from the fastest moment until v falls below V; judged: how far they are from one"
    yield claim(title, EXACT, stop, _LATE, remark, f"{stop:.3f}", near=1.0)


def _stop(event: Event) -> float:
    """Transits from the fastest slip until v falls below V; infinite if it does not."""
    slow = event.field.time[(event.field.time > 0.0) & (event.slip_rate < event.field.scene.velocity)]
    return float(slow.min(initial=np.inf))


def _lasting(event: Event) -> float:
    """Transits for which the slip rate is above 10 V."""
    fast = event.field.time[event.slip_rate > 10.0 * event.field.scene.velocity]
    return float(np.ptp(fast))


def _arrivals(event: Event) -> Table:
    field, rows = event.field, []
    upper = field.upper
    for depth in _DEPTHS:
        k = int(np.argmin(np.abs(upper.depth - depth)))
        moved = np.abs(upper.velocity[:, k] - 0.5 * field.scene.velocity)
        fastest = float(field.time[int(np.argmax(moved))]) if depth < 1.0 else None
        rows.append((depth, fastest, float(upper.velocity[:, k].max()), float(np.ptp(upper.stress[:, k]))))
    heading = "depth .2f | fastest at [transits] .3f | velocity there [V*] .4g | swing of stress [σ] .5f"
    caption = (
        "The wave at five depths of the upper slab (0 the interface, 1 the outer face): when it moves fastest, in transits from "
        "the interface’s fastest moment, how fast (the interface’s slip rate is twice its velocity), and how far the shear "
        "stress swings in the window of the figure."
    )
    return table("depths", caption, heading, rows)


def _draw(event: Event) -> Drawing:
    figure = picture(event.field, " ")
    upper, lower, *_ = figure.axes
    lower.set_xlabel("time since the fastest slip (transits)")
    for axes in (upper, lower):
        axes.set(ylabel="", xlim=(-_BEFORE, _AFTER))
    return figure


_CAPTION = (
    "One slip event of the paper’s scene in the (time, depth) plane, by discontinuous Galerkin. Above: velocity of both slabs, "
    "colours linear within ±V and logarithmic beyond. Below: shear stress over the normal stress. The interface is the line in "
    "the middle; velocity jumps across it by the slip rate, stress does not. Left: slip speeds up from transit to transit; "
    "what is left of the previous event’s standing wave lies over it. About time 0 the interface lets go and stress collapses; "
    "the disturbance leans outwards, since it needs half a transit from the interface to the outer face. That face follows its "
    "drive and reflects the disturbance with its velocity reversed. Within a transit of the fastest slip the returning wave has "
    "removed the load, and slip almost stops. The interface now holds its face as firmly as the drive holds the other, so the "
    "wave runs to and fro between the two and hardly weakens. This makes the chequered pattern on the right, which repeats after "
    "one transit, and the ripples of the slow phase in the figure of `one-cycle`."
)
