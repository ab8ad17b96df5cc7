"""Charts of runs and orbits: the motion of the interface with SI scales where the scene has units, a protocol over time and slip,
and the return map."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from slipwave.errors import SceneError
from slipwave.observe.envelope import Envelope, Ranges
from slipwave.observe.pieces import Array
from slipwave.observe.protocol import StageFigures
from slipwave.observe.verdict import REPEATS
from slipwave.scene import Scene
from slipwave.solve import Leaping
from validation.chart import GREY, GUIDE, POINTS, Chart, Look, Panel, Scale, SecondScale, Trace, outline
from validation.commands.reasons import PREFIXES, power_of
from validation.data.variables import INTERFACE, si_factor, stored_name
from validation.models.run import Run, second_half

_SCALES = {
    "time": Scale("time / transits"),
    "stress": Scale("friction stress / normal stress"),
    "slip_rate": Scale("slip rate / V*", "log"),
}
_SI_LABELS = {"time": "time / s", "stress": "friction stress / {}Pa", "slip_rate": "slip rate / (m/s)"}
_STRESS = 0.2  # of the normal stress: a small friction stress, by which the prefix of Pa is chosen


def scale_of(name: str, scene: Scene) -> Scale:
    """The scale of a quantity, with one in SI for a scene with units."""
    size = si_factor(INTERFACE[stored_name(name)], scene)
    if size is None:
        return _SCALES[name]
    power = power_of(_STRESS * size) if name == "stress" else 0
    return replace(_SCALES[name], second=SecondScale(_SI_LABELS[name].format(PREFIXES[power]), size / 10.0**power))


def for_rates(scale: Scale, rates: Iterable[Array]) -> Scale:
    """The logarithmic `scale` for these slip rates: linear about zero if slip rests or reverses."""
    return scale if all((values > 0.0).all() for values in rates) else replace(scale, kind="symlog")


def run_chart(run: Run, motion: Envelope, stages: Sequence[StageFigures] | None) -> Chart:
    """The `motion` of a run: as `protocol_chart` if it has `stages`, else as `motion_chart`."""
    scene, model = run.solver.scene, run.solver.model
    if stages is not None:
        chart = _protocol_chart(scene, model, motion, stages)
    else:
        title, curve = f"{scene.name}, {model}: {run.kind or 'events not watched'}", motion.by_time()
        chart = motion_chart(scene, title, curve.time, curve.stress, curve.rate)
    if isinstance(run.solver, Leaping) and run.solver.skipped:
        share = run.solver.skipped / run.solver.time
        text = f"leaps left out {share:.0%} of the run's transits: there the ranges of those before and after are joined"
        return replace(chart, title=f"{chart.title}\n{text}")
    return chart


def motion_chart(scene: Scene, title: str, time: Array, stress: Ranges, rate: Ranges) -> Chart:
    """Ranges of the stress and of the slip rate over time (transits)."""
    panels = (
        Panel("", scale_of("time", scene), scale_of("stress", scene), _within(time, stress)),
        Panel("", _SCALES["time"], for_rates(scale_of("slip_rate", scene), rate), _within(time, rate)),
    )
    return Chart(panels, 5.2, title=title)


def _within(positions: Array, ranges: Ranges) -> list[Trace]:
    """Ranges over `positions`: a line where they are narrow."""
    low, high = ranges
    lines = [Trace(name, positions, values, Look(width=0.9)) for name, values in (("least", low), ("largest", high))]
    return [Trace("", *outline(positions, low, high), Look("#a8a8a4", kind="area")), *lines]


def _protocol_chart(scene: Scene, model: str, motion: Envelope, stages: Sequence[StageFigures]) -> Chart:
    """The `motion` of a run over time and over slip. Grey lines mark the beginnings of the `stages`.

    In s, um and Pa if the scene has units, else in L/V* and L.
    """
    units = scene.units
    second, length, names = (units.time, 1e6 * units.memory_length, ("s", "um")) if units else (1.0, 1.0, ("L/V*", "L"))
    curve, along = motion.by_time(), motion.by_slip()
    times = np.array([stage.start for stage in stages[1:]])
    slips, second = np.interp(times, curve.time, curve.slip), second * scene.transit

    def marks(places: Array) -> list[Trace]:
        return [Trace("", [place] * 2, [-np.inf, np.inf], GUIDE.but(color="#bbbbbb")) for place in places.tolist()]

    panels = [
        Panel("", Scale(label), scale_of("stress", scene), [*marks(size * begins), *_within(size * positions, ranges)])
        for label, size, positions, begins, ranges in (
            (f"time / {names[0]}", second, curve.time, times, curve.stress),
            (f"slip of the interface / {names[1]}", length, along.slip, slips, along.stress),
        )
    ]
    return Chart(panels, 5.2, title=f"{scene.name}, {model}")


def return_map(run: Run) -> Chart:
    """One point per cycle of the run's second half but the first, and the line on which cycles repeat: one point if they do, as
    many as there are events in a period, a closed curve on a torus, a curve or a cloud if they are irregular.

    Raises SceneError for fewer than two cycles."""
    period = run.events.period[run.events.time >= second_half(run.solver, run.until)]
    if period.size < 2:
        raise SceneError("a return map needs two complete cycles in the second half of the run")
    margin = max(0.05 * np.ptp(period), REPEATS * period.mean())  # the rounding of periods that repeat is no cloud
    ends = float(period.min() - margin), float(period.max() + margin)
    cycles = Trace("cycles", period[:-1], period[1:], POINTS.but(size=2.0))
    repeats = Trace("repeats", [-np.inf, np.inf], [-np.inf, np.inf], GUIDE.but(color=GREY))
    x, y = Scale("period / transits", limits=ends), Scale("next period / transits", limits=ends)
    title = f"{run.solver.scene.name}, {run.solver.model}: {run.kind}"
    return Chart([Panel("", x, y, [cycles, repeats], grid=True)], 4.6, width=4.6, title=title)
