"""Tables of orders and of the finest errors; error over grid points and over run time, one line per full-wave family."""

from collections.abc import Iterable, Mapping

import numpy as np

from fullwave.families import FullWave
from slipwave.observe.pieces import Array
from validation.measure.grid_ladders import FLOOR_IN_SPACE, GENTLE, ROUGH, ROUGH_FROM, STEEP, STEEP_FROM, Course
from validation.measure.orders import QUANTITIES, Climb
from validation.study import Cell, Table, table
from validation.study.drawing import WIDTH, Drawing, canvas, grid_pens, ruled
from validation.study.text import places, plain

_FLOOR = 1e-14
_SCENES = {GENTLE.log10_r: "s", ROUGH.log10_r: "r", STEEP.log10_r: "t"}


def orders_table(climbs: list[Climb], unjudged: Iterable[FullWave] = ()) -> Table:
    """One row per family: every quantity's order with its interval, or why there is none."""
    rows: list[tuple[Cell, ...]] = []
    for climb in climbs:
        head = (climb.ladder.model, _scene(climb))
        if climb.lost:
            rows.append((*head, None, f"{climb.ladder.declared:g}", *([None] * len(QUANTITIES)), f"no order: {climb.lost}"))
            continue
        grids = f"{climb.cells[climb.resolved]:.0f}\u2060–\u2060{climb.cells[-1]:.0f}"
        orders = (climb.fit(name).rounded for name in QUANTITIES)
        rows.append((*head, grids, f"{climb.ladder.declared:g}", *orders, climb.fit_together().rounded))
    for family in unjudged:
        declared = f"{family.order_interface(family.usual):g}"
        rows.append((family.example, None, None, declared, *([None] * len(QUANTITIES)), "not judged: declares no ladder"))
    orders_in = [f"order in {symbol}" if name != "state" else "in the state" for name, symbol in QUANTITIES.items()]
    heading = " | ".join(["family | scene | cells | declared", *orders_in, "all together"])
    caption = (
        "Fitted orders with their 95 % confidence intervals, rounded up. T, Δμ, Δy, v_{max}: period, stress drop, elastic "
        "drop and largest rate, errors as root mean squares over all complete cycles; state: ψ, ln v and μ over the last "
        "transits; all together: geometric mean of the five errors. Cells: grids on which the waves are resolved. Smooth "
        f"start, V = {GENTLE.scene.velocity:g}; scene s: log_{{10}} r = {_course(GENTLE)}; scene r (rougher, "
        f"for orders from {ROUGH_FROM:g} on): "
        f"{_course(ROUGH)}; scene t (steeper still, for orders from {STEEP_FROM:g} on): {_course(STEEP)}."
    )
    return table("orders", caption, heading, rows)


def _course(course: Course) -> str:
    return f"{places([course.log10_r])}, {course.until:g} transits"


def finest_table(climbs: list[Climb]) -> Table:
    """One row per family: errors and run time of the finest grid."""
    rows: list[tuple[Cell, ...]] = []
    for climb in (one for one in climbs if one.cells.size):
        found = (float(climb.errors[name][-1]) for name in QUANTITIES)
        rows.append((climb.ladder.model, _scene(climb), float(climb.cells[-1]), 1e3 * float(climb.seconds[-1]), *found))
    errors_of = [f"error of {symbol} [relative] .0e" for symbol in QUANTITIES.values()]
    heading = " | ".join(["family | scene | cells [a slab] .0f | run [ms] .0f", *errors_of])
    caption = (
        "Relative errors on the finest grid tried, and the run’s time. A ladder ends with the first grid whose error of the "
        f"state is below {plain(FLOOR_IN_SPACE, '.0e')}, where the fits end. Scenes as above."
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
