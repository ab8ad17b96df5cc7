"""Tables of orders and of the finest errors; error over grid points and over run time, one line per full-wave family."""

from collections.abc import Mapping

import numpy as np

from slipwave.observe.pieces import Array
from validation.measure.grid_ladders import GENTLE, ROUGH, STEEP
from validation.measure.orders import QUANTITIES, Climb
from validation.study import Cell, Table, table
from validation.study.drawing import WIDTH, Drawing, canvas, grid_pens, ruled

_FLOOR = 1e-14
_SCENES = {GENTLE.log10_r: "s", ROUGH.log10_r: "r", STEEP.log10_r: "t"}


def orders_table(climbs: list[Climb]) -> Table:
    """One row per family: every quantity's order with its interval."""
    rows = []
    for climb in climbs:
        together = climb.fit_together()
        grids = f"{climb.cells[climb.resolved]:.0f}\u2060–\u2060{climb.cells[-1]:.0f}"
        orders = (climb.fit(name).rounded for name in QUANTITIES)
        rows.append((climb.ladder.model, _scene(climb), grids, f"{climb.ladder.declared:g}", *orders, together.rounded))
    orders_in = [f"order in {symbol}" if name != "state" else "in the state" for name, symbol in QUANTITIES.items()]
    heading = " | ".join(["family | scene | cells | declared", *orders_in, "all together"])
    caption = (
        "Fitted orders with their 95 % confidence intervals, rounded up. T, Δμ, Δy, v_{max}: period, stress drop, elastic "
        "drop and largest rate, errors as root mean squares over all complete cycles; state: ψ, ln v and μ over the last "
        "transits; all together: geometric mean of the five errors. Cells: grids on which the waves are resolved. Smooth "
        "start, V = 2000; scene s: log_{10} r = −2.77, 60 transits; scene r (rougher, for orders from five on): −2.59, 120 "
        "transits; scene t (steeper still, for orders from seven on): −2.5, 120 transits."
    )
    return table("orders", caption, heading, rows)


def finest_table(climbs: list[Climb]) -> Table:
    """One row per family: errors and run time of the finest grid."""
    rows: list[tuple[Cell, ...]] = []
    for climb in climbs:
        found = (float(climb.errors[name][-1]) for name in QUANTITIES)
        rows.append((climb.ladder.model, _scene(climb), float(climb.cells[-1]), 1e3 * float(climb.seconds[-1]), *found))
    errors_of = [f"error of {symbol} [relative] .0e" for symbol in QUANTITIES.values()]
    heading = " | ".join(["family | scene | cells [a slab] .0f | run [ms] .0f", *errors_of])
    caption = (
        "Relative errors on the finest grid tried, and the run’s time. A ladder ends with the first grid whose error of the "
        "state is below 5 · 10^{−12}, where the fits end. Scenes as above."
    )
    return table("finest", caption, heading, rows)


def _scene(climb: Climb) -> str:
    return _SCENES[climb.ladder.course.log10_r]


def convergence_and_cost(curves: Mapping[str, tuple[Array, Array, Array]]) -> Drawing:
    """`curves`: family -> (points per slab, seconds, error)."""
    figure = canvas(WIDTH, 4.3)
    left, right = figure.subplots(1, 2, sharey=True)
    for model, own in grid_pens(curves).items():
        points, seconds, error = curves[model]
        look = {"color": own.color, "marker": own.marker, "linestyle": own.dashes, "linewidth": 1.1, "markersize": 4}
        shown = np.maximum(error, _FLOOR)
        left.loglog(points, shown, label=own.label, **look)
        right.loglog(1e3 * seconds, shown, **look)
    left.set_xlabel("points per slab")
    right.set_xlabel("run time (ms)")
    left.set_ylabel("error of the state")
    ruled(left, right)
    figure.legend(loc="outside upper left", ncols=4, handlelength=3.0)
    return figure
