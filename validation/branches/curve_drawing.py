"""A curve of special points in a figure: in the plane of both parameters, and its period."""

from validation.branches import KINDS
from validation.branches.curve import Curve
from validation.study.drawing import Drawing, canvas


def figure_of(curve: Curve) -> Drawing:
    """Left: the second parameter over the first. Right: the second over the period. Call it inside `styled()`."""
    figure = canvas(height=4.0)
    left, right = figure.subplots(1, 2, sharey=True)
    second = [point.second for point in curve.points]
    left.plot([point.first for point in curve.points], second, color="#111111", marker=".")
    right.plot([point.period for point in curve.points], second, color="#111111", marker=".")
    left.set(
        xlabel=curve.over.name, ylabel=curve.second.name, title=f"{curve.over.base.name}, {curve.model}: {KINDS[curve.kind]}"
    )
    right.set(xlabel="period $T$ / transits")
    for axes in (left, right):
        axes.grid(True)
    return figure
