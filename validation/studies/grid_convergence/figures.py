"""Error over grid points and over run time, one line per full-wave family."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from slipwave.observe.pieces import Array
from validation.study.drawing import WIDTH, canvas, grid_pens

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FLOOR = 1e-14


def convergence_and_cost(curves: Mapping[str, tuple[Array, Array, Array]]) -> "Figure":
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
    for axes in (left, right):
        axes.grid(True)
        axes.set_axisbelow(True)
    figure.legend(loc="outside upper left", ncols=4, handlelength=3.0)
    return figure
