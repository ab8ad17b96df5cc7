"""Reads the content of a drawing from its matplotlib axes as a chart, until every study gives charts."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Any

import numpy as np

from slipwave.observe.pieces import Array
from validation.chart import Chart, Panel, Scale, Trace
from validation.chart.draw import Drawing
from validation.chart.labels import look_from_words, plain_label
from validation.chart.thin import CELLS, MOST, staying

_FEW = 12  # points that are never thinned
_DOTTED = 2.0  # a dash of less, in line widths, is a dot


@dataclass(frozen=True)
class Drawn:
    """One curve, cloud of points, area (its outline) or picture (its cells, with their `value`): name, look, points, half widths
    of error bars. `guide`: a straight line across the panel."""

    name: str
    look: str
    x: Array
    y: Array
    errors: tuple[Array | None, Array | None] = (None, None)
    value: Array | None = None
    color: str = "#777777"
    guide: bool = field(default=False, compare=False)


def thin_out(figure: Drawing) -> None:
    """Leave at most `MOST` points of each curve of each panel; parts of one curve share them by their length."""
    for axes in _panels(figure):
        low, high = sorted(axes.get_xlim())
        for _, same in groupby(sorted(axes.lines, key=_same), key=_same):
            lines = [line for line in same if line.get_transform() == axes.transData and len(line.get_xdata()) > _FEW]
            curves = [_shown(*_points(line), low, high) for line in lines]
            every = sum(x.size for x, _ in curves)
            for line, (x, y) in zip(lines, curves, strict=True):
                chosen = staying(x, y, x.size if every <= MOST else max(_FEW, MOST * x.size // every))
                line.set_data(x[chosen], y[chosen])


def _points(line: Any) -> tuple[Array, Array]:
    x, y = line.get_data(orig=False)
    return _plain(x), _plain(y)


def _plain(values: Any) -> Array:
    """Array without mask."""
    return np.asarray(np.ma.filled(np.ma.asarray(values, float), np.nan))


def _shown(x: Array, y: Array, low: float, high: float) -> tuple[Array, Array]:
    """A curve cut to its panel, with a gap, and the points next to it, where it leaves it."""
    hidden = np.zeros(x.size, bool)
    for beyond in (x < low, x > high):
        hidden |= beyond & np.r_[True, beyond[:-1]] & np.r_[beyond[1:], True]
    stays = ~(hidden & np.r_[True, hidden[:-1]])
    return x[stays], np.where(hidden, np.nan, y)[stays]


def drawn(figure: Drawing) -> Chart:
    """All panels of a figure, with what they show; colour bars are left out."""
    taken: dict[str, int] = {}
    panels = [_panel(axes, figure, taken) for axes in _panels(figure)]
    return Chart(panels, columns=len(panels), share=("", ""))


def _panels(figure: Drawing) -> list[Any]:
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def _panel(axes: Any, figure: Drawing, taken: dict[str, int]) -> Panel:
    x_label, y_label = (plain_label(_shared(axes, which)) for which in "xy")
    title = plain_label(axes.get_title(loc="left") or axes.get_title()).strip()
    name = title or y_label or "panel"
    taken[name] = taken.get(name, 0) + 1
    limits = [(float(low), float(high)) for low, high in (axes.get_xlim(), axes.get_ylim())]
    legends = [axes.get_legend(), *figure.legends, *(other.get_legend() for other in figure.axes if other is not axes)]
    entries = [entry for legend in legends for entry in _entries(legend)]
    curves = _joined(one for one in (*_curves(axes, entries, title), *_areas(axes)) if one.x.size)
    name += f" ({taken[name]})" if taken[name] > 1 else ""
    x, y = Scale(x_label, axes.get_xscale(), limits[0]), Scale(y_label, axes.get_yscale(), limits[1])
    return Panel(name, x, y, [_series(one) for one in curves])


def _series(one: Drawn) -> Trace:
    look = look_from_words(one.look, one.color)
    if one.guide and look.kind != "area":
        look = replace(look, kind="guide")
    if one.value is not None:
        width = int(np.flatnonzero(np.r_[one.x[1:] == one.x[0], True])[0]) + 1
        return Trace(one.name, one.x[:width], one.y[::width], look, value=one.value.reshape(-1, width))
    return Trace(one.name, one.x, one.y, look, *one.errors)


def _shared(axes: Any, which: str) -> str:
    """The label of an axis, or that of the panel which shares it."""
    group = getattr(axes, f"get_shared_{which}_axes")().get_siblings(axes)
    own = str(getattr(axes, f"get_{which}label")())
    return own or next((label for other in group if (label := str(getattr(other, f"get_{which}label")()))), "")


def _entries(legend: Any) -> list[tuple[str, str, str]]:
    """Look, colour and words of each line in a legend."""
    pairs = zip(legend.legend_handles, legend.get_texts(), strict=True) if legend else ()
    return [(look_of(one), color_in(one), plain_label(text.get_text())) for one, text in pairs if hasattr(one, "get_marker")]


def look_of(line: Any) -> str:
    """Look of a line except its colour: solid, dashed or dotted, and its marker; points have no line."""
    style, marker = line.get_linestyle(), str(line.get_marker())
    if style == "--":  # what matplotlib calls all patterns given by numbers; only the line itself has them
        style = ":" if line._unscaled_dash_pattern[1][0] < _DOTTED else "--"
    words = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dash-dotted"}.get(style, "points")
    steps = "" if line.get_drawstyle() == "default" else f" {line.get_drawstyle()}"
    return words + steps + ("" if marker in ("None", "none", "", " ") else f" {marker}")


def color_in(line: Any) -> str:
    """The colour of a line, as #rrggbb."""
    from matplotlib.colors import to_hex

    return str(to_hex(line.get_color()))


def _same(line: Any) -> tuple[str, str, str]:
    label = str(line.get_label())
    return look_of(line), color_in(line), "" if label.startswith("_") else label


def _named(line: Any, entries: list[tuple[str, str, str]], title: str) -> str:
    """Name of a line: its own label, or the legend's entries of its colour and of its look, or the panel's title."""
    look, color, label = _same(line)
    if label:
        return plain_label(label)
    _, _, marker = look.partition(" ")
    colored = [(entry, words) for entry, paint, words in entries if paint == color]
    whole = [words for entry, words in colored if entry == look]
    if alike := whole + [words for entry, words in colored if marker and entry.partition(" ")[2] == marker]:
        return alike[0]
    styled = next((words for entry, _, words in entries if entry == look and (entry != "solid" or not colored)), "")
    words = [colored[0][1]] if colored else []
    return ", ".join([*words, *([styled] if styled else [look] if look != "solid" and not title else [])]) or title or "curve"


def _curves(axes: Any, entries: list[tuple[str, str, str]], title: str) -> Iterator[Drawn]:
    bars = {id(one.lines[0]): one for one in axes.containers if hasattr(one, "has_yerr")}
    caps = {id(cap) for one in bars.values() for cap in one.lines[1]}
    for line in axes.lines:
        if id(line) in caps:
            continue
        x, y = _points(line)
        guide = line.get_transform() != axes.transData
        if guide:  # part of it is in shares of the panel
            x, y = (line.get_transform() - axes.transData).transform(np.column_stack([x, y])).T
        container = bars.get(id(line))
        name = str(container.get_label()) if container and not str(container.get_label()).startswith("_") else ""
        errors = _errors(container) if container else (None, None)
        named = plain_label(name) or _named(line, entries, title)
        yield Drawn(named, look_of(line), x, y, errors, color=color_in(line), guide=guide)


def _errors(container: Any) -> tuple[Array | None, Array | None]:
    """Half widths of error bars, from the bars that are drawn."""
    found: list[Array | None] = []
    bars = list(container.lines[2])
    for has, column in ((container.has_xerr, 0), (container.has_yerr, 1)):
        segments = bars.pop(0).get_segments() if has else None  # one without points stands for a bar that is not known
        widths = [0.5 * np.ptp(one[:, column]) if np.size(one) else np.nan for one in segments or ()]
        found.append(None if segments is None else np.array(widths))
    return found[0], found[1]


def _areas(axes: Any) -> Iterator[Drawn]:
    """Filled areas by their outlines, clouds of points, pictures by their cells."""
    from matplotlib.collections import PathCollection, PolyCollection, QuadMesh

    for patch in axes.patches:
        outline = (patch.get_transform() - axes.transData).transform(patch.get_path().to_polygons(closed_only=False)[0])
        yield Drawn("area", "area", outline[:, 0], outline[:, 1], guide=True)
    for one in axes.collections:
        if isinstance(one, PathCollection):
            points = _plain(one.get_offsets())
            yield Drawn(plain_label(str(one.get_label())).lstrip("_"), "points", points[:, 0], points[:, 1])
        elif isinstance(one, PolyCollection):
            for path in one.get_paths():
                outline = np.asarray(path.vertices, float)
                yield Drawn("area", "area", outline[:, 0], outline[:, 1], guide=True)
        elif isinstance(one, QuadMesh):
            yield _cells(one)


def _cells(mesh: Any) -> Drawn:
    """Every k-th cell of a picture."""
    corners, values = _plain(mesh.get_coordinates()), _plain(mesh.get_array())
    if values.shape != corners.shape[:2]:  # one value a cell, not a corner
        corners = 0.25 * (corners[1:, 1:] + corners[1:, :-1] + corners[:-1, 1:] + corners[:-1, :-1])
    rows, columns = (np.unique(np.linspace(0, n - 1, min(n, CELLS)).astype(int)) for n in values.shape)
    chosen = np.ix_(rows, columns)
    x, y = np.moveaxis(corners[chosen], -1, 0)
    name = plain_label(mesh.colorbar.ax.get_ylabel()) if mesh.colorbar else ""
    return Drawn(name or "cells", "cells", x.ravel(), y.ravel(), value=values[chosen].ravel())


def _joined(curves: Iterable[Drawn]) -> Iterator[Drawn]:
    """Parts of one name, look and colour as one curve with gaps; names that several curves have are numbered."""
    groups: dict[tuple[str, str, str], list[Drawn]] = {}
    for one in curves:
        groups.setdefault((one.name, one.look, one.color), []).append(one)
    seen: dict[str, int] = {}
    for parts in groups.values():
        first = parts[0]
        seen[first.name] = seen.get(first.name, 0) + 1
        name = first.name + (f" ({seen[first.name]})" if seen[first.name] > 1 else "")
        apart = not first.look.startswith(("points", "cells"))  # only points that are joined need a gap between parts
        x, y = (_chained([getattr(part, axis) for part in parts], apart) for axis in ("x", "y"))
        widths = [None if first.errors[k] is None else _chained([part.errors[k] for part in parts], apart) for k in range(2)]
        yield replace(first, name=name, x=x, y=y, errors=(widths[0], widths[1]))


def _chained(parts: Iterable[Any], apart: bool) -> Array:
    pieces = [piece for part in parts for piece in ([np.nan], np.asarray(part, float))] if apart else list(parts)
    return np.concatenate(pieces[1:] if apart else pieces)
