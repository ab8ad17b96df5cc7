"""One look for every figure: readable on paper, told apart in grey by line style and marker as well as by colour."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
PNG_DOTS_PER_INCH = 110
WIDTH = 7.4
"""Width of a full-width figure, inches: the text width of the page on A4 paper."""


class Pen(NamedTuple):
    """How a model's curve looks everywhere."""

    label: str
    color: str
    dashes: Any
    marker: str
    width: float = 1.3


PENS = {
    "delay": Pen("delay system (exact)", "#111111", "-", "o", 2.0),
    "fd": Pen("full wave, leapfrog", "#d55e00", (0, (1, 2.2)), "s", 2.0),
    "kelvin-voigt": Pen("Kelvin–Voigt ODE", "#0072b2", "-", "D"),
    "block8": Pen("block, $\\rho h/8$", "#009e73", (0, (6, 2)), "^"),
    "block12": Pen("block, $\\rho h/12$", "#009e73", (0, (2, 1.5)), "v"),
    "quasidynamic": Pen("quasi-dynamic", "#8a8a8a", (0, (8, 2, 1.5, 2)), "P"),
    "modal:1": Pen("modal, 1 mode", "#cc4f8a", (0, (5, 1.5)), "<"),
    "modal:2": Pen("modal, 2 modes", "#cc4f8a", (0, (1.2, 1.2)), ">"),
    "modal:8": Pen("modal, 8 modes", "#8d2f5e", (0, (3, 1, 1, 1)), "*"),
    "quasistatic": Pen("quasi-static", "#b9b9b9", (0, (1, 1)), "x"),
}
"""Pens of the models, by the names of the command line."""


def pen(model: str) -> Pen:
    """The pen of `model`; models without one of their own share their family's."""
    return PENS.get(model) or PENS.get(model.split(":")[0]) or Pen(model, "#555555", "-", ".")


def canvas(width: float = WIDTH, height: float = 4.0) -> "Figure":
    """An empty figure whose axes arrange themselves; sizes in inches. Draw inside `styled()`, as the report does."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def styled() -> Any:
    """Context in which axes and lines take the house style."""
    import matplotlib as mpl

    return mpl.rc_context(STYLE)


def render(figure: "Figure", stem: Path) -> None:
    """Write stem.svg and stem.png; byte for byte the same for the same drawing."""
    figure.savefig(stem.with_name(stem.name + ".svg"), metadata={"Date": None})
    figure.savefig(stem.with_name(stem.name + ".png"), dpi=PNG_DOTS_PER_INCH, metadata={"Software": None})
