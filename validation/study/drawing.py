"""The common style of all figures: legible on paper; line style and marker distinguish the lines without colour."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypeAlias

from slipwave.extras import require
from slipwave.family import PlotStyle
from validation.compute.models import family_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
    from matplotlib.figure import Figure

    Drawing: TypeAlias = Figure
else:  # matplotlib is loaded only when something is drawn
    Axes = Drawing = Any

STYLE: Any = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral"],
    "mathtext.fontset": "stix",
    "font.size": 11,
    "axes.labelsize": 11.5,
    "axes.titlesize": 11.5,
    "axes.titlelocation": "left",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": False,
    "grid.color": "#d8d8d4",
    "grid.linewidth": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "legend.frameon": False,
    "legend.fontsize": 10,
    "lines.linewidth": 1.4,
    "lines.markersize": 5,
    "svg.hashsalt": "slipwave",
    "savefig.bbox": "tight",
    "savefig.pad_inches": 0.04,
    "path.simplify_threshold": 0.2,
}
WIDTH = 7.4
"""Width of a full-width figure, inches: the text width of the page on A4 paper."""

_DASHES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)))


def style_of(model: str) -> PlotStyle:
    """Plot style of `model`, by its full name; grey for a model without one."""
    family, number = family_of(model), model.partition(":")[2]
    styles = family.styles if family else {}
    return styles.get(int(number) if number else None) or styles.get(None) or PlotStyle(model, "#555555", "-", ".")


def line(model: str, **more: Any) -> dict[str, Any]:
    """Colour, dashes, width and label of the line of `model`, for matplotlib; `more` is added or replaces them."""
    own = style_of(model)
    return {"color": own.color, "linestyle": own.dashes, "linewidth": own.width, "label": own.label} | more


def grid_styles(models: Iterable[str]) -> dict[str, PlotStyle]:
    """Plot styles of several full waves in one figure: colour and marker are the family's, dashes distinguish its members."""
    styles: dict[str, PlotStyle] = {}
    for model in models:
        name, _, number = model.partition(":")
        seen = sum(other.partition(":")[0] == name for other in styles)
        own = style_of(model)
        styles[model] = own._replace(label=f"{own.label.removeprefix('full wave, ')} {number}".strip(), dashes=_DASHES[seen])
    return styles


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


def styled() -> Any:
    """Context in which axes and lines have the common style."""
    require("plot", "a figure")
    import matplotlib as mpl

    return mpl.rc_context(STYLE)
