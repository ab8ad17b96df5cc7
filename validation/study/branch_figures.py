"""Figures of a branch, period and both stress drops with stable and unstable parts, and of a curve of special points."""

from itertools import groupby
from typing import Any

from validation.compute.branch import FollowedBranch
from validation.compute.curve import Curve
from validation.compute.points import SPECIAL_KINDS
from validation.study.branch_drawing import NAMES
from validation.study.drawing import Axes, Drawing, subplots

_QUANTITIES = {"period": "period $T$ / transits", "stress_drop": "stress drop", "elastic_stress_drop": "elastic stress drop"}
_MARKS: dict[str, Any] = {
    "HB": {"marker": "o", "markerfacecolor": "white"},
    "LP": {"marker": "s", "color": "#0072b2"},
    "PD": {"marker": "^", "color": "#d55e00"},
    "NS": {"marker": "D", "color": "#009e73"},
}
_STYLES: dict[bool | None, Any] = {
    True: {"linewidth": 1.9, "color": "#111111", "label": "stable"},
    False: {"linewidth": 0.8, "color": "#777777", "dashes": (4, 1.5), "label": "unstable"},
    None: {"linewidth": 0.9, "color": "#777777", "label": "stability not decided"},
}


def figure_of_branch(branch: FollowedBranch) -> Drawing:
    """Draw one panel per quantity. Call it inside `styled()`."""
    figure, panels = subplots(8.5, len(_QUANTITIES), 1, branch.over.name, sharex=True)
    for axes, (name, label) in zip(panels, _QUANTITIES.items(), strict=True):
        _draw_pieces(axes, branch, name)
        _draw_special(axes, branch, name)
        axes.set_ylabel(label)
    panels[0].set_title(f"{branch.over.base.name}, {branch.model}: periodic orbits")
    panels[0].legend(loc="best")
    return figure


def _draw_pieces(axes: Axes, branch: FollowedBranch, name: str) -> None:
    """The branch in pieces of one stability, which meet at the special points between them."""
    for stable, style in _STYLES.items():
        if any(point.stable is stable for point in branch.shown):
            axes.plot([], [], **style)
    ends = {special.place: special for special in branch.special}
    for stable, group in groupby(enumerate(branch.points), key=lambda numbered: numbered[1].stable):
        piece = list(group)
        first, last = ends.get(piece[0][0]), ends.get(piece[-1][0] + 1)
        run = [one for one in (first, *(point for _, point in piece), last) if one and branch.over.holds(one.value)]
        axes.plot([one.value for one in run], [getattr(one, name) for one in run], **_STYLES[stable] | {"label": None})


def _draw_special(axes: Axes, branch: FollowedBranch, name: str) -> None:
    for kind, look in _MARKS.items():
        found = [special for special in branch.shown_special if special.kind == kind]
        if found:
            positions = [special.value for special in found], [getattr(special, name) for special in found]
            axes.plot(
                *positions,
                label=NAMES[kind],
                **({"color": "#111111", "linestyle": "none", "markersize": 4.0, "zorder": 3} | look),
            )


def figure_of_curve(curve: Curve) -> Drawing:
    """Left: the second parameter over the first. Right: the second over the period. Call it inside `styled()`."""
    figure, panels = subplots(4.0, 1, 2, sharey=True)
    for axes, name, label in zip(panels, ("first", "period"), (curve.over.name, "period $T$ / transits"), strict=True):
        positions = [getattr(point, name) for point in curve.points], [point.second for point in curve.points]
        axes.plot(*positions, color="#111111", marker=".")
        axes.set_xlabel(label)
        axes.grid(True)
    panels[0].set(ylabel=curve.second.name, title=f"{curve.over.base.name}, {curve.model}: {SPECIAL_KINDS[curve.kind]}")
    return figure
