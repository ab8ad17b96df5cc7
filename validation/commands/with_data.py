"""Compares a record with models' runs: a table of its cycles with their scatter, and its cycles over those of the models."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from slipwave.observe import RunStatistics
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.chart import Chart, Look, Panel, Scale, Trace, color_number, outline
from validation.commands.figures import for_rates
from validation.commands.result import aligned, rounded
from validation.data.record_events import MeasuredMotion, slip_events
from validation.data.variables import EVENTS, cycle_in_si, shown_in
from validation.models.cycle import OneCycle

FIGURES_OF_CYCLES = ("period", "stress_drop", "v_max")
"""The figures in which a record and a run are compared."""

_APART = 0.02  # relative difference of friction's and elastic stress drop that is noted
_GRID = 600  # points of a half cycle
_AROUND = 8.0  # durations of the fast slip that the right column shows on each side


class _Averaged(NamedTuple):
    """Cycles over time since the event (transits): friction minus its mean `level`, its standard deviation from cycle to cycle (0
    for one cycle), and the slip rate (V*)."""

    time: Array
    friction: Array
    scatter: Array
    slip_rate: Array
    level: float


def facts_of_data(motion: MeasuredMotion, scene: Scene) -> dict[str, Any]:
    """Facts of the record: mean, standard deviation and number of its cycles' figures, and the effect of smoothing on them."""
    means = {name: _spread(getattr(motion.events, name)) for name in FIGURES_OF_CYCLES}
    values = {name: float(figure["mean"]) for name, figure in means.items()}
    deviations = {f"{name}_std": float(means[name]["std"]) for name in FIGURES_OF_CYCLES[:2]}
    facts = {"source": motion.source, "events": motion.dates.size, **means, "slip_rate_from": motion.rate_from}
    facts |= {"early": motion.early, "noise": motion.noise, "smoothing": motion.smoothing}
    return facts | cycle_in_si(values | deviations, scene)


def _spread(values: Array) -> dict[str, float]:
    return {"mean": float(values.mean()), "std": float(values.std(ddof=1)) if values.size > 1 else math.nan, "n": values.size}


def distances_from_data(ours: RunStatistics, data: Mapping[str, Any]) -> dict[str, float | None]:
    """The relative distance of a model's figures, means over its cycles as those of the record, from the record's; None where the
    model has no cycles."""
    means = {name: float(spread.mean) for name, spread in ours.spreads.items()} | {"v_max": ours.v_max_mean}
    return {name: None if math.isnan(means[name]) else means[name] / data[name]["mean"] - 1.0 for name in FIGURES_OF_CYCLES}


def data_lines(summary: Mapping[str, Any], scene: Scene) -> Iterator[str]:
    """Lines of the table of the record and the models, and of how events were detected in the record."""
    data = summary["data"]
    units = {name: shown_in(EVENTS[name].unit, scene) for name in FIGURES_OF_CYCLES}
    units["stress_drop"] = 1.0, "normal stress"
    heading = ["", "cycles", *(f"{name.replace('_', ' ')} / ({unit})" for name, (_, unit) in units.items())]
    spreads = [(data[name]["mean"], data[name]["std"], units[name][0]) for name in FIGURES_OF_CYCLES]
    bars = [f"{mean * size:.5g} +- {rounded(None if std is None else std * size, 2)}" for mean, std, size in spreads]
    rows = [[data["source"], f"{data['period']['n']}", *bars]]
    for row in summary["models"]:
        cells = []
        for name in FIGURES_OF_CYCLES:
            mean, apart = data[name]["mean"] * units[name][0], row["against_data"][name]
            cells.append("-" if apart is None else f"{mean * (1.0 + apart):.5g} ({100.0 * apart:+.2g} %)")
        rows.append([row["model"], "", *cells])
    yield ""
    yield from aligned(heading, rows)
    for row in summary["models"]:
        drop, elastic = row["stress_drop"]["mean"], row["elastic_stress_drop"]["mean"]
        if drop is not None and abs(elastic / drop - 1.0) > _APART:
            yield f"{row['model']}: its elastic stress, which a load cell in the drive measures, drops by {elastic:.5g}"
    yield "+-: standard deviation from cycle to cycle; in brackets: the model's distance from the record's mean"
    if data["early"]:
        yield f"the record's first cycles, in which the motion settles, are left out: {data['early']}"
    smoothing = data["smoothing"]
    noise = f"noise of friction {data['noise']:.2g}" if data["noise"] else "no noise"
    text = f"slip rate from {data['slip_rate_from']}; {noise}; smoothed by a parabola over {smoothing['samples']} samples"
    yield text if smoothing["samples"] > 1 else text.rpartition(";")[0] + "; not smoothed"
    yield from _effect_in_words(smoothing, scene)


def _effect_in_words(smoothing: Mapping[str, Any], scene: Scene) -> Iterator[str]:
    """Text on the change by half the smoothing, and on events in the smoothed record."""
    if smoothing["samples"] == 1:
        return
    changes = ", ".join(f"{name.replace('_', ' ')} {100.0 * smoothing[name]:.2g} %" for name in FIGURES_OF_CYCLES[1:])
    yield f"with half as many, means change by: {changes}"
    if smoothing["apart"]:
        yield f"the smoothed record has {smoothing['apart']:+d} events: the number of events depends on the smoothing"
    else:
        size, unit = shown_in("transit", scene)
        moved = f"at most {smoothing['dates'] * size:.2g} {unit}, the mean period by {100.0 * smoothing['period']:.2g} %"
        yield f"events are dated in the record as it is; smoothed, it would move dates by {moved}"


def _averaged(motion: MeasuredMotion, most: float) -> _Averaged:
    """Average of the record's cycles around their events, up to `most` transits on both sides, over a common time."""
    reach = min(most, 0.5 * float(motion.events.period.min()))
    step = float(np.median(np.diff(motion.time)))
    half = np.unique(np.concatenate((np.linspace(0.0, reach, _GRID), np.geomspace(min(step, 0.1 * reach), reach, _GRID))))
    time = np.concatenate((-half[:0:-1], half))
    inside = motion.dates[(motion.dates - reach >= motion.time[0]) & (motion.dates + reach <= motion.time[-1])]
    friction = np.array([np.interp(date + time, motion.time, motion.friction) for date in inside])
    rate = np.array([np.interp(date + time, motion.time, motion.slip_rate) for date in inside])
    mean = friction.mean(axis=0)
    level = float(np.trapezoid(mean, time) / (time[-1] - time[0]))
    scatter = friction.std(axis=0, ddof=1) if len(inside) > 1 else np.zeros_like(mean)
    return _Averaged(time, mean - level, scatter, rate.mean(axis=0), level)


def _centred(cycle: OneCycle, time: Array, stress: Array) -> _Averaged:
    """A model's cycle, with one of its `stress`es as friction, at `time` since its event; its second half precedes the event."""
    phase = np.concatenate((cycle.time - cycle.period, cycle.time))
    rate = np.tile(cycle.slip_rate, 2)
    slip = np.cumsum(rate * np.gradient(phase))
    phase -= min(slip_events(phase, np.tile(cycle.stress, 2), slip).date, key=abs, default=0.0)  # dated as the record
    friction = np.interp(time, phase, np.tile(stress, 2))
    rate = np.exp(np.interp(time, phase, np.log(rate))) if (rate > 0.0).all() else np.interp(time, phase, rate)
    level = float(np.trapezoid(friction, time) / (time[-1] - time[0]))
    return _Averaged(time, friction - level, np.zeros_like(friction), rate, level)


def chart_with_data(motion: MeasuredMotion, cycles: Sequence[tuple[str, OneCycle | None]], scene: Scene) -> Chart:
    """Friction, residual and slip rate over the time since the event: the whole cycle, and the event alone. The record is
    black, its scatter from cycle to cycle grey, a model's elastic stress dashed."""
    shortest = min([float(motion.events.period.min()), *(cycle.period for _, cycle in cycles if cycle)])
    data = _averaged(motion, 0.5 * shortest)
    (size, unit), (pace, speed) = shown_in("transit", scene), shown_in("V*", scene)
    fast = data.time[data.slip_rate > 0.5 * data.slip_rate.max()]
    zoom = min(_AROUND * max(float(np.ptp(fast)), 4.0 * float(np.median(np.diff(motion.time)))), data.time[-1])
    time, reached = size * data.time, np.where(data.slip_rate > 0.0, pace * data.slip_rate, math.nan)
    record = f"{motion.source}: {motion.events.period.size} cycles"
    rows = [
        [_scatter(time, data.friction, data.scatter), Trace(record, time, data.friction)],
        [_scatter(time, 0.0 * data.friction, data.scatter)],
        [Trace(record, time, reached, Look(width=0.8))],
    ]
    for number, (model, cycle) in enumerate(cycles):
        for row, traces in zip(rows, _of_model(model, cycle, data, (size, pace), color_number(number)), strict=True):
            row += traces
    labels = "friction less its mean", "record - model", f"slip rate / ({speed})"
    panels, rates = [], [cycle.slip_rate for _, cycle in cycles if cycle]
    for label, row in zip(labels, rows, strict=True):
        for title, reach in (("whole cycle", data.time[-1]), ("slip event", zoom)):
            along = Scale(f"time since the slip event / {unit}", limits=(-size * reach, size * reach))
            up = for_rates(Scale(label, "log"), rates) if row is rows[-1] else Scale(label)
            panels.append(Panel(title if row is rows[0] else "", along, up, row))
    heights = (2.0, 1.0, 2.0)
    return Chart(panels, 7.0, 2, 9.0, heights=heights, legend="outside upper left", legend_columns=3, keys=rows[0])


def _scatter(time: Array, middle: Array, half: Array) -> Trace:
    """The scatter of the record from cycle to cycle."""
    return Trace("", *outline(time, middle - half, middle + half), Look("#cccccc", kind="area"))


def _of_model(
    model: str, cycle: OneCycle | None, data: _Averaged, sizes: tuple[float, float], color: str
) -> tuple[list[Trace], list[Trace], list[Trace]]:
    """A model's friction, the residual of the record, and its slip rate."""
    look = Look(color, width=1.2)
    if cycle is None:
        return [Trace(f"{model}: no cycles", [], [], look)], [], []
    time, ours = sizes[0] * data.time, _centred(cycle, data.time, cycle.stress)
    elastic, dashed = _centred(cycle, data.time, cycle.elastic_stress).friction, look.but(dashes=(0, (4, 2)), width=1.0)
    name, other = f"{model}, friction shifted by {data.level - ours.level:+.3g}", f"{model}, elastic stress"
    return (
        [Trace(name, time, ours.friction, look), Trace(other, time, elastic, dashed)],
        [Trace(name, time, data.friction - ours.friction, look), Trace(other, time, data.friction - elastic, dashed)],
        [Trace(name, time, sizes[1] * ours.slip_rate, look)],
    )
