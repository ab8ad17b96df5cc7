"""Tables and pictures of stability: critical r over V, boundaries in the (r, epsilon) plane, impedances, spectra."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from reduced.impedance import impedance
from reduced.stability import Boundary, FrictionSlopes, Stability
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.studies.stability_boundaries.measured import TRACED, Curves
from validation.study import Table, table
from validation.study.drawing import WIDTH, Axes, Drawing, canvas, pen
from validation.study.text import plain

_MODELS = ("quasistatic", "quasidynamic", "block12", "block8", "kelvin-voigt", "modal:1", "modal:8")
_SHIFT = 0.2


def velocity_table(curves: Curves) -> Table:
    """Critical r at five velocities."""
    shown = [int(np.argmin(np.abs(np.log(curves.velocity / v)))) for v in (1.0, 10.0, 100.0, 1e3, 1e4)]
    rows = ((float(column[i]) for column in (curves.velocity, curves.delay, curves.kelvin_voigt, curves.error)) for i in shown)
    heading = "V [V*] .4g | r_{c}, delay (39) [L/V*] .12g | r_{c}, Kelvin–Voigt (27) [L/V*] .12g | relative error .3e"
    return table("critical-r", "Critical round trip over the drive V, the paper’s Fig 2.", heading, rows)


def model_table(onsets: dict[str, tuple[float, float]]) -> Table:
    """Critical r and frequency of every model at the paper's V and epsilon."""
    exact = onsets["delay"][0]
    rows = (
        (f"`{model}`", math.log10(r), r / exact - 1.0 if model != "delay" else None, omega, r * omega)
        for model, (r, omega) in onsets.items()
    )
    heading = "model | log_{10} r_{c} .11f | error of r_{c} [relative] .3e | ω at onset [V*/L] .8f | r_{c} ω [per transit] .8f"
    return table("models", "Onset of stick-slip in every model, V = 100, ε = 2.8 · 10^{-5}.", heading, rows)


def scene_table(found: dict[str, Stability]) -> Table:
    """Exact stability of one scene per row."""
    rows = []
    for name, stability in found.items():
        lead = stability.leading_roots[0]
        root = f"{plain(lead.real, '.5g')} ± {plain(abs(lead.imag), '.6g')} i" if lead.imag else plain(lead.real, ".5g")
        state = "stable" if stability.stable else f"unstable ({stability.unstable_roots})"
        rows.append(
            (f"`{name}`", state, stability.omega_c, stability.log10_r_c, stability.epsilon_c, root, stability.essential_abscissa)
        )
    heading = (
        "scene | steady sliding | ω_{c} [V*/L] .6f | log_{10} r_{c} .8f | ε_{c} .6e | leading root [V*/L] | "
        "fast roots [Re, V*/L] .5g"
    )
    caption = (
        "Exact stability of other arrangements. In brackets: number of growing roots, certified by the argument principle. "
        "r_{c}: the upper slab’s round trip, both scaled together. Fast roots: where the real parts of the infinitely many "
        "fast roots accumulate."
    )
    return table("scenes", caption, heading, rows)


def critical_curves(velocity: Array, delay: Array, kelvin_voigt: Array) -> Drawing:
    """The paper's Fig 2: r_c over V, and the relative error of the Kelvin-Voigt system's."""
    figure = canvas(WIDTH, 3.1)
    left, right = figure.subplots(1, 2)
    for model, values in (("delay", delay), ("kelvin-voigt", kelvin_voigt)):
        style = pen(model)
        dashes = "-" if model == "delay" else (0, (5, 2))
        left.loglog(velocity, values, color=style.color, linestyle=dashes, linewidth=style.width, label=style.label)
    left.set(xlabel="$V/V^*$", ylabel="$r_c$")
    left.legend()
    right.loglog(velocity, np.abs(kelvin_voigt / delay - 1.0), color=pen("kelvin-voigt").color)
    right.set(xlabel="$V/V^*$", ylabel="relative error of $r_c$")
    right.axhline(0.1, color="#b5b5b0", linewidth=0.8, linestyle=(0, (2, 2)))
    right.text(1.3, 0.12, "10 %", color="#6b6b66")
    return figure


def planes(traced: Mapping[str, Sequence[Boundary]], slopes: FrictionSlopes, paper: Scene) -> Drawing:
    """The paper's Fig 3: both systems' boundaries, traced (marks) and in closed form (lines)."""
    figure = canvas(WIDTH, 4.0)
    axes = figure.add_subplot()
    r = np.geomspace(10**-3.2, 10**-0.75, 4000)
    for model, function in TRACED.items():
        style = pen(model)
        values = np.array([function(slopes, x) for x in r])
        values[values <= 0.0] = np.nan
        axes.loglog(r, values, color=style.color, linewidth=1.1, label=style.label)
        for curve in traced[model]:
            axes.plot(10 ** curve.first[::3], 10 ** curve.second[::3], style.marker, color=style.color, markersize=3.5)
    axes.plot(paper.transit, paper.upper.epsilon, "X", color="#d55e00", markersize=8)
    axes.annotate("paper's scene", (paper.transit, paper.upper.epsilon), (9, -12), textcoords="offset points", color="#d55e00")
    for square, name in ((8.0, r"$\sqrt{8}/\omega_c$"), (24.0, r"$\sqrt{24}/\omega_c$")):
        axes.axvline(np.sqrt(square) / slopes.omega_c, color="#b5b5b0", linewidth=0.8, linestyle=(0, (2, 2)))
        axes.text(np.sqrt(square) / slopes.omega_c, 1.6e-6, name, ha="right", rotation=90, va="bottom", color="#6b6b66")
    axes.text(1.0e-3, 2e-3, "steady sliding stable")
    axes.text(6e-3, 4e-6, "unstable")
    axes.set(xlim=(r[0], r[-1]), ylim=(1e-6, 0.1), xlabel="$r$", ylabel=r"$\epsilon$")
    axes.legend(loc="upper left")
    return figure


def impedances(paper: Scene) -> Drawing:
    """|Z| and phase of every model, and the relative error of each reduction."""
    omega = np.geomspace(0.05, 40.0, 1500)
    s = (_SHIFT + 1j * omega) / paper.transit
    exact = impedance(paper, s)
    figure = canvas(WIDTH, 4.6)
    grid = figure.subplot_mosaic([["size", "error"], ["phase", "error"]], width_ratios=(1.15, 1.0))
    for model in ("delay", *_MODELS):
        style, z = pen(model), exact if model == "delay" else impedance(paper, s, model)
        _line(grid["size"], omega, np.abs(z) / paper.upper.epsilon, model)
        _line(grid["phase"], omega, np.degrees(np.angle(z)), model)
        if model != "delay":
            _line(grid["error"], omega, np.abs(z / exact - 1.0), model)
            grid["error"].lines[-1].set_label(style.label)
    for name, label in (("size", r"$|Z|/\epsilon$"), ("phase", "phase of $Z$ (degrees)"), ("error", r"$|Z/Z_{\rm exact}-1|$")):
        grid[name].set(xscale="log", ylabel=label, xlabel=r"$\omega$ (radians per transit)")
    grid["size"].set(yscale="log", ylim=(0.02, 30.0), xlabel="")
    grid["phase"].set_yticks([-90, 0, 90])
    grid["error"].set(yscale="log", ylim=(1e-8, 20.0))
    handles = [*grid["size"].get_lines()[:1], *grid["error"].get_lines()]
    figure.legend(
        handles, [pen(model).label for model in ("delay", *_MODELS)], loc="outside upper left", ncols=4, handlelength=2.8
    )
    return figure


def _line(axes: Axes, x: Array, y: Array, model: str) -> None:
    style = pen(model)
    axes.plot(x, y, color=style.color, linestyle=style.dashes, linewidth=style.width)


def spectra(found: Mapping[str, Stability], transit: float) -> Drawing:
    """Leading roots of several models in the upper half of the complex plane, per transit."""
    figure = canvas(WIDTH, 3.2)
    axes = figure.add_subplot()
    for size, (model, stability) in zip((7.0, 7.0, 10.0, 9.0, 12.0), found.items(), strict=True):
        style = pen(model)
        roots = np.array([root for root in stability.leading_roots if root.imag > 0.0]) * transit
        face = style.color if model == "delay" else "none"
        axes.plot(
            roots.real, roots.imag, style.marker, color=style.color, markerfacecolor=face, markersize=size, label=style.label
        )
    axes.axvline(found["delay"].essential_abscissa * transit, color="#6b6b66", linewidth=0.8, linestyle=(0, (4, 2)))
    axes.axvline(0.0, color="#b5b5b0", linewidth=0.8)
    axes.set_ylim(-0.7, 14.0)
    axes.set_yticks([0.0, 2 * np.pi, 4 * np.pi], ["0", r"$2\pi$", r"$4\pi$"])
    axes.set(xlabel="Re $s$ (per transit)", ylabel="Im $s$ (per transit)")
    axes.legend(loc="center")
    return figure
