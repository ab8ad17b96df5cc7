"""Drawings by matplotlib, until every study gives charts."""

from typing import Any

from slipwave.extras import require
from validation.chart import WIDTH as WIDTH
from validation.chart.draw import Axes as Axes
from validation.chart.draw import Drawing as Drawing
from validation.chart.draw import styled as styled
from validation.compute.looks import grid_styles as grid_styles
from validation.compute.looks import style_of as style_of


def line(model: str, **more: Any) -> dict[str, Any]:
    """Colour, dashes, width and label of the line of `model`, for matplotlib; `more` is added or replaces them."""
    own = style_of(model)
    return {"color": own.color, "linestyle": own.dashes, "linewidth": own.width, "label": own.label} | more


def canvas(width: float = WIDTH, height: float = 4.0) -> Drawing:
    """An empty figure whose axes arrange themselves; sizes in inches. Draw inside `styled()`, as the report does."""
    require("plot", "a figure")
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def subplots(
    height: float, rows: int = 1, columns: int = 1, x: str = "", y: str = "", width: float = WIDTH, **more: Any
) -> tuple[Drawing, Any]:
    """An empty figure and its axes as by `subplots`, with the label `x` on the lowest and `y` on the leftmost ones."""
    figure = canvas(width, height)
    grid = figure.subplots(rows, columns, squeeze=False, **more)
    for axes in grid[-1]:
        axes.set_xlabel(x)
    for axes in grid[:, 0]:
        axes.set_ylabel(y)
    return figure, grid.squeeze()[()]


def key(**look: Any) -> Any:
    """A line for a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], **look)


def ruled(*every: Axes) -> None:
    """Draw a grid behind what the axes show."""
    for axes in every:
        axes.grid(True)
        axes.set_axisbelow(True)
