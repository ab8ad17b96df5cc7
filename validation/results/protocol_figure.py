"""A protocol as a laboratory draws it: friction against time and against slip of the interface."""

from collections.abc import Sequence

import numpy as np

from slipwave.observe.envelope import Envelope
from slipwave.observe.stages import StageFigures
from slipwave.scene import Scene
from validation.results.motion_figure import band, second_axis
from validation.study.drawing import Drawing, canvas


def protocol_figure(scene: Scene, model: str, motion: Envelope, stages: Sequence[StageFigures]) -> Drawing:
    """The `motion` of a run. Grey lines mark the beginnings of the `stages`.

    In s, um and Pa if the scene has units, else in L/V* and L. Call it inside `styled()`.
    """
    units = scene.units
    second, length, names = (units.time, 1e6 * units.memory_length, ("s", "um")) if units else (1.0, 1.0, ("L/V*", "L"))
    curve, along = motion.by_time(), motion.by_slip()
    begins = np.array([stage.start for stage in stages[1:]])
    figure = canvas(height=5.2)
    by_time, by_slip = figure.subplots(2, 1)
    for axes, places, marks, ranges, label in (
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
        band(axes, places, ranges)
        axes.set(xlabel=label, ylabel="friction stress / normal stress")
        second_axis(axes, "y", "stress", scene)
    by_time.set_title(f"{scene.name}, {model}")
    return figure
