"""The paper's Figs 6 and 7: branches of orbits over r, and the ODE's doubled orbits."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from reduced.orbit import PeriodicOrbit
from slipwave.observe.pieces import Array
from validation.studies.bifurcation.doubling import Bubble, Doubled, between_doublings
from validation.study.branch_drawing import MARKS, NAMES, color_of, draw_branch, draw_special, special_keys
from validation.study.drawing import WIDTH, Drawing, canvas, key, line, ruled, subplots
from validation.study.over_r import COMPARED, Branch

_LABELS = {"period": "$T$ (transits)", "stress_drop": r"$\Delta\mu$", "elastic_stress_drop": r"$\Delta y$"}
_LEFT = -2.706
_ZOOM = -2.62
_WAVE: dict[str, Any] = {"color": "#d55e00", "markerfacecolor": "none", "markersize": 7.0, "markeredgewidth": 1.2}
_DOUBLE = "#d55e00"
_THIN = (0, (1.5, 1.2))
_TEN = math.log(10.0)
_EVERY = 4  # nodes of a step, of which one is drawn


def diagram(branches: Iterable[Branch], waves: Sequence[Any]) -> Drawing:
    """The paper's Fig 6: period and drops over log10 r; left from the onset to log10 r = -2.62, right to the end."""
    figure, panels = subplots(8.2, 3, 2, r"$\log_{10} r$", sharex="col", sharey="row", width_ratios=(1.25, 1.0))
    cornered = {branch.model: (branch, branch.corners) for branch in branches}
    for (near, far), name in zip(panels, COMPARED, strict=True):
        for model, (branch, corners) in cornered.items():
            for axes in (near, far):
                draw_branch(axes, model, corners, name)
                draw_special(axes, branch, name)
        near.plot([one.log10_r for one in waves], [one.wave[name] for one in waves], "o", linestyle="none", **_WAVE)
        near.set(ylabel=_LABELS[name], xlim=(_LEFT, _ZOOM))
        ruled(near, far)
    figure.legend(handles=[*_keys(cornered)], loc="outside upper left", ncols=4, handlelength=2.4)
    return figure


def _keys(models: Iterable[str]) -> Iterator[Any]:
    """Lines for the legend: models, kinds of points, the full wave."""
    for model in models:
        yield key(**line(model, color=color_of(model), linestyle="-"))
    yield from special_keys(NAMES)
    yield key(marker="o", linestyle="none", label="full wave", **_WAVE)


def orbits_in_planes(found: Doubled, ode: Branch, bubbles: Iterable[Bubble]) -> Drawing:
    """The paper's Fig 7: both orbits in two planes; below, T and half the doubled period over r."""
    figure = canvas(WIDTH, 8.4)
    grid = figure.subplot_mosaic([["rate", "rate"], ["stress", "state"], ["branch", "branch"]], height_ratios=(0.8, 1.2, 1.0))
    single = line("kelvin-voigt", linestyle=_THIN, linewidth=1.2, label="T = 79.09, unstable")
    double = line("kelvin-voigt", color=_DOUBLE, linestyle="-", linewidth=0.9, label="doubled orbit, stable")
    for orbit, look in ((found.double, double), (found.single, single)):
        time, rate, stress, state = _curves(orbit)
        grid["rate"].plot(time / time[-1], rate, **look)
        grid["stress"].plot(rate, stress, **look)
        grid["state"].plot(rate, state, **look)
    grid["rate"].set(xlabel="time over the period of each orbit", ylabel=r"$\log_{10} v$")
    grid["stress"].set(xlabel=r"$\log_{10} v$", ylabel=r"$\mu$")
    grid["state"].set(xlabel=r"$\log_{10} v$", ylabel=r"$\log_{10}\phi$")
    axes = grid["branch"]
    pairs = between_doublings(ode)
    low, high = pairs[0][0].value - 1e-2, pairs[-1][-1].value + 1e-2
    draw_branch(axes, "kelvin-voigt", [one for one in ode.corners if low < one.value < high], "period")
    for bubble in bubbles:
        axes.plot(*np.array(bubble.points).T, color=_DOUBLE, linewidth=1.3)
    doublings = [(one.value, one.period) for pair in pairs for one in (pair[0], pair[-1])]
    axes.plot(*np.array(doublings).T, MARKS["PD"], color=single["color"], markerfacecolor="white", label="period doubling")
    axes.set(xlabel=r"$\log_{10} r$", ylabel="$T$, half of the doubled $T$")
    ruled(*grid.values())
    handles = [*grid["stress"].get_lines(), axes.get_lines()[-1]]
    figure.legend(handles=handles, loc="outside upper left", ncols=3, handlelength=2.6)
    return figure


def _curves(orbit: PeriodicOrbit) -> list[Array]:
    """Time from the event's fastest moment on, log10 v, mu and log10 phi at some nodes of an orbit's steps, over one period."""
    pieces, nodes = orbit.closed.cycle.pieces, orbit.closed.flow.nodes
    time = pieces.time[:, None] + pieces.length[:, None] * nodes
    columns = [values[:, _EVERY - 1 :: _EVERY].ravel() for values in (time, pieces.z / _TEN, pieces.mu, pieces.psi / _TEN)]
    return [columns[0] - columns[0][0], *columns[1:]]


CAPTION = (
    "Period T, stress drop Δμ and elastic stress drop Δy of the periodic orbits over r, the paper’s Fig 6, near the onset (left) "
    "and as far as the branches were followed (right). Stable orbits are thick and solid, unstable ones thin and dotted. "
    "Circles: orbits of the full wave."
)
PLANES = (
    "The ODE’s orbits at log_{10} r = −2.590007, the paper’s Fig 7: the unstable one of T = 79.09 transits (dotted) and the "
    "stable one of twice the period. Above: slip rate over time, each over its own period; middle: two planes; below: periods of "
    "the simple orbits over r and half the periods of the doubled ones."
)
