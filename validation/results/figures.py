"""Figures of runs and orbits: the motion of the interface with SI axes where the scene has units, a protocol over time and slip,
and the return map."""

from collections.abc import Sequence

import numpy as np

from slipwave.errors import SceneError
from slipwave.observe.envelope import Envelope, Ranges
from slipwave.observe.pieces import Array
from slipwave.observe.stages import StageFigures
from slipwave.scene import Scene
from slipwave.solve import Leaping
from validation.compute.run import Run, second_half
from validation.results.quantities import INTERFACE, si_factor, stored_name
from validation.results.reasons import PREFIXES, power_of
from validation.study.drawing import Axes, Drawing, canvas, styled, subplots

_LABELS = {"time": "time / transits", "stress": "friction stress / normal stress", "slip_rate": "slip rate / V*"}
_SI_LABELS = {"time": "time / s", "stress": "friction stress / {}Pa", "slip_rate": "slip rate / (m/s)"}
_STRESS = 0.2  # of the normal stress: a small friction stress, by which the prefix of Pa is chosen


def run_figure(run: Run, motion: Envelope, stages: Sequence[StageFigures] | None) -> Drawing:
    """The `motion` of a run: as `protocol_figure` if it has `stages`, else as `motion_figure`."""
    scene, model = run.solver.scene, run.solver.model
    with styled():
        if stages is not None:
            figure = protocol_figure(scene, model, motion, stages)
        else:
            title, curve = f"{scene.name}, {model}: {run.kind or 'events not watched'}", motion.by_time()
            figure = motion_figure(scene, title, curve.time, curve.stress, curve.rate)
        if isinstance(run.solver, Leaping) and run.solver.skipped:
            share = run.solver.skipped / run.solver.time
            text = f"leaps left out {share:.0%} of the run's transits: there the ranges of those before and after are joined"
            figure.supxlabel(text, fontsize=8.5, color="#666666")
        return figure


def motion_figure(scene: Scene, title: str, time: Array, stress: Ranges, rate: Ranges) -> Drawing:
    """Draw ranges of the stress and of the slip rate over time (transits). Call it inside `styled()`."""
    figure = canvas(height=5.2)
    above, below = figure.subplots(2, 1, sharex=True)
    above.set(title=title, ylabel=_LABELS["stress"])
    below.set(ylabel=_LABELS["slip_rate"], xlabel=_LABELS["time"], yscale="log")
    second_axis(above, "x", "time", scene)
    second_axis(above, "y", "stress", scene)
    second_axis(below, "y", "slip_rate", scene)
    band(above, time, stress)
    band(below, time, rate)
    return figure


def band(axes: Axes, positions: Array, ranges: Ranges) -> None:
    """Draw ranges over `positions`: a line where they are narrow."""
    low, high = ranges
    axes.fill_between(positions, low, high, color="#a8a8a4", linewidth=0.0)
    axes.plot(positions, low, positions, high, color="#111111", linewidth=0.9)


def second_axis(axes: Axes, direction: str, name: str, scene: Scene) -> None:
    """Add an axis in SI opposite that of a quantity; nothing for a scene without units."""
    size = si_factor(INTERFACE[stored_name(name)], scene)
    if size is None:
        return
    power = power_of(_STRESS * size) if name == "stress" else 0
    factor = size / 10.0**power
    functions = (lambda values: values * factor, lambda values: values / factor)
    second = axes.secondary_xaxis("top", functions) if direction == "x" else axes.secondary_yaxis("right", functions)
    (second.set_xlabel if direction == "x" else second.set_ylabel)(_SI_LABELS[name].format(PREFIXES[power]))


def protocol_figure(scene: Scene, model: str, motion: Envelope, stages: Sequence[StageFigures]) -> Drawing:
    """Draw the `motion` of a run. Grey lines mark the beginnings of the `stages`.

    In s, um and Pa if the scene has units, else in L/V* and L. Call it inside `styled()`.
    """
    units = scene.units
    second, length, names = (units.time, 1e6 * units.memory_length, ("s", "um")) if units else (1.0, 1.0, ("L/V*", "L"))
    curve, along = motion.by_time(), motion.by_slip()
    begins = np.array([stage.start for stage in stages[1:]])
    figure = canvas(height=5.2)
    by_time, by_slip = figure.subplots(2, 1)
    for axes, positions, marks, ranges, label in (
        (by_time, second * scene.transit * curve.time, second * scene.transit * begins, curve.stress, f"time / {names[0]}"),
        (
            by_slip,
            length * along.slip,
            length * np.interp(begins, curve.time, curve.slip),
            along.stress,
            f"slip of the interface / {names[1]}",
        ),
    ):
        for mark in marks:
            axes.axvline(mark, color="#bbbbbb", linewidth=0.8)
        band(axes, positions, ranges)
        axes.set(xlabel=label, ylabel="friction stress / normal stress")
        second_axis(axes, "y", "stress", scene)
    by_time.set_title(f"{scene.name}, {model}")
    return figure


def return_map(run: Run) -> Drawing:
    """Draw one point per cycle of the run's second half but the first, and the line on which cycles repeat: one point if they do,
    as many as there are events in a period, a closed curve on a torus, a curve or a cloud if they are irregular.

    Raises SceneError for fewer than two cycles."""
    period = run.events.period[run.events.time >= second_half(run.solver, run.until)]
    if period.size < 2:
        raise SceneError("a return map needs two complete cycles in the second half of the run")
    with styled():
        figure, axes = subplots(4.6, x="period / transits", y="next period / transits", width=4.6)
        axes.plot(period[:-1], period[1:], ".", color="#111111", markersize=3.5)
        axes.axline((float(period[0]), float(period[0])), slope=1.0, color="#777777", linewidth=0.7)
        axes.set_title(f"{run.solver.scene.name}, {run.solver.model}: {run.kind}")
        axes.grid(True)
        axes.set_aspect("equal", adjustable="datalim")
        return figure
