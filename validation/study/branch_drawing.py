"""Branches of orbits over log10 r in a figure: stable orbits solid, unstable ones thin and dotted, special points marked."""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from reduced.orbit.figures import figures_of
from slipwave.observe.pieces import Array
from validation.chart import DOTTED, GREY, Look, Trace, with_gaps
from validation.compute.looks import model_look
from validation.compute.points import BranchPoint
from validation.study.drawing import Axes, key, style_of
from validation.study.over_r import Branch, parts

NAMES = {"HB": "Hopf point", "LP": "fold", "PD": "period doubling", "NS": "torus point"}
MARKS = {"HB": "s", "LP": ".", "PD": "D", "NS": "*"}
SIZES = {"HB": 5.5, "LP": 3.5, "PD": 3.5, "NS": 5.0}
_THIN = 0.8
_BELOW = 1.5
_APART = 1e-6  # distance, as a share of the curve's size, of points that count as two
_FINE = 6  # points of a curve for each interval between points of the branch
OVERLAID = {"modal:2": "#b55aa8", "modal:4": "#8d2f5e", "modal:8": "#5f3a8c"}
"""Colours of branches that lie on the delay system's, drawn below it: shades of those of modes, because dashes show stability."""


def draw_branch(axes: Axes, model: str, corners: list[BranchPoint], name: str) -> None:
    """Draw the figure `name` of all orbits over log10 r: stable ones solid, unstable ones thin and dotted."""
    look, color = style_of(model), color_of(model)
    for stable, part in parts(corners):
        dashes, width = ("-", look.width) if stable else ((0, (1.5, 1.2)), _THIN)
        x, y = (np.array(values) for values in ([one.value for one in part], [getattr(one, name) for one in part]))
        order = _BELOW if model in OVERLAID else None
        axes.plot(*_smooth(x, y), color=color, linestyle=dashes, linewidth=width, zorder=order)


def color_of(model: str) -> str:
    """The colour of a model's branch."""
    return OVERLAID.get(model, style_of(model).color)


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
    """Draw the special points with their marks."""
    color = color_of(branch.model)
    for kind in ("LP", "PD", "NS"):
        found = [(one.point.parameter, figures_of(one.point.closed)[name]) for one in branch.of_kind(kind)]
        if found:
            axes.plot(*zip(*found, strict=True), MARKS[kind], **_mark(kind, color))
    start = branch.onset.period if name == "period" else 0.0
    axes.plot([branch.onset.parameter], [start], MARKS["HB"], **_mark("HB", color))


def _mark(kind: str, color: str) -> dict[str, Any]:
    face = color if kind in ("LP", "NS") else "white"
    return {"color": color, "markerfacecolor": face, "markersize": SIZES[kind], "markeredgewidth": 0.8, "linestyle": "none"}


def special_keys(kinds: Iterable[str]) -> Iterator[Any]:
    """Lines for the legend: unstable orbits, and these kinds of points."""
    yield key(color="#555555", linewidth=_THIN, linestyle=(0, (1.5, 1.2)), label="unstable")
    for kind in kinds:
        yield key(marker=MARKS[kind], label=NAMES[kind], **_mark(kind, "#555555"))


def branch_traces(branch: Branch, name: str) -> Iterator[Trace]:
    """The figure `name` of all orbits over log10 r, stable and unstable, and of the special points, with their marks."""
    label, model = style_of(branch.model).label, branch.model
    looks = {"": model_look(model, dashes="-", kind="smooth"), ", unstable": _UNSTABLE.but(color=style_of(model).color)}
    for words, look in looks.items():
        curves = [corners for stable, corners in parts(branch.corners) if stable != bool(words)]
        points = (([one.value for one in corners], [getattr(one, name) for one in corners]) for corners in curves)
        yield Trace(label + words, *with_gaps(points), look)
    found = [("HB", branch.onset.parameter, branch.onset.period if name == "period" else 0.0)]
    found += [(one.kind, one.point.parameter, figures_of(one.point.closed)[name]) for one in branch.special]
    for kind in dict.fromkeys(kind for kind, *_ in found):
        x, y = zip(*(place for own, *place in found if own == kind), strict=True)
        yield Trace(f"{NAMES[kind]}, {label}", x, y, _marks(kind, style_of(model).color))


def branch_keys(kinds: Iterable[str]) -> Iterator[Trace]:
    """Entries of a legend: unstable orbits, and these kinds of points."""
    yield Trace("unstable", [], [], _UNSTABLE)
    for kind in kinds:
        yield Trace(NAMES[kind], [], [], _marks(kind, GREY))


_UNSTABLE = Look(GREY, DOTTED, width=_THIN, kind="smooth")


def _marks(kind: str, color: str) -> Look:
    return Look(color, "", MARKS[kind], size=SIZES[kind], hollow=kind in ("HB", "PD"))
