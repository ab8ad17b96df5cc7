"""Compares a record with models' runs: a table of its cycles with their scatter, and its cycles over those of the models."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np

from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.data.events import MeasuredMotion, slip_events
from validation.measure.cycle import OneCycle
from validation.results.quantities import EVENTS, cycle_in_si, shown_in
from validation.results.result import aligned, rounded
from validation.study.drawing import Axes, Drawing, canvas

FIGURES_OF_CYCLES = ("period", "stress_drop", "v_max")
"""The figures in which a record and a run are compared."""

_APART = 0.02  # relative difference of friction's and elastic stress drop that is noted
_GRID = 600  # points of a half cycle
_AROUND = 8.0  # durations of the fast slip that the right column shows on each side


class Averaged(NamedTuple):
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
    values = {name: float(one["mean"]) for name, one in means.items()}
    deviations = {f"{name}_std": float(means[name]["std"]) for name in FIGURES_OF_CYCLES[:2]}
    facts = {"source": motion.source, "events": motion.dates.size, **means, "slip_rate_from": motion.rate_from}
    facts |= {"noise": motion.noise, "smoothing": asdict(motion.smoothing)}
    return facts | cycle_in_si(values | deviations, scene)


def _spread(values: Array) -> dict[str, float]:
    return {"mean": float(values.mean()), "std": float(values.std(ddof=1)) if values.size > 1 else math.nan, "n": values.size}


def distances_from_data(row: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, float | None]:
    """The relative distance of a model's figures from the means of the record; None where the model has no cycles."""
    ours = {name: row[name]["mean"] if isinstance(row[name], Mapping) else row[name] for name in FIGURES_OF_CYCLES}
    return {
        name: None if value is None or math.isnan(value) else value / data[name]["mean"] - 1.0 for name, value in ours.items()
    }


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
            value, apart = row[name]["mean"] if isinstance(row[name], Mapping) else row[name], row["against_data"][name]
            cells.append("-" if value is None or apart is None else f"{value * units[name][0]:.5g} ({100.0 * apart:+.2g} %)")
        rows.append([row["model"], "", *cells])
    yield ""
    yield from aligned(heading, rows)
    for row in summary["models"]:
        drop, elastic = row["stress_drop"]["mean"], row["elastic_stress_drop"]["mean"]
        if drop is not None and abs(elastic / drop - 1.0) > _APART:
            yield f"{row['model']}: its elastic stress, which a load cell in the drive measures, drops by {elastic:.5g}"
    yield "+-: standard deviation from cycle to cycle; in brackets: the model's distance from the record's mean"
    smoothing = data["smoothing"]
    noise = f"noise of friction {data['noise']:.2g}" if data["noise"] else "no noise"
    text = f"slip rate from {data['slip_rate_from']}; {noise}; smoothed by a parabola over {smoothing['samples']} samples"
    yield text if smoothing["samples"] > 1 else text.rpartition(";")[0] + "; not smoothed"
    yield from effect_in_words(smoothing, scene)


def effect_in_words(smoothing: Mapping[str, Any], scene: Scene) -> Iterator[str]:
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


def averaged(motion: MeasuredMotion, most: float) -> Averaged:
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
    return Averaged(time, mean - level, scatter, rate.mean(axis=0), level)


def centred(cycle: OneCycle, time: Array, stress: Array) -> Averaged:
    """A model's cycle, with one of its `stress`es as friction, at `time` since its event; its second half precedes the event."""
    phase = np.concatenate((cycle.time - cycle.period, cycle.time))
    phase -= min(slip_events(phase, np.tile(cycle.stress, 2)).date, key=abs, default=0.0)  # dated as the record
    friction = np.interp(time, phase, np.tile(stress, 2))
    rate = np.exp(np.interp(time, phase, np.tile(np.log(np.abs(cycle.slip_rate)), 2)))
    level = float(np.trapezoid(friction, time) / (time[-1] - time[0]))
    return Averaged(time, friction - level, np.zeros_like(friction), rate, level)


def draw_with_data(motion: MeasuredMotion, cycles: Sequence[tuple[str, OneCycle | None]], scene: Scene) -> Drawing:
    """Draw friction, residual and slip rate over the time since the event: the whole cycle, and the event alone. The record is
    black, its scatter from cycle to cycle grey, a model's elastic stress dashed. Call it inside `styled()`."""
    shortest = min([float(motion.events.period.min()), *(cycle.period for _, cycle in cycles if cycle)])
    data = averaged(motion, 0.5 * shortest)
    (size, unit), (pace, speed) = shown_in("transit", scene), shown_in("V*", scene)
    fast = data.time[data.slip_rate > 0.5 * data.slip_rate.max()]
    zoom = min(_AROUND * max(float(np.ptp(fast)), 4.0 * float(np.median(np.diff(motion.time)))), data.time[-1])
    figure = canvas(9.0, 7.0)
    panels = figure.subplots(3, 2, sharex="col", sharey="row", height_ratios=[2.0, 1.0, 2.0])
    for column, reach in enumerate((data.time[-1], zoom)):
        above, _, below = panels[:, column]
        _draw_cycles(panels[:, column], f"{motion.source}: {motion.events.period.size} cycles", data, (size, pace))
        for model, cycle in cycles:
            _draw_model(panels[:, column], model, cycle, data, (size, pace))
        below.set(xlabel=f"time since the slip event / {unit}", xlim=(-size * reach, size * reach), yscale="log")
        above.set_title(("whole cycle", "slip event")[column], fontsize="medium")
    for axes, name in zip(panels[:, 0], ("friction less its mean", "record - model", f"slip rate / ({speed})"), strict=True):
        axes.set_ylabel(name)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize="small")
    return figure


def _draw_cycles(panels: Sequence[Axes], label: str, data: Averaged, sizes: tuple[float, float]) -> None:
    """Draw the record and its scatter from cycle to cycle."""
    time = sizes[0] * data.time
    for axes, middle in zip(panels, (data.friction, 0.0 * data.friction), strict=False):
        axes.fill_between(time, middle - data.scatter, middle + data.scatter, color="#cccccc", linewidth=0.0)
    panels[0].plot(time, data.friction, color="#111111", label=label)
    panels[2].plot(time, np.where(data.slip_rate > 0.0, sizes[1] * data.slip_rate, math.nan), color="#111111", linewidth=0.8)


def _draw_model(panels: Sequence[Axes], model: str, cycle: OneCycle | None, data: Averaged, sizes: tuple[float, float]) -> None:
    """Draw a model's cycle, and the residual of the record."""
    if cycle is None:
        panels[0].plot([], [], label=f"{model}: no cycles")
        return
    time, ours = sizes[0] * data.time, centred(cycle, data.time, cycle.stress)
    label = f"{model}, friction shifted by {data.level - ours.level:+.3g}"
    (line,) = panels[0].plot(time, ours.friction, label=label, linewidth=1.2)
    look: Any = {"color": line.get_color(), "linewidth": 1.0}
    elastic, dashes = centred(cycle, data.time, cycle.elastic_stress).friction, (0, (4, 2))
    panels[0].plot(time, elastic, linestyle=dashes, label=f"{model}, elastic stress", **look)
    panels[1].plot(time, data.friction - ours.friction, **look)
    panels[1].plot(time, data.friction - elastic, linestyle=dashes, **look)
    panels[2].plot(time, sizes[1] * ours.slip_rate, **look)
