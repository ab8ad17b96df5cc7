"""Error over grid points and over run time, one line per full-wave family."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from slipwave.observe.pieces import Array
from validation.study.drawing import WIDTH, canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FLOOR = 1e-14
_FAMILIES = {"fd": ("#d55e00", "s"), "sbp": ("#0072b2", "D"), "fem": ("#009e73", "^"), "dg": ("#111111", "o")}
_STYLES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)))
_NAMES = {"fd": "leapfrog", "sbp": "by parts", "fem": "elements", "dg": "Galerkin"}


def convergence_and_cost(curves: Mapping[str, tuple[Array, Array, Array]]) -> "Figure":
    """`curves`: family -> (points per slab, seconds, error)."""
    figure = canvas(WIDTH, 4.3)
    left, right = figure.subplots(1, 2, sharey=True)
    seen: dict[str, int] = {}
    for model, (points, seconds, error) in curves.items():
        name, _, number = model.partition(":")
        color, marker = _FAMILIES[name]
        style = _STYLES[seen.setdefault(name, 0)]
        seen[name] += 1
        look = {"color": color, "marker": marker, "linestyle": style, "linewidth": 1.1, "markersize": 4}
        shown = np.maximum(error, _FLOOR)
        left.loglog(points, shown, label=f"{_NAMES[name]} {number}".strip(), **look)
        right.loglog(1e3 * seconds, shown, **look)
    left.set_xlabel("points per slab")
    right.set_xlabel("run time (ms)")
    left.set_ylabel("error of the state")
    for axes in (left, right):
        axes.grid(True)
        axes.set_axisbelow(True)
    figure.legend(loc="outside upper left", ncols=4, handlelength=3.0)
    return figure
