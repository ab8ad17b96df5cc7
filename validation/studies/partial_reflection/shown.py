"""Cycles behind grips and bare coefficients, as tables and over the grip's impedance or the coefficient's leak."""

from collections.abc import Mapping, Sequence
from typing import Any

from slipwave.observe.pieces import Array
from validation.studies.partial_reflection.runs import RESTLESS, UNTIL, Pair, Point
from validation.study import Table, table
from validation.study.drawing import WIDTH, Drawing, canvas
from validation.study.text import plain

_LOOKS = (("#111111", "-"), ("#0072b2", (0, (5, 1.5))))


def wave_table(pairs: list[Pair]) -> Table:
    """Delay system and full wave, grip by grip."""
    rows = ((pair.stiffness, pair.impedance, *pair.exact, *pair.differences) for pair in pairs)
    differences = [f"difference in {name} [relative] .0e" for name in ("T", "Δμ", "v_{max}")]
    columns = "K [ε a transit] .0f | Z_{g}/ε .3g | T [transits] .9g | Δμ [σ] .7f | v_{max} [V*] .7g"
    caption = (
        f"Slabs in grips of stiffness K and impedance Z_{{g}}, log_{{10}} r = −2.6: last complete cycle before {UNTIL:.0f} "
        "transits by the delay system, and how far discontinuous Galerkin is from it in the same cycle."
    )
    return table("grips", caption, " | ".join([columns, *differences]), rows)


def bare_table(leaks: tuple[float, ...], bare: list[Point], held: list[Point], ends: list[str]) -> Table:
    """Bare coefficients beside grips of the same reflection."""
    rows = ((q, end, *point, 2.0 / q - 1.0, *grip) for q, end, point, grip in zip(leaks, ends, bare, held, strict=True))
    figures = "T [transits] .6g | Δμ [σ] .5f | v_{max} [V*] .0f"
    heading = f"1 − R .0e | bare: ends as | {figures} | grip: Z_{{g}}/ε .5g | {figures}"
    caption = (
        "Left: faces with a bare coefficient R, right: grips that reflect the same share of a fast wave, stiffness 10 ε a "
        f"transit; log_{{10}} r = −2.66, delay system. A dash: no cycle that repeats to {plain(RESTLESS, '.0e')}."
    )
    return table("bare", caption, heading, rows)


def over_grip(grid: Array, orbits: Mapping[float, Sequence[Any]], pairs: Sequence[Any]) -> Drawing:
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


def bare_and_grip(leaks: Array, bare: Sequence[Any], held: Sequence[Any], edge: float) -> Drawing:
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
