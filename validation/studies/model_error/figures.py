"""Errors of period and drop over r, one line per reduction."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from slipwave.observe.pieces import Array
from validation.study.drawing import WIDTH, canvas, pen

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def errors_over_r(curves: Mapping[str, tuple[Array, Array, Array]]) -> "Figure":
    """`curves`: model -> (log10 r, error of the period, error of the drop); NaN leaves a gap."""
    figure = canvas(WIDTH, 4.4)
    panels = figure.subplots(1, 2, sharey=True)
    for model, (log10_r, *errors) in curves.items():
        look = pen(model)
        for axes, error in zip(panels, errors, strict=True):
            axes.semilogy(
                log10_r, error, color=look.color, linestyle=look.dashes, marker=look.marker, linewidth=1.1, label=look.label
            )
    for axes, title in zip(panels, ("period $T$", r"stress drop $\Delta\mu$"), strict=True):
        axes.set(title=title, xlabel=r"$\log_{10} r$")
        axes.grid(True)
        axes.set_axisbelow(True)
    panels[0].set_ylabel("relative error")
    figure.legend(handles=panels[0].get_lines(), loc="outside upper left", ncols=4, handlelength=3.0)
    return figure
