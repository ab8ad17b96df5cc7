"""The CSV file of a chart, from which it can be drawn again, and the facts of its panels, which the file lacks; words of a look,
and labels without the markup of formulas."""

import csv
import io
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import Any

import numpy as np

from slipwave.observe.pieces import Array
from validation.chart import Chart, Look, Panel, Scale, Trace, with_limits

HEADER = ("panel", "series", "look", "x", "y", "y_error", "value")
"""Columns of the file; the last ones only if a chart has them. An empty row of a trace is a gap in its curve."""

_DIGITS = ".8g"
_NUMBERS = HEADER[3:]
_DOTTED = 2.0  # a dash of less, in line widths, is a dot
_STYLES = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dash-dotted", "": "points"}
_WORDLESS = ("cells", "area", "text")


def curves_csv(chart: Chart) -> str:
    """The text of the file: every number as it was computed."""
    chart = with_limits(chart)
    rows = [(name, *row) for name, panel in zip(_names(chart), chart.panels, strict=True) for row in _rows(panel)]
    used = [k for k in range(len(HEADER)) if k < 5 or any(row[k] for row in rows)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerows([row[k] for k in used] for row in (HEADER, *rows))
    return text.getvalue()


def _names(chart: Chart) -> list[str]:
    return list(_numbered(panel.name or panel.y.label or "panel" for panel in chart.panels))


def trace_names(panel: Panel) -> list[str]:
    """The names of its traces in the file and in words, no two alike."""
    return list(_numbered(trace.name or trace.look.kind for trace in panel.traces))


def _rows(panel: Panel) -> Iterator[tuple[str, ...]]:
    for name, trace in zip(trace_names(panel), panel.traces, strict=True):
        look, columns = look_in_words(trace.look), trace.columns
        columns["x"], columns["y"] = panel.placed(trace)
        for k in range(columns["x"].size):
            numbers = (float(columns[name][k]) if name in columns else np.nan for name in _NUMBERS)
            yield name, look, *("" if np.isnan(number) else format(number, _DIGITS) for number in numbers)


def panel_facts(chart: Chart) -> list[dict[str, Any]]:
    """Name, labels, scales and limits of every panel, and of its traces the colours and by how much they are drawn moved."""
    chart = with_limits(chart)
    return [
        {
            "name": name,
            "x_label": _plain_label(panel.x.label),
            "y_label": _plain_label(panel.y.label),
            "scales": [panel.x.kind, panel.y.kind],
            "limits": [list(panel.x.ends), list(panel.y.ends)],
            "colors": [trace.look.ink for trace in panel.traces if trace.columns["x"].size],
            "shifts": [list(trace.shift) for trace in panel.traces if trace.columns["x"].size],
        }
        for name, panel in zip(_names(chart), chart.panels, strict=True)
    ]


def read_chart(text: str, facts: Iterable[dict[str, Any]]) -> Chart:
    """The chart of a file and of the `facts` of its panels, side by side."""
    rows = groupby(csv.DictReader(io.StringIO(text)), key=lambda row: row["panel"])
    every = {panel: list(mine) for panel, mine in rows}
    panels = [_panel(every.get(fact["name"], []), **fact) for fact in facts]
    return Chart(panels, columns=len(panels), share=("", ""), legend="outside upper left", legend_columns=4)


def _panel(rows: list[dict[str, str]], name: str, scales: list[str], limits: list[list[float]], **fact: Any) -> Panel:
    groups = [(*key, list(mine)) for key, mine in groupby(rows, key=lambda row: (row["series"], row["look"]))]
    traces = [_trace(*each) for each in zip(groups, fact["colors"], fact["shifts"], strict=True)]
    labels = (fact["x_label"], fact["y_label"])
    x, y = (Scale(label, scale, (low, high)) for label, scale, (low, high) in zip(labels, scales, limits, strict=True))
    return Panel(name, x, y, traces)


def _trace(group: tuple[str, str, list[dict[str, str]]], color: str, shift: list[float]) -> Trace:
    name, look, rows = group

    def column(key: str) -> Array | None:
        known = key in rows[0] and (key in ("x", "y") or any(row[key] for row in rows))
        return np.array([float(row[key] or "nan") for row in rows]) if known else None

    columns = {key: column(key) for key in _NUMBERS}
    x, y, value = columns["x"], columns["y"], columns["value"]
    assert x is not None
    assert y is not None
    if value is not None:  # cells, a row for each y
        width = int(np.flatnonzero(np.r_[x[1:] == x[0], True])[0]) + 1
        x, y, value = x[:width], y[::width], value.reshape(-1, width)
    return Trace(name, x, y, _look_from_words(look, color), columns["y_error"], value, (shift[0], shift[1]))


def look_in_words(look: Look) -> str:
    """Look of a trace except its colour, as in the file: dashes, kind unless it is a line, marker."""
    if look.kind in _WORDLESS:
        return look.kind
    tuples = "dashed" if isinstance(look.dashes, str) or look.dashes[1][0] >= _DOTTED else "dotted"
    words = _STYLES.get(look.dashes, tuples) if isinstance(look.dashes, str) else tuples
    return " ".join(word for word in (words, look.kind if look.kind != "line" else "", look.marker) if word)


def _look_from_words(words: str, color: str) -> Look:
    """Inverse of `look_in_words`, but for widths and sizes."""
    style, *others = words.split(" ")
    if style in _WORDLESS:
        return Look(color, kind=style)
    kinds = [word for word in others if word in ("steps-pre", "smooth", "guide")]
    marker = "".join(word for word in others if word not in kinds)
    dashes = next(dashes for dashes, word in _STYLES.items() if word == style)
    return Look(color, dashes, marker, kind=kinds[0] if kinds else "line")


def _plain_label(text: str) -> str:
    r"""A label without the markup of formulas: "$\log_{10} r$" as "log10 r"."""
    return " ".join(re.sub(r"\$([^$]*)\$", lambda match: _plain_formula(match[1]), text).split())


def _plain_formula(text: str) -> str:
    text = re.sub(r"\\(rm|mathrm|mathit)\b\s*", "", text).replace(r"\,", " ").replace(r"\%", "%").replace("\\ ", " ")
    text = re.sub(r"\\sqrt\{(\w+)\}", "√\\1", text).replace(r"\log_", "log")
    text = re.sub(r"\\([A-Za-z]+)\s?", lambda match: _greek(match[1]), text)
    return re.sub(r"[{}_]|\^(?=\*)", "", text).replace("^*", "*")


def _greek(name: str) -> str:
    """The Greek letter of this name, or the name."""
    size = "CAPITAL" if name[0].isupper() else "SMALL"
    try:
        return unicodedata.lookup(f"GREEK {size} LETTER {name}")
    except KeyError:
        return f"{name} "


def _numbered(names: Iterable[str]) -> Iterator[str]:
    """Plain names, numbered where several are the same."""
    seen = Counter[str]()
    for name in map(_plain_label, names):
        seen[name] += 1
        yield name + (f" ({seen[name]})" if seen[name] > 1 else "")
