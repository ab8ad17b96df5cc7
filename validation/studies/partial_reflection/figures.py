"""Cycles over the grip's impedance, and over what a bare coefficient lets through."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from slipwave.observe.pieces import Array
from validation.study.drawing import WIDTH, canvas

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LOOKS = (("#111111", "-"), ("#0072b2", (0, (5, 1.5))))


def over_grip(grid: Array, orbits: Mapping[float, Sequence[Any]], pairs: Sequence[Any]) -> "Figure":
    """`orbits`: stiffness -> points (period, drop, v_max) over `grid`; `pairs` hold the full wave's points."""
    figure = canvas(WIDTH, 3.8)
    panels = figure.subplots(1, 2)
    for (stiffness, points), (color, dashes) in zip(orbits.items(), _LOOKS, strict=True):
        for axes, which in zip(panels, (0, 1), strict=True):
            label = f"delay system, $K = {stiffness:g}$"
            axes.semilogx(grid, [point[which] for point in points], color=color, linestyle=dashes, marker=".", label=label)
            chosen = [pair for pair in pairs if pair.stiffness == stiffness]
            at = [p.impedance for p in chosen]
            axes.plot(at, [p.exact[which] for p in chosen], "+", color=color, markersize=8)
            axes.plot(at, [p.wave[which] for p in chosen], "o", color="#d55e00", markerfacecolor="none")
    panels[1].lines[-1].set_label("full wave")
    for axes, name in zip(panels, ("period $T$ (transits)", r"stress drop $\Delta\mu$"), strict=True):
        axes.set_ylim(bottom=0.0)
        axes.set(ylabel=name, xlabel=r"$Z_g/\epsilon$")
        axes.grid(True)
    lines = [panels[1].lines[0], panels[1].lines[3], panels[1].lines[-1]]
    figure.legend(handles=lines, loc="outside upper left", ncols=3, handlelength=3.0)
    return figure


def bare_and_grip(leaks: Array, bare: Sequence[Any], held: Sequence[Any], edge: float) -> "Figure":
    """Points (period, drop, v_max) over `leaks` = 1 - R; the interface locks beyond `edge`."""
    figure = canvas(WIDTH, 3.4)
    panels = figure.subplots(1, 3)
    for which, name in enumerate(("period $T$ (transits)", r"stress drop $\Delta\mu$", r"$v_{max}/V^*$")):
        axes = panels[which]
        for points, (color, dashes), marker, label in zip(
            (bare, held), _LOOKS, ("o", "^"), ("bare coefficient $R$", "grip of the same reflection"), strict=True
        ):
            values = [point[which] for point in points]
            axes.semilogx(leaks, values, color=color, linestyle=dashes, marker=marker, markersize=4, label=label)
        axes.axvline(edge, color="#6b6b66", linewidth=0.8, linestyle=(0, (1, 2)))
        axes.set_ylim(bottom=0.0)
        axes.set(title=name, xlabel="$1 - R$")
        axes.grid(True)
    figure.legend(handles=panels[0].lines[:2], loc="outside upper left", ncols=2, handlelength=3.0)
    return figure
