"""Branches of orbits over log10 r in a chart: stable orbits solid, unstable ones thin and dotted, special points marked."""

from collections.abc import Iterable, Iterator

from reduced.orbit.periodic import figures_of
from validation.chart import DOTTED, GREY, Look, Trace, with_gaps
from validation.chart.looks import NAMES, model_look, style_of
from validation.measure.over_r import Branch, parts

_MARKS = {"HB": ("s", 5.5, True), "LP": (".", 3.5, False), "PD": ("D", 3.5, True), "NS": ("*", 5.0, False)}
"""Kind of special point -> its marker, its size, whether it is hollow."""
_UNSTABLE = Look(GREY, DOTTED, width=0.8, kind="smooth")


def orbit_traces(branch: Branch, name: str) -> Iterator[Trace]:
    """The figure `name` of all orbits over log10 r: stable ones, unstable ones."""
    color = style_of(branch.model).color
    looks = {"": model_look(branch.model, dashes="-", kind="smooth"), ", unstable": _UNSTABLE.but(color=color)}
    for words, look in looks.items():
        curves = [corners for stable, corners in parts(branch.corners) if stable != bool(words)]
        points = (([point.value for point in corners], [getattr(point, name) for point in corners]) for corners in curves)
        yield Trace(branch.model + words, *with_gaps(points), look)


def branch_traces(branch: Branch, name: str) -> Iterator[Trace]:
    """As `orbit_traces`, and the special points with their marks."""
    yield from orbit_traces(branch, name)
    marked = [("HB", branch.onset.parameter, branch.onset.period if name == "period" else 0.0)]
    marked += [(special.kind, special.point.parameter, figures_of(special.point.closed)[name]) for special in branch.special]
    for kind in dict.fromkeys(kind for kind, *_ in marked):
        x, y = zip(*(place for own, *place in marked if own == kind), strict=True)
        yield Trace(f"{NAMES[kind]}, {branch.model}", x, y, _mark(kind, style_of(branch.model).color))


def branch_keys(kinds: Iterable[str]) -> Iterator[Trace]:
    """Entries of a legend: unstable orbits, and these kinds of points."""
    yield Trace("unstable", [], [], _UNSTABLE)
    yield from (Trace(NAMES[kind], [], [], _mark(kind, GREY)) for kind in kinds)


def _mark(kind: str, color: str) -> Look:
    marker, size, hollow = _MARKS[kind]
    return Look(color, "", marker, size=size, hollow=hollow)
