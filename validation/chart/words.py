"""A chart in words, made of its numbers, as its alternative text."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np

from slipwave.observe.pieces import Array
from validation.chart import Chart, Panel, Trace
from validation.chart.table import look_in_words, panel_facts, trace_names

_COMPARED = 8  # curves of which each pair is looked at for crossings
_LISTED = 12  # curves that are described one by one


def _values(trace: Trace) -> Array:
    columns = trace.columns
    return columns.get("value", columns["y"])


def _at(trace: Trace, largest: bool) -> str:
    """Its largest or least value, and where that is."""
    columns, values = trace.columns, _values(trace)
    k = int(np.nanargmax(values) if largest else np.nanargmin(values))
    above = "" if trace.value is None else f", y = {columns['y'][k]:.4g}"
    return f"{values[k]:.4g} at x = {columns['x'][k]:.4g}{above}"


def described(chart: Chart) -> tuple[str, str]:
    """One sentence: axes, number of curves, largest and least value of the first panel. Then sentences on every panel: ranges of
    its curves, their crossings, and the highest at the right end."""
    every = [_described(panel) for panel in chart.panels]
    facts = panel_facts(chart)
    count, where = sum(map(len, every)), f" in {len(every)} panels" if len(every) > 1 else ""
    parts = [f"{_axes(facts[0])}: {count} {'curve' if count == 1 else 'curves'}{where}"]
    if every[0]:
        high = max(every[0], key=lambda curve: float(np.nanmax(_values(curve))))
        low = min(every[0], key=lambda curve: float(np.nanmin(_values(curve))))
        for word, curve in (("largest", high), ("least", low)):
            name = f" ({curve.name})" if curve.name != facts[0]["name"] and curve.value is None else ""
            parts.append(f"{word} {_at(curve, curve is high and word == 'largest')}{name}")
    sentences = (sentence for curves, fact in zip(every, facts, strict=True) for sentence in _sentences(curves, fact))
    return _signed("; ".join(parts)) + ".", _signed(" ".join(sentences))


def _signed(text: str) -> str:
    """`text` with true minus signs before numbers; hyphens of words unchanged."""
    return re.sub(r"(?<=[\s(=])-(?=\d)|(?<=\de)-(?=\d)", "−", text)


def _axes(fact: dict[str, Any]) -> str:
    above = str(fact["y_label"] or fact["name"])
    return f"{above} over {fact['x_label']}" if fact["x_label"] else above


def _described(panel: Panel) -> list[Trace]:
    """Traces with finite values, under their names in the file, without guides, areas and texts."""
    named = (replace(trace, name=name) for name, trace in zip(trace_names(panel), panel.traces, strict=True))
    return [trace for trace in named if trace.is_said and np.isfinite(_values(trace)).any()]


def _sentences(curves: Sequence[Trace], fact: dict[str, Any]) -> Iterator[str]:
    (left, right), (low, high) = fact["limits"]
    logarithmic = [label for label, scale in zip(("x", "y"), fact["scales"], strict=True) if scale == "log"]
    scales = f", logarithmic in {' and '.join(logarithmic)}" if logarithmic else ""
    yield f"{fact['name']}: {_axes(fact)}; x from {left:.4g} to {right:.4g}, y from {low:.4g} to {high:.4g}{scales}."
    for curve in curves[:_LISTED]:
        look = look_in_words(curve.look)
        style = "" if look.startswith(("solid", "cells")) else f" ({look.split()[0]})"
        yield f"{curve.name}{style}: {_values(curve).size} points, largest {_at(curve, True)}, least {_at(curve, False)}."
    if len(curves) > _LISTED:
        yield f"And {len(curves) - _LISTED} more."
    every = [(curve.name, curve.columns["x"], curve.columns["y"]) for curve in curves if curve.value is None]
    rising = [named for named in every if named[1].size > 1 and np.all(np.diff(named[1]) > 0.0)]
    functions = [named for named in rising if np.isfinite(named[2]).all()][:_COMPARED]
    for (name, x, y), (other, others, values) in combinations(functions, 2):
        both = np.unique(np.concatenate([x, others]))
        both = both[(both >= max(x[0], others[0])) & (both <= min(x[-1], others[-1]))]
        apart = np.interp(both, x, y) - np.interp(both, others, values)
        k = np.flatnonzero(apart[:-1] * apart[1:] < 0.0)
        if k.size:
            times, n = "once" if k.size == 1 else f"{k.size} times, first", k[0]
            first = both[n] - apart[n] * (both[n + 1] - both[n]) / (apart[n + 1] - apart[n])
            yield f"{name} and {other} cross {times} at x = {first:.4g}."
    end = min((float(x[-1]) for _, x, _ in functions), default=0.0)
    last = [(float(np.interp(end, x, y)), name) for name, x, y in functions if x[0] < end]
    if len(last) > 1:
        yield f"At x = {end:.4g} {max(last)[1]} is highest ({max(last)[0]:.4g}), {min(last)[1]} lowest ({min(last)[0]:.4g})."
