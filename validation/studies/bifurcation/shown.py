"""The bifurcation diagram, and tables of the special points and of the full wave's orbits."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from reduced.continuation.special import Special
from reduced.orbit.figures import figures_of
from slipwave.observe.pieces import Array
from validation.studies.bifurcation.waves import COMPARED, WAVE, WaveOrbit
from validation.study import Cell, Table, table
from validation.study.drawing import WIDTH, Axes, Drawing, canvas, pen, ruled
from validation.study.over_r import Branch, Corner, column, parts
from validation.study.text import plain

NAMES = {"HB": "Hopf point", "LP": "fold", "PD": "period doubling", "NS": "torus point"}
MARKS = {"HB": "s", "LP": ".", "PD": "D", "NS": "*"}
SIZES = {"HB": 5.5, "LP": 3.5, "PD": 3.5, "NS": 5.0}
_LABELS = {"period": "$T$ (transits)", "stress_drop": r"$\Delta\mu$", "elastic_stress_drop": r"$\Delta y$"}
_THIN = 0.8
_OVERLAID = {"modal:2": "#e69f00", "modal:4": "#009e73", "modal:8": "#56b4e9"}
"""Colours of branches that lie on the delay system's, drawn below it."""

_BELOW = 1.5
_COUNTED = {"LP": 9, "NS": 2, "PD": 1}  # special points of each kind that are compared
_ROUNDING = 1e-11  # brackets (log10 r) below this are not shown
_APART = 1e-6  # distance, as a share of the curve's size, of points that count as two
_FINE = 6  # points of a curve for each interval between points of the branch
_LEFT = -2.706
_ZOOM = -2.62


def special_table(branch: Branch) -> Table:
    """The Hopf point and all special points of a branch, in order."""
    onset, model = branch.onset, branch.model
    counts = f"{onset.unstable_below} → {onset.unstable_above}"
    rows: list[tuple[Cell, ...]] = [("Hopf point", onset.parameter, onset.period, 0.0, 0.0, None, counts, None)]
    rows += [_special_row(special) for special in branch.special]
    heading = (
        "point | log_{10} r .10f | T [transits] .7f | Δμ [σ] .7f | Δy [σ] .7f | bracket [log_{10} r] | unstable | "
        "multiplier that passes"
    )
    caption = (
        f"Special points of the branch of `{model}`, in order from the Hopf point. Bracket: width of the interval that holds the "
        "point. Unstable: number of multipliers outside the unit circle before and after the point; at the Hopf point, growing "
        "roots of steady sliding below and above it. At a fold T is known to 10^{-6}, relative."
    )
    return table(f"special-{model.replace(':', '-')}", caption, heading, rows)


def _special_row(special: Special) -> tuple[Cell, ...]:
    found, value = figures_of(special.point.closed), special.multiplier
    passing = {
        "LP": "1",
        "PD": "−1",
        "NS": f"{plain(value.real, '.6f')} ± {plain(abs(value.imag), '.6f')} i",
    }[special.kind]
    counts = f"{special.unstable_before} → {special.unstable_after}"
    figures = [found[name] for name in COMPARED]
    return (NAMES[special.kind], special.point.parameter, *figures, _width(special.bracket), counts, passing)


def _width(bracket: float) -> str:
    """A bracket in words; at a fold r hardly changes, so that brackets are lost in rounding there."""
    return plain(bracket, ".0e") if bracket > _ROUNDING else f"below {plain(_ROUNDING, '.0e')}"


def structure_table(delay: Branch, others: Iterable[Branch]) -> Table:
    """How far the special points of other models are from those of the delay system, kind by kind in order."""
    listed = [*others]
    rows: list[tuple[Cell, ...]] = [
        (NAMES["HB"], delay.onset.parameter, *(one.onset.parameter - delay.onset.parameter for one in listed))
    ]
    for kind, n in ((kind, n) for kind, count in _COUNTED.items() for n in range(count)):
        place, *places = (_place(one, kind, n) for one in (delay, *listed))
        rows.append((f"{NAMES[kind]} {n + 1}", place, *(_apart(other, place) for other in places)))
    columns = " | ".join(f"{one.model} [log_{{10}} r] .1e" for one in listed)
    caption = (
        "Special points of the delay system, and how far those of other models are from them in log_{10} r; empty: the model has "
        "none of that number, or none up to where its branch was followed. Each kind is counted along the branch."
    )
    return table("structure", caption, f"point | delay [log_{{10}} r] .7f | {columns}", rows)


def _place(branch: Branch, kind: str, n: int) -> float | None:
    found = branch.of_kind(kind)
    return found[n].point.parameter if n < len(found) else None


def _apart(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else one - other


def wave_table(orbits: Iterable[WaveOrbit]) -> Table:
    """Period and drops of the full wave and their distance from the delay system's."""
    rows = [(one.log10_r, *(one.wave[name] for name in COMPARED), one.apart) for one in orbits]
    caption = (
        f"Orbits of the full wave, `{WAVE}` marched exactly, by Newton’s method on the motion of the grid over one period; the "
        "last column is the largest relative difference of T, Δμ and Δy from the delay system’s branch."
    )
    return table("waves", caption, "log_{10} r .2f | T [transits] .10f | Δμ [σ] .10f | Δy [σ] .10f | apart .0e", rows)


def diagram(branches: Iterable[Branch], waves: Iterable[WaveOrbit]) -> Drawing:
    """The paper's Fig 6: period and drops over log10 r; left from the onset to log10 r = -2.62, right to the end."""
    figure = canvas(WIDTH, 8.2)
    panels = figure.subplots(3, 2, sharex="col", sharey="row", width_ratios=(1.25, 1.0))
    cornered = {branch.model: (branch, branch.corners) for branch in branches}
    for (near, far), name in zip(panels, COMPARED, strict=True):
        for model, (branch, corners) in cornered.items():
            for axes in (near, far):
                draw_branch(axes, model, corners, name)
                draw_special(axes, branch, name)
        near.plot([one.log10_r for one in waves], [one.wave[name] for one in waves], "o", **_WAVE)
        near.set(ylabel=_LABELS[name], xlim=(_LEFT, _ZOOM))
        ruled(near, far)
    for axes in panels[-1]:
        axes.set_xlabel(r"$\log_{10} r$")
    figure.legend(handles=[*_keys(cornered, waves)], loc="outside upper left", ncols=4, handlelength=2.4)
    return figure


def draw_branch(axes: Axes, model: str, corners: list[Corner], name: str) -> None:
    """A figure of all orbits over log10 r: stable ones solid, unstable ones thin and dotted."""
    look, color = pen(model), _color(model)
    for stable, part in parts(corners):
        dashes, width = ("-", look.width) if stable else ((0, (1.5, 1.2)), _THIN)
        x, y = column(part, lambda one: one.log10_r), column(part, lambda one: one.figures[name])
        order = _BELOW if model in _OVERLAID else None
        axes.plot(*_smooth(x, y), color=color, linestyle=dashes, linewidth=width, zorder=order)


def _color(model: str) -> str:
    return _OVERLAID.get(model, pen(model).color)


def _smooth(x: Array, y: Array) -> tuple[Array, Array]:
    """A curve through the points, by a cubic spline over the length along them, each axis in units of its range."""
    from scipy.interpolate import make_interp_spline

    along = np.r_[0.0, np.cumsum(np.hypot(np.diff(x) / np.ptp(x), np.diff(y) / np.ptp(y)))]
    apart = np.r_[True, np.diff(along) > _APART]
    curve = make_interp_spline(along[apart], np.column_stack([x, y])[apart], k=min(3, int(apart.sum()) - 1))
    fine = np.interp(np.linspace(0.0, x.size - 1.0, _FINE * (x.size - 1) + 1), np.arange(x.size), along)
    smooth = curve(fine)
    return smooth[:, 0], smooth[:, 1]


def draw_special(axes: Axes, branch: Branch, name: str) -> None:
    """The special points with their marks."""
    color = _color(branch.model)
    for kind in ("LP", "PD", "NS"):
        found = [(one.point.parameter, figures_of(one.point.closed)[name]) for one in branch.of_kind(kind)]
        if found:
            axes.plot(*zip(*found, strict=True), MARKS[kind], **_mark(kind, color))
    start = branch.onset.period if name == "period" else 0.0
    axes.plot([branch.onset.parameter], [start], MARKS["HB"], **_mark("HB", color))


def _mark(kind: str, color: str) -> dict[str, Any]:
    face = color if kind in ("LP", "NS") else "white"
    return {"color": color, "markerfacecolor": face, "markersize": SIZES[kind], "markeredgewidth": 0.8, "linestyle": "none"}


_WAVE: dict[str, Any] = {
    "color": "#d55e00",
    "markerfacecolor": "none",
    "markersize": 7.0,
    "markeredgewidth": 1.2,
    "linestyle": "none",
}


def _keys(models: Iterable[str], waves: Iterable[WaveOrbit]) -> Iterator[Any]:
    """Lines for the legend: models, kinds of points, the full wave."""
    from matplotlib.lines import Line2D

    for model in models:
        look = pen(model)
        yield Line2D([], [], color=_color(model), linewidth=look.width, label=look.label)
    yield from special_keys(NAMES)
    if waves:
        yield Line2D([], [], marker="o", label=f"full wave, {WAVE}", **_WAVE)


def special_keys(kinds: Iterable[str]) -> Iterator[Any]:
    """Lines for the legend: unstable orbits, and these kinds of points."""
    from matplotlib.lines import Line2D

    yield Line2D([], [], color="#555555", linewidth=_THIN, linestyle=(0, (1.5, 1.2)), label="unstable")
    for kind in kinds:
        yield Line2D([], [], marker=MARKS[kind], label=NAMES[kind], **_mark(kind, "#555555"))
