"""Pictures for the paper's claims."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from slipwave.observe.pieces import Array
from validation.study.drawing import WIDTH, canvas, pen

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def irregular(runs: Mapping[str, tuple[Array, Array]]) -> "Figure":
    """Stress over time, one panel per model."""
    figure = canvas(WIDTH, 3.6)
    grid = figure.subplots(len(runs), 1, sharex=True, sharey=True)
    for axes, (model, (time, stress)) in zip(grid, runs.items(), strict=True):
        style = pen(model)
        axes.plot(time, stress, color=style.color, linewidth=0.7)
        axes.set_title(style.label, fontsize=11)
        axes.set(ylabel=r"$\mu$", xlim=(time[0], time[-1]))
    grid[-1].set_xlabel("time (transits)")
    return figure


def returns(cycles: Mapping[str, tuple[Array, Array]]) -> "Figure":
    """`cycles`: model -> (periods, stress drops), each over that of the cycle before."""
    figure = canvas(WIDTH, 3.6)
    panels = figure.subplots(1, 2)
    for model, columns in cycles.items():
        style = pen(model)
        for axes, values in zip(panels, columns, strict=True):
            axes.plot(
                values[:-1], values[1:], style.marker, color=style.color, markersize=3.0, linestyle="none", label=style.label
            )
    for axes, symbol in zip(panels, ("$T$ (transits)", r"$\Delta\mu$"), strict=True):
        axes.set(xlabel=f"{symbol} of one cycle", ylabel="of the next")
        axes.grid(True)
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=2)
    return figure
