"""Error ladders: one panel per figure of merit, one line per Courant number, the fits and a slope triangle."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from slipwave.observe.pieces import Array
from validation.measure.order_fit import Fit
from validation.study.drawing import WIDTH, canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TITLES = {
    "period": "period $T$",
    "stress_drop": r"stress drop $\Delta\mu$",
    "elastic_stress_drop": r"elastic drop $\Delta y$",
    "v_max": r"$v_{\max}$",
    "v_min": r"$v_{\min}$",
    "ψ(400), smooth start": r"$\psi(400)$, smooth start",
    "ψ(400), jump start": r"$\psi(400)$, jump start",
}
_LOOKS = {0.5: ("#d55e00", "s", "white"), 0.9: ("#0072b2", "D", "#0072b2"), 1.0: ("#111111", "o", "#111111")}


def ladders(cells: Array, errors: Mapping[str, Mapping[float, Array]], fits: Mapping[str, Mapping[float, Fit]]) -> "Figure":
    """Log-log panels of error over cells per slab."""
    figure = canvas(WIDTH, 4.6)
    grid = figure.subplots(2, 4, sharex=True)
    for axes, name in zip(grid.flat, _TITLES, strict=False):
        _panel(axes, cells, errors[name], fits[name])
        axes.set_title(_TITLES[name], fontsize=11)
        _triangle(axes, 1.0 if "jump" in name else 2.0)
    for axes in grid[1, :3]:
        axes.set_xlabel("cells per slab")
    grid[0, 3].tick_params(labelbottom=True)
    grid[0, 0].set_ylabel("relative error")
    grid[1, 0].set_ylabel("error")
    lines = grid[0, 0].get_lines()[1::2]
    grid[1, 3].set_axis_off()
    grid[1, 3].legend(lines, [f"CFL {cfl}" for cfl in errors["period"]], loc="center")
    return figure


def _panel(axes: "Axes", cells: Array, errors: Mapping[float, Array], fits: Mapping[float, Fit]) -> None:
    for cfl, values in errors.items():
        color, marker, fill = _LOOKS[cfl]
        one = fits[cfl]
        used = cells[one.used]
        axes.loglog(used, one.constant * used**-one.order, color=color, linewidth=0.9)
        axes.loglog(cells, np.abs(values), linestyle="none", marker=marker, color=color, markerfacecolor=fill)
    axes.margins(0.12)
    axes.set_xticks(cells, [str(n) for n in cells])
    axes.minorticks_off()


def _triangle(axes: "Axes", slope: float) -> None:
    """A right triangle of the given slope in the lower left corner, its hypotenuse parallel to a line of that order."""
    (x0, x1), (y0, y1) = np.log10(axes.get_xlim()), np.log10(axes.get_ylim())
    left, right = x0 + 0.08 * (x1 - x0), x0 + 0.08 * (x1 - x0) + 0.3
    bottom = y0 + 0.08 * (y1 - y0)
    top = bottom + slope * 0.3
    x, y = 10.0 ** np.array([left, right, left, left]), 10.0 ** np.array([top, bottom, bottom, top])
    axes.plot(x, y, color="#777777", linewidth=0.9)
    axes.annotate(
        f"{slope:.0f}", (10**left, 10 ** (0.5 * (top + bottom))), (3, 0), textcoords="offset points", va="center", fontsize=9
    )
