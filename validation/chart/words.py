"""A chart in words, made of its numbers, as its alternative text."""

import re
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from slipwave.observe.pieces import Array
from validation.chart import Chart, Panel
from validation.chart.table import look_in_words, panel_facts, trace_names

_COMPARED = 8  # curves of which each pair is looked at for crossings
_LISTED = 12  # curves that are described one by one


class _Curve(NamedTuple):
    name: str
    look: str
    x: Array
    y: Array
    value: Array | None

    @property
    def values(self) -> Array:
        return self.y if self.value is None else self.value

    def at(self, largest: bool) -> str:
        """Its largest or least value, and where that is."""
        k = int(np.nanargmax(self.values) if largest else np.nanargmin(self.values))
        return f"{self.values[k]:.4g} at x = {self.x[k]:.4g}" + (f", y = {self.y[k]:.4g}" if self.value is not None else "")


def described(chart: Chart) -> tuple[str, str]:
    """One sentence: axes, number of curves, largest and least value of the first panel. Then sentences on every panel: ranges of
    its curves, their crossings, and the highest at the right end."""
    every = [_described(panel) for panel in chart.panels]
    facts = panel_facts(chart)
    count, where = sum(map(len, every)), f" in {len(every)} panels" if len(every) > 1 else ""
    parts = [f"{_axes(facts[0])}: {count} {'curve' if count == 1 else 'curves'}{where}"]
    if every[0]:
        high = max(every[0], key=lambda one: float(np.nanmax(one.values)))
        low = min(every[0], key=lambda one: float(np.nanmin(one.values)))
        for word, one in (("largest", high), ("least", low)):
            name = f" ({one.name})" if one.name != facts[0]["name"] and one.value is None else ""
            parts.append(f"{word} {one.at(one is high and word == 'largest')}{name}")
    sentences = (sentence for curves, fact in zip(every, facts, strict=True) for sentence in _sentences(curves, fact))
    return _signed("; ".join(parts)) + ".", _signed(" ".join(sentences))


def _signed(text: str) -> str:
    """`text` with true minus signs before numbers; hyphens of words unchanged."""
    return re.sub(r"(?<=[\s(=])-(?=\d)|(?<=\de)-(?=\d)", "−", text)


def _axes(fact: dict[str, Any]) -> str:
    above = str(fact["y_label"] or fact["name"])
    return f"{above} over {fact['x_label']}" if fact["x_label"] else above


def _described(panel: Panel) -> list[_Curve]:
    """Trace with finite values, without guides, areas and texts."""
    curves = []
    for name, trace in zip(trace_names(panel), panel.traces, strict=True):
        columns = trace.columns
        one = _Curve(name, look_in_words(trace.look), columns["x"], columns["y"], columns.get("value"))
        curves += [one] if trace.is_said and np.isfinite(one.values).any() else []
    return curves


def _sentences(curves: Sequence[_Curve], fact: dict[str, Any]) -> Iterator[str]:
    (left, right), (low, high) = fact["limits"]
    logarithmic = [label for label, scale in zip(("x", "y"), fact["scales"], strict=True) if scale == "log"]
    scales = f", logarithmic in {' and '.join(logarithmic)}" if logarithmic else ""
    yield f"{fact['name']}: {_axes(fact)}; x from {left:.4g} to {right:.4g}, y from {low:.4g} to {high:.4g}{scales}."
    for one in curves[:_LISTED]:
        style = "" if one.look.startswith(("solid", "cells")) else f" ({one.look.split()[0]})"
        yield f"{one.name}{style}: {one.x.size} points, largest {one.at(True)}, least {one.at(False)}."
    if len(curves) > _LISTED:
        yield f"And {len(curves) - _LISTED} more."
    rising = [one for one in curves if one.value is None and one.x.size > 1 and np.all(np.diff(one.x) > 0.0)]
    functions = [one for one in rising if np.isfinite(one.y).all()][:_COMPARED]
    for one, other in combinations(functions, 2):
        every = np.unique(np.concatenate([one.x, other.x]))
        every = every[(every >= max(one.x[0], other.x[0])) & (every <= min(one.x[-1], other.x[-1]))]
        apart = np.interp(every, one.x, one.y) - np.interp(every, other.x, other.y)
        k = np.flatnonzero(apart[:-1] * apart[1:] < 0.0)
        if k.size:
            times, n = "once" if k.size == 1 else f"{k.size} times, first", k[0]
            first = every[n] - apart[n] * (every[n + 1] - every[n]) / (apart[n + 1] - apart[n])
            yield f"{one.name} and {other.name} cross {times} at x = {first:.4g}."
    yield from _ends(functions)


def _ends(functions: Sequence[_Curve]) -> Iterator[str]:
    if len(functions) > 1:
        end = min(float(one.x[-1]) for one in functions)
        last = [(float(np.interp(end, one.x, one.y)), one.name) for one in functions if one.x[0] < end]
        if len(last) > 1:
            yield f"At x = {end:.4g} {max(last)[1]} is highest ({max(last)[0]:.4g}), {min(last)[1]} lowest ({min(last)[0]:.4g})."
