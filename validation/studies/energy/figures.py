"""The ledger's entries over time, and how far it fails to close over cells."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from slipwave.observe.pieces import Array
from validation.studies.energy.runs import ENTRIES, History
from validation.study.drawing import WIDTH, canvas, grid_pens

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PENS = {
    "input": ("#111111", "-"),
    "friction": ("#d55e00", (0, (5, 1.5))),
    "stored": ("#0072b2", (0, (1.2, 1.2))),
    "radiated": ("#009e73", "-"),
    "viscous": ("#cc4f8a", (0, (5, 1.5))),
}
_FLOOR = 1e-16


def histories(shown: Mapping[str, History]) -> "Figure":
    """A column per scene: large entries above, small ones below."""
    figure = canvas(WIDTH, 4.8)
    grid = figure.subplots(2, len(shown), sharex="col", sharey="row", gridspec_kw={"height_ratios": (2.0, 1.0)})
    for column, (name, history) in zip(grid.T, shown.items(), strict=True):
        for axes, entries in zip(column, (ENTRIES[:3], ENTRIES[3:]), strict=True):
            for entry in entries:
                color, dashes = _PENS[entry]
                axes.plot(history.time, history.entries[entry], color=color, linestyle=dashes, label=entry)
        column[0].set_title(name)
        column[1].set_xlabel("time (transits)")
    for axes in grid[:, 0]:
        axes.set_ylabel(r"energy $/\sigma L$")
    handles = [*grid[0, 0].get_lines(), *grid[1, 0].get_lines()]
    figure.legend(handles, ENTRIES, loc="outside upper left", ncols=5, handlelength=3.0)
    return figure


def closure(curves: Mapping[str, tuple[Array, Array]]) -> "Figure":
    """`curves`: family -> (cells per slab, residual)."""
    figure = canvas(WIDTH, 3.6)
    axes = figure.subplots()
    for model, look in grid_pens(curves).items():
        cells, residual = curves[model]
        shown = np.maximum(residual, _FLOOR)
        axes.loglog(cells, shown, color=look.color, marker=look.marker, linestyle=look.dashes, label=model)
    axes.set(xlabel="cells per slab", ylabel="residual")
    axes.grid(True)
    figure.legend(loc="outside right center")
    return figure
