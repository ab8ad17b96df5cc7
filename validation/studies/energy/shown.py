"""Tables and pictures of the ledger: shares of the work, entries over time, how far it fails to close."""

from collections.abc import Mapping

import numpy as np

from slipwave.observe.pieces import Array
from validation.measure.order_fit import Fit
from validation.studies.energy.runs import BOUNDARIES, ENTRIES, HIGH, LADDERS, UNTIL, History
from validation.studies.energy.verdicts import with_interval
from validation.study import Cell, Table, table
from validation.study.drawing import WIDTH, Drawing, canvas, grid_pens
from validation.study.text import plain

_PENS = {
    "input": ("#111111", "-"),
    "friction": ("#d55e00", (0, (5, 1.5))),
    "stored": ("#0072b2", (0, (1.2, 1.2))),
    "radiated": ("#009e73", "-"),
    "viscous": ("#cc4f8a", (0, (5, 1.5))),
}
_FLOOR = 1e-16


def shares_table(shown: dict[str, History]) -> Table:
    """Where the drive's work goes."""
    shares = ENTRIES[1:]
    heading = ["scene", "T [transits] .3f", "input [σL] .5g", *(f"{entry} [% of input] .4g" for entry in shares)]
    rows: list[tuple[Cell, ...]] = [
        (name, history.period, history.total("input"), *(100.0 * history.share(entry) for entry in shares))
        for name, history in shown.items()
    ]
    caption = (
        "Where the drive’s work of two cycles goes, on the settled orbit, by `dg:7`: the paper’s scene; slabs held by grips that "
        "reflect half of every wave; Kelvin–Voigt slabs. The stored energy returns to its first value, up to the sampling in "
        "time."
    )
    return table("shares", caption, " | ".join(heading), rows)


def residual_table(residuals: dict[str, Array], orders: dict[str, Fit]) -> Table:
    """The residual on each grid, and its order."""
    rows: list[tuple[Cell, ...]] = []
    for ladder in LADDERS:
        sizes = [plain(float(value), ".0e") for value in np.abs(residuals[ladder.model])]
        grids = ", ".join(map(str, ladder.cells))
        order = with_interval(orders[ladder.model]) if ladder.model in orders else None
        rows.append((ladder.model, grids, ", ".join(sizes), ladder.derived, order))
    caption = (
        f"Residual of the ledger after {UNTIL:.0f} transits of the paper’s scene, relative to the largest entry, on each grid, "
        "and its fitted order with the 95 % interval. Upwind interfaces lose the square of their jumps. Continuous fields jump "
        "at the slabs’ ends alone, by the error of the fields (order 2 in `sbp:2` and `fem:1`; order P for even P in `fem:P`): "
        "the derived order is twice that. `dg:P` jumps by h^{P+1} at each of 1/h faces: the derived order is 2P + 1."
    )
    return table("residuals", caption, "family | cells | residual | derived .2g | order", rows)


def high_table(high: dict[tuple[str, str], float]) -> Table:
    """The same for families of high degree."""
    caption = f"The same for families of high degree, each on one grid, {UNTIL:.0f} transits."
    heading = " | ".join(["family", "cells [a slab] .0f", *(f"{name} .0e" for name in BOUNDARIES)])
    rows: list[tuple[Cell, ...]] = [
        (model, cells, *(abs(high[model, name]) for name in BOUNDARIES)) for model, cells in HIGH.items()
    ]
    return table("high", caption, heading, rows)


def histories(shown: Mapping[str, History]) -> Drawing:
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


def closure(curves: Mapping[str, tuple[Array, Array]]) -> Drawing:
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
