"""Describes a figure in words, generated from the drawn numbers, as its alternative text."""

import re
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from slipwave.observe.pieces import Array
from validation.study.drawn import Drawn, Panel

_COMPARED = 8  # curves of which each pair is looked at for crossings
_LISTED = 12  # curves that are described one by one


def title_of(panels: Sequence[Panel]) -> str:
    """One sentence: axes, number of curves, and largest and least value of the first panel."""
    first = panels[0]
    count = sum(len(_described(panel)) for panel in panels)
    where = f" in {len(panels)} panels" if len(panels) > 1 else ""
    parts = [f"{_axes(first)}: {count} {'curve' if count == 1 else 'curves'}{where}"]
    curves = _described(first)
    if curves:
        high = max(curves, key=lambda one: float(np.nanmax(_values(one))))
        low = min(curves, key=lambda one: float(np.nanmin(_values(one))))
        parts += [f"largest {_extreme(high, first, True)}", f"least {_extreme(low, first, False)}"]
    return _signed("; ".join(parts)) + "."


def description_of(panels: Sequence[Panel]) -> str:
    """Sentences on every panel: ranges of its curves, their crossings, and the highest at the right end."""
    return _signed(" ".join(sentence for panel in panels for sentence in _sentences(panel)))


def _signed(text: str) -> str:
    """`text` with true minus signs before numbers; hyphens of words unchanged."""
    return re.sub(r"(?<=[\s(=])-(?=\d)|(?<=\de)-(?=\d)", "−", text)


def _axes(panel: Panel) -> str:
    return f"{panel.y_label or panel.name} over {panel.x_label}" if panel.x_label else panel.y_label or panel.name


def _described(panel: Panel) -> list[Drawn]:
    """Curves with finite values, without guides."""
    return [one for one in panel.curves if not one.guide and np.isfinite(_values(one)).any()]


def _values(one: Drawn) -> Array:
    return one.y if one.value is None else one.value


def _sentences(panel: Panel) -> Iterator[str]:
    curves = _described(panel)
    (left, right), (low, high) = panel.limits
    logarithmic = [label for label, scale in zip(("x", "y"), panel.scales, strict=True) if scale == "log"]
    scales = f", logarithmic in {' and '.join(logarithmic)}" if logarithmic else ""
    yield f"{panel.name}: {_axes(panel)}; x from {left:.4g} to {right:.4g}, y from {low:.4g} to {high:.4g}{scales}."
    for one in curves[:_LISTED]:
        style = "" if one.look.startswith(("solid", "cells")) else f" ({one.look.split()[0]})"
        yield f"{one.name}{style}: {one.x.size} points, largest {_at(one, True)}, least {_at(one, False)}."
    if len(curves) > _LISTED:
        yield f"And {len(curves) - _LISTED} more."
    rising = [one for one in curves if one.value is None and one.x.size > 1 and np.all(np.diff(one.x) > 0.0)]
    functions = [one for one in rising if np.isfinite(one.y).all()][:_COMPARED]
    for one, other in combinations(functions, 2):
        crossings = meetings(one, other)
        if crossings.size:
            times = "once" if crossings.size == 1 else f"{crossings.size} times, first"
            yield f"{one.name} and {other.name} cross {times} at x = {crossings[0]:.4g}."
    yield from _ends(functions)


def _ends(functions: Sequence[Drawn]) -> Iterator[str]:
    if len(functions) > 1:
        end = min(float(one.x[-1]) for one in functions)
        last = [(float(np.interp(end, one.x, one.y)), one.name) for one in functions if one.x[0] < end]
        if len(last) > 1:
            yield f"At x = {end:.4g} {max(last)[1]} is highest ({max(last)[0]:.4g}), {min(last)[1]} lowest ({min(last)[0]:.4g})."


def meetings(one: Drawn, other: Drawn) -> Array:
    """x at which two curves over rising x cross, by straight lines."""
    low, high = max(one.x[0], other.x[0]), min(one.x[-1], other.x[-1])
    x = np.unique(np.concatenate([one.x, other.x]))
    x = x[(x >= low) & (x <= high)]
    apart = np.interp(x, one.x, one.y) - np.interp(x, other.x, other.y)
    k = np.flatnonzero(apart[:-1] * apart[1:] < 0.0)
    return np.asarray(x[k] - apart[k] * (x[k + 1] - x[k]) / (apart[k + 1] - apart[k]))


def _at(one: Drawn, largest: bool) -> str:
    values = _values(one)
    k = int(np.nanargmax(values) if largest else np.nanargmin(values))
    return f"{values[k]:.4g} at x = {one.x[k]:.4g}" + (f", y = {one.y[k]:.4g}" if one.value is not None else "")


def _extreme(one: Drawn, panel: Panel, largest: bool) -> str:
    return _at(one, largest) + (f" ({one.name})" if one.name != panel.name and one.value is None else "")
