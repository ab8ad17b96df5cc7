"""A protocol as a laboratory draws it: friction against time and against slip of the interface."""

from collections.abc import Sequence

import numpy as np

from slipwave.files import TIME
from slipwave.observe.stages import StageFigures
from slipwave.scene import Scene
from validation.door.motion_figure import second_axis
from validation.door.result import Dataset
from validation.study.drawing import Drawing, canvas


def protocol_figure(scene: Scene, model: str, data: Dataset, stages: Sequence[StageFigures]) -> Drawing:
    """The history of the interface in the `data` of a run. Grey lines mark the beginnings of the `stages`.

    In s, um and Pa if the scene has units, else in L/V* and L. Call it inside `styled()`.
    """
    units = scene.units
    second, length, names = (units.time, 1e6 * units.memory_length, ("s", "um")) if units else (1.0, 1.0, ("L/V*", "L"))
    clock, rate = data[TIME].values * scene.transit, data["interface_slip_rate"].values
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.maximum(np.diff(clock), 0.0)
    slip = np.concatenate(([0.0], np.cumsum(steps)))
    begins = np.array([stage.start for stage in stages[1:]]) * scene.transit
    figure = canvas(height=5.2)
    by_time, by_slip = figure.subplots(2, 1)
    for axes, places, size, label in (
        (by_time, clock, second, f"time / {names[0]}"),
        (by_slip, slip, length, f"slip of the interface / {names[1]}"),
    ):
        for begin in np.interp(begins, clock, places):
            axes.axvline(begin * size, color="#bbbbbb", linewidth=0.8)
        axes.plot(places * size, data["interface_stress"].values, color="#111111", linewidth=0.9)
        axes.set(xlabel=label, ylabel="friction stress / normal stress")
        second_axis(axes, "y", "stress", scene)
    by_time.set_title(f"{scene.name}, {model}")
    return figure
