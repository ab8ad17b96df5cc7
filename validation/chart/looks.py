"""How models look in charts: colours, dashes and markers from their families; what special points are called there."""

from typing import Any

from numpy.typing import ArrayLike

from slipwave.family import PlotStyle
from validation.chart import Look, Trace
from validation.models.by_name import family_of

NAMES = {"HB": "Hopf point", "LP": "fold", "PD": "period doubling", "NS": "torus point"}
"""Kind of special point -> its name."""


def style_of(model: str) -> PlotStyle:
    """Plot style of `model`, by its full name; grey for a model without one."""
    family, number = family_of(model), model.partition(":")[2]
    styles = family.styles if family else {}
    return styles.get(int(number) if number else None) or styles.get(None) or PlotStyle("#555555", "-", ".")


def model_look(model: str, **changes: Any) -> Look:
    """The line of `model`, with `changes`."""
    return Look.of(style_of(model), **changes)


def model_marks(model: str, **changes: Any) -> Look:
    """The points of `model`, with `changes`."""
    return model_look(model, dashes="", marker=style_of(model).marker, **changes)


def model_line(model: str, x: ArrayLike, y: ArrayLike, name: str = "", **changes: Any) -> Trace:
    """A line of `model` under its own name, or another, with `changes` of its look."""
    return Trace(name or model, x, y, model_look(model, **changes))
