"""Reads the content of a drawing from its matplotlib axes: panels with their curves, as rows of a CSV file from which it can be
redrawn.

A curve keeps at most `MOST` points, none beyond its panel. Its points are divided into equal runs; of each, the first and last
are kept, and those of least and largest y (and of x where the curve turns back), so that every extremum is kept.
"""

import csv
import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipwave.observe.pieces import Array
from validation.study.drawing import Drawing, canvas
from validation.study.vector import legible

MOST = 2000
"""Most points of a curve in a panel."""

CELLS = 64
"""Most written cells of a picture in each direction."""

HEADER = ("panel", "series", "look", "x", "y", "x_error", "y_error", "value")
"""Columns of the file; the last ones only if a figure has them. An empty row of a series is a gap in its curve."""

_DIGITS = ".8g"
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
    color: str = ""
    guide: bool = field(default=False, compare=False)


@dataclass(frozen=True)
class Panel:
    """One pair of axes: its name, labels, scales and limits, and all that is drawn in it."""

    name: str
    x_label: str
    y_label: str
    scales: tuple[str, str]
    limits: tuple[tuple[float, float], tuple[float, float]]
    colors: tuple[str, ...] = ()
    curves: tuple[Drawn, ...] = ()

    @property
    def facts(self) -> dict[str, Any]:
        """The panel without its curves."""
        return {name: value for name, value in asdict(self).items() if name != "curves"}


def plain_label(text: str) -> str:
    r"""A label without the markup of formulas: "$\log_{10} r$" as "log10 r"."""
    return " ".join(re.sub(r"\$([^$]*)\$", lambda found: _plain_formula(found[1]), text).split())


def _plain_formula(text: str) -> str:
    from matplotlib._mathtext_data import tex2uni

    text = (
        re.sub(r"\\(rm|mathrm|mathit)\b\s*", "", text)
        .replace(r"\,", " ")
        .replace("\\%", "%")
        .replace("\\ ", " ")
        .replace(r"\log_", "log")
    )
    text = re.sub(r"\\sqrt\{(\w+)\}", "√\\1", text)
    text = re.sub(r"\\([A-Za-z]+)\s?", lambda found: chr(tex2uni[found[1]]) if found[1] in tex2uni else f"{found[1]} ", text)
    return re.sub(r"[{}_]|\^(?=\*)", "", text).replace("^*", "*")


def staying(x: Array, y: Array, most: int = MOST) -> NDArray[np.intp]:
    """Indices of the points that are kept (see the docstring of this module)."""
    if x.size <= most:
        return np.arange(x.size)
    both = (y,) if np.all(np.diff(x) >= 0.0) else (x, y)
    edges = np.linspace(0, x.size, max(1, most // (2 + 2 * len(both))) + 1).astype(int)
    chosen = [*edges[:-1], *(edges[1:] - 1)]
    for begin, end in pairwise(edges):
        finite = [values[begin:end] for values in both if np.isfinite(values[begin:end]).any()]
        chosen += [begin + int(find(values)) for values in finite for find in (np.nanargmin, np.nanargmax)]
    return np.unique(chosen)


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


def drawn(figure: Drawing) -> tuple[Panel, ...]:
    """All panels of a figure, with what they show; colour bars are left out."""
    taken: dict[str, int] = {}
    return tuple(_panel(axes, figure, taken) for axes in _panels(figure))


def _panels(figure: Drawing) -> list[Any]:
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]


def _panel(axes: Any, figure: Drawing, taken: dict[str, int]) -> Panel:
    x_label, y_label = (plain_label(_shared(axes, which)) for which in "xy")
    title = plain_label(axes.get_title(loc="left") or axes.get_title()).strip()
    name = title or y_label or "panel"
    taken[name] = taken.get(name, 0) + 1
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    limits = (float(left), float(right)), (float(low), float(high))
    scales = axes.get_xscale(), axes.get_yscale()
    legends = [axes.get_legend(), *figure.legends, *(other.get_legend() for other in figure.axes if other is not axes)]
    entries = [entry for legend in legends for entry in _entries(legend)]
    curves = _joined(one for one in (*_curves(axes, entries, title), *_areas(axes)) if one.x.size)
    every, name = tuple(curves), name + (f" ({taken[name]})" if taken[name] > 1 else "")
    colors = tuple(legible(one.color) if one.color else "" for one in every)
    return Panel(name, x_label, y_label, scales, limits, colors, every)


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


def curves_csv(panels: Iterable[Panel]) -> str:
    """The text of the CSV file."""
    rows = [(panel.name, *row) for panel in panels for curve in panel.curves for row in _rows(curve)]
    used = [k for k in range(len(HEADER)) if k < 5 or any(row[k] for row in rows)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerows([row[k] for k in used] for row in (HEADER, *rows))
    return text.getvalue()


def _rows(curve: Drawn) -> Iterator[tuple[str, ...]]:
    for k in range(curve.x.size):
        columns = (curve.x, curve.y, *curve.errors, curve.value)
        yield curve.name, curve.look, *("" if column is None else _number(float(column[k])) for column in columns)


def _number(value: float) -> str:
    return "" if np.isnan(value) else format(value, _DIGITS)


def read_curves(text: str, facts: Iterable[dict[str, Any]]) -> tuple[Panel, ...]:
    """Inverse of `curves_csv`; `facts` are those of the panels (`Panel.facts`)."""
    rows = list(csv.DictReader(io.StringIO(text)))
    every = {panel: list(mine) for panel, mine in groupby(rows, key=lambda row: row["panel"])}

    def curve(name: str, look: str, mine: list[dict[str, str]]) -> Drawn:
        def column(key: str) -> Array | None:
            known = key in mine[0] and any(row[key] for row in mine)
            return np.array([float(row[key] or "nan") for row in mine]) if known else None

        x, y = (np.array([float(row[key] or "nan") for row in mine]) for key in ("x", "y"))
        return Drawn(name, look, x, y, (column("x_error"), column("y_error")), column("value"))

    def panel(fact: dict[str, Any]) -> Panel:
        grouped = groupby(every.get(fact["name"], []), key=lambda row: (row["series"], row["look"]))
        return Panel(**fact, curves=tuple(curve(name, look, list(mine)) for (name, look), mine in grouped))

    return tuple(map(panel, facts))


def redraw(panels: Iterable[Panel]) -> Drawing:
    """Draw the panels side by side, from their curves alone. Call it inside `styled()`."""
    every = list(panels)
    figure = canvas(height=4.0)
    styles = {"dashed": "--", "dotted": ":", "dash-dotted": "-.", "points": "none"}
    for axes, panel in zip(figure.subplots(1, len(every), squeeze=False)[0], every, strict=True):
        for curve in panel.curves:
            style, _, marker = re.sub(" steps[a-z-]*", "", curve.look).partition(" ")
            if style == "cells":
                axes.scatter(curve.x, curve.y, c=curve.value, s=4.0, label=curve.name)
            elif style == "area":
                axes.fill(curve.x, curve.y, alpha=0.2, label=curve.name)
            else:
                look: Any = {"linestyle": styles.get(style, "-"), "marker": marker or ("." if style == "points" else "None")}
                if steps := re.search("steps[a-z-]*", curve.look):
                    look["drawstyle"] = steps[0]
                axes.errorbar(curve.x, curve.y, curve.errors[1], curve.errors[0], label=curve.name, **look)
        axes.set(xscale=panel.scales[0], yscale=panel.scales[1], xlim=panel.limits[0], ylim=panel.limits[1])
        axes.set(xlabel=panel.x_label, ylabel=panel.y_label, title=panel.name)
    return figure
