"""Work-precision diagram: one line per model, labelled where it ends."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from validation.study.drawing import WIDTH, canvas, pen
from validation.work_precision import Point

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FLOOR = 1e-13


def work_precision(points: Sequence[Point]) -> "Figure":
    """Error of the period over run time, both logarithmic."""
    figure = canvas(WIDTH, 4.6)
    axes = figure.add_subplot()
    for name in dict.fromkeys((point.setting.model, point.setting.cfl) for point in points):
        chosen = [point for point in points if (point.setting.model, point.setting.cfl) == name]
        style = pen(name[0])
        half = name[1] is not None and name[1] < 1.0
        axes.loglog(
            [1e3 * point.seconds for point in chosen],
            [max(_FLOOR, abs(point.period_error)) for point in chosen],
            color=style.color,
            linestyle="-" if name[0] in ("delay", "fd") else style.dashes,
            linewidth=1.0,
            marker=style.marker,
            markerfacecolor="white" if half else style.color,
            label=style.label + (f", CFL {name[1]:g}" if name[1] else ""),
        )
    axes.grid(True)
    axes.set_axisbelow(True)
    axes.set_xlabel("run time (ms)")
    axes.set_ylabel("relative error of the period")
    figure.legend(loc="outside right center")
    return figure
