"""Charts of a branch, period and both stress drops with stable and unstable parts, and of a curve of special points."""

from collections.abc import Iterator
from itertools import groupby

from validation.chart import BLUE, GREY, INK, ORANGE, Chart, Look, Panel, Scale, Trace, with_gaps
from validation.chart.looks import NAMES
from validation.models.branch import FollowedBranch
from validation.models.curve import Curve
from validation.models.points import SPECIAL_KINDS, CurvePoint

_QUANTITIES = {"period": "period $T$ / transits", "stress_drop": "stress drop", "elastic_stress_drop": "elastic stress drop"}
_MARKS = {"HB": (INK, "o"), "LP": (BLUE, "s"), "PD": (ORANGE, "^"), "NS": ("#009e73", "D")}
_CUSP = Look(INK, "", "v", size=5.0)
_LOOKS = {
    True: ("stable", Look(width=1.9)),
    False: ("unstable", Look(GREY, (0, (4, 1.5)), width=0.8)),
    None: ("stability not decided", Look(GREY, width=0.9)),
}


def chart_of_branch(branch: FollowedBranch) -> Chart:
    """One panel per quantity."""
    panels = [
        Panel("", Scale(branch.over.label), Scale(label), [*_pieces(branch, name), *_special(branch, name)])
        for name, label in _QUANTITIES.items()
    ]
    title = f"{branch.over.base.name}, {branch.model}: periodic orbits"
    return Chart(panels, 8.5, legend="outside lower left", legend_columns=4, title=title)


def _pieces(branch: FollowedBranch, name: str) -> Iterator[Trace]:
    """The branch in pieces of one stability within the range, which meet at the special points between them."""
    ends, holds = {special.place: special for special in branch.special}, branch.over.holds
    for stable, (label, look) in _LOOKS.items():
        pieces = []
        for (own, inside), group in groupby(enumerate(branch.points), lambda one: (one[1].stable, holds(one[1].value))):
            piece = list(group)
            first, last = ends.get(piece[0][0]), ends.get(piece[-1][0] + 1)
            run = [one for one in (first, *(point for _, point in piece), last) if one and holds(one.value)]
            pieces += [([one.value for one in run], [getattr(one, name) for one in run])] if own is stable and inside else []
        if pieces:
            yield Trace(label, *with_gaps(pieces), look)


def _special(branch: FollowedBranch, name: str) -> Iterator[Trace]:
    for kind, (color, marker) in _MARKS.items():
        found = [special for special in branch.shown_special if special.kind == kind]
        if found:
            positions = [special.value for special in found], [getattr(special, name) for special in found]
            yield Trace(NAMES[kind], *positions, Look(color, "", marker, size=4.0, hollow=kind == "HB"))


def chart_of_curve(curve: Curve) -> Chart:
    """Left: the second parameter over the first. Right: the second over the period. A cusp at the end is marked."""
    cusp = [one for one in curve.points if one.kind == "CP"]

    def along(name: str, points: list[CurvePoint], look: Look, label: str = "") -> Trace:
        return Trace(label, [getattr(one, name) for one in points], [one.second for one in points], look)

    panels = []
    for name, label in (("first", curve.over.label), ("period", _QUANTITIES["period"])):
        traces = [along(name, curve.points, Look(marker=".")), *([along(name, cusp, _CUSP, "cusp")] if cusp else [])]
        panels.append(Panel("", Scale(label), Scale(curve.second.label), traces, grid=True))
    return Chart(panels, 4.0, 2, title=f"{curve.over.base.name}, {curve.model}: {SPECIAL_KINDS[curve.kind]}")
