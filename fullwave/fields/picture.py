"""A picture of velocity and stress in the (time, depth) plane."""

from typing import TYPE_CHECKING, Any

import numpy as np

from fullwave.fields.files import profile
from fullwave.fields.record import Field
from slipwave.observe.pieces import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def picture(field: Field, title: str = "") -> "Figure":
    """Two panels over the same time: velocity (colour scale linear up to V, logarithmic beyond) and shear stress."""
    from matplotlib.colors import SymLogNorm
    from matplotlib.figure import Figure

    position, velocity, stress = profile(field)
    figure = Figure(figsize=(8.0, 6.0), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    largest = float(np.abs(velocity).max())
    scale = SymLogNorm(linthresh=min(field.scene.velocity, largest), vmin=-largest, vmax=largest)
    _panel(figure, upper, field.time, position, velocity, "velocity / V*", cmap="RdBu_r", norm=scale)
    _panel(figure, lower, field.time, position, stress, "shear stress / normal stress", cmap="viridis")
    lower.set_xlabel("time / transits")
    upper.set_title(title or f"{field.scene.name}: waves of one slip event ({field.model})")
    return figure


def _panel(figure: "Figure", axes: "Axes", time: Array, position: Array, values: Array, label: str, **look: Any) -> None:
    mesh = axes.pcolormesh(time, position, values.T, shading="gouraud", rasterized=True, **look)
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_ylabel("depth / travel time")
    axes.set_yticks([-1.0, 0.0, 1.0], ["lower face", "interface", "upper face"])
    figure.colorbar(mesh, ax=axes, label=label)
