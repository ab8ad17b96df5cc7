"""Draws a chart with matplotlib: legible on paper; dashes and markers distinguish traces without colour."""

import re
import textwrap
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from slipwave.extras import require
from slipwave.files import ONE_THREAD
from slipwave.observe.pieces import Array
from validation.chart import EMPTY, Chart, Look, Panel, Scale, Trace, cell_edges, with_limits

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
    from matplotlib.figure import Figure

    Drawing: TypeAlias = Figure
else:  # matplotlib is loaded only when something is drawn
    Axes = Drawing = Any

STYLE: Any = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral"],
    "mathtext.fontset": "stix",
    "font.size": 11,
    "axes.labelsize": 11.5,
    "axes.titlesize": 11.5,
    "axes.titlelocation": "left",
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": False,
    "errorbar.capsize": 2.0,
    "grid.color": "#d8d8d4",
    "grid.linewidth": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "legend.frameon": False,
    "legend.fontsize": 10,
    "lines.linewidth": 1.4,
    "lines.markersize": 5,
    "hatch.linewidth": 0.5,
    "svg.fonttype": "none",
    "svg.hashsalt": "slipwave",
    "savefig.bbox": "tight",
    "savefig.pad_inches": 0.04,
    "path.simplify_threshold": 0.5,
}
_HATCHED = "#888888"
_MANY, _SMALL = 12, 8.5  # entries of a legend, from which on its letters are small
_CLOUD = 5000  # points, from which on they are drawn as a picture
_DECADES, _PLAIN = 300.0, (1e-4, 1e5)  # ratio and values of the ends of a scale with ticks at 1, 2 and 5
_WHOLE = (1e-4, 1e6)  # values of the larger end of a linear scale whose ticks need no power of ten
_LETTERS = 12.0  # of a label, in an inch of the panel
_FINE = 6  # points of a spline for each interval
_APART = 1e-6  # distance, as a share of the curve's size, of points that count as two


@contextmanager
def styled(letters: float = 1.0) -> Iterator[None]:
    """Context in which drawings have the common style, sizes of letters times `letters`: where they are made, and where they are
    saved. Other threads wait (`ONE_THREAD`)."""
    require("plot", "a figure")
    import matplotlib as mpl

    sizes = {name: size * letters for name, size in STYLE.items() if name.endswith("size") and letters != 1.0}
    with ONE_THREAD, mpl.rc_context(STYLE | sizes):
        yield


def draw(chart: Chart) -> Drawing:
    """Draw the chart; lines darker where they would not be clear on white paper."""
    with styled(chart.letters):
        from matplotlib.figure import Figure

        whole = with_limits(chart)
        figure = Figure(figsize=(chart.width, chart.height), layout="constrained")
        ratios: dict[str, Any] = {"width_ratios": chart.widths or None, "height_ratios": chart.heights or None}
        grid: Any = whole.grid
        places = figure.subplot_mosaic(grid, empty_sentinel=EMPTY, **ratios)
        for number, panel in enumerate(whole.panels):
            _draw_panel(places[number], panel, _LETTERS * chart.width / (len(grid[0]) * chart.letters))
        _share(places, whole)
        keys = _keys(chart.keys or [trace for panel in chart.panels for trace in panel.traces])
        if chart.title:
            figure.suptitle(chart.title, x=0.0, ha="left", size="medium", wrap=True)
        if chart.legend and keys:
            size = _SMALL * chart.letters if len(keys) > _MANY else None
            place: Any = chart.legend
            figure.legend(handles=keys, loc=place, ncols=chart.legend_columns, handlelength=2.8, fontsize=size)
        return figure


def _draw_panel(axes: Axes, panel: Panel, letters: float) -> None:
    """Draw a panel in whose width there is room for so many `letters`."""
    # in lines of so many letters at most, each formula and unit whole
    kept = re.sub(r"\$[^$]*\$| / .*", lambda match: match[0].replace(" ", "\N{NO-BREAK SPACE}"), panel.x.label)
    across = "\n".join(textwrap.wrap(kept, int(letters), break_long_words=False)).replace("\N{NO-BREAK SPACE}", " ")
    for which, label, axis in (("x", across, panel.x), ("y", panel.y.label, panel.y)):
        axes.set(**{f"{which}scale": axis.kind, f"{which}label": label, f"{which}lim": axis.ends})
        _draw_scale(axes, which, axis)
    axes.set_title(panel.name)
    if panel.grid:
        axes.grid(True)
        axes.set_axisbelow(True)
    for trace in panel.traces:
        _draw_trace(axes, panel, trace)
    keys = _keys(panel.traces) if panel.legend else []
    if keys:
        place: Any = panel.legend
        axes.legend(handles=keys, loc=place)


def _draw_scale(axes: Axes, which: str, axis: Scale) -> None:
    from matplotlib.ticker import LogFormatterSciNotation, MaxNLocator

    lines: Any = getattr(axes, f"{which}axis")
    if axis.ticks is not None:
        lines.set_ticks(list(axis.ticks), list(axis.ticks.values()))
        lines.set_minor_locator(MaxNLocator(1))
        lines.set_minor_formatter("")
    elif axis.kind == "log":
        _label_powers(lines, *axis.ends)
    elif which == "x" and not _WHOLE[0] <= np.abs(axis.ends).max() < _WHOLE[1]:  # one power of ten would meet the label
        lines.set_major_locator(MaxNLocator(5, steps=(1, 2, 5, 10)))
        lines.set_major_formatter(LogFormatterSciNotation(minor_thresholds=(np.inf, np.inf)))
    if axis.second:
        label, factor, is_power = axis.second
        functions: Any = (lambda values: factor * values, lambda values: values / factor)
        if is_power:
            there, back = functions
            functions = (lambda values: there(10.0**values), lambda values: np.log10(np.maximum(back(values), 1e-300)))
        second = partial(axes.secondary_xaxis, "top") if which == "x" else partial(axes.secondary_yaxis, "right")
        other: Any = second(functions=functions)
        other.set(**{f"{which}label": label})
        marks = getattr(other, f"{which}axis")
        if axis.kind == "log" and not is_power:
            _label_powers(marks, *(factor * end for end in axis.ends))
        else:
            marks.set_major_formatter("{x:g}")  # a power of ten at the end of the scale would meet the words of the other one


def _label_powers(lines: Any, low: float, high: float) -> None:
    """Ticks of a short logarithmic scale at 1, 2 and 5 times powers of ten, or in equal steps: powers of ten alone would be a
    tick or two, and words at all ticks too many."""
    from matplotlib.ticker import LogFormatterSciNotation, LogLocator, MaxNLocator

    if high >= _DECADES * low:
        return
    lines.set_minor_formatter("")
    lines.set_major_locator(MaxNLocator(5) if high < 10.0 * low else LogLocator(subs=(1.0, 2.0, 5.0)))
    is_plain = _PLAIN[0] < low and high < _PLAIN[1]
    lines.set_major_formatter("{x:g}" if is_plain else LogFormatterSciNotation(minor_thresholds=(np.inf, np.inf)))


def _draw_trace(axes: Axes, panel: Panel, trace: Trace) -> None:
    look, columns = trace.look, trace.columns
    x, y = (
        np.maximum(values + move, axis.floor)
        for values, move, axis in zip(panel.placed(trace), trace.shift, (panel.x, panel.y), strict=True)
    )
    if look.kind == "cells":
        _draw_cells(axes, panel, trace)
    elif look.kind == "area":
        axes.fill(x, y, color=look.ink, linewidth=0.0)
    elif look.kind == "text":
        for place in zip(x, y, strict=True):
            axes.text(*place, trace.name, color=look.ink, ha=look.marker or "left", va="center")
    elif trace.y_error is not None:  # on a logarithmic scale none below that reaches zero
        half = columns["y_error"]
        below = np.where(half < columns["y"], half, 0.0) if panel.y.kind == "log" else half
        axes.errorbar(x, y, [below, half], elinewidth=0.9, label=trace.name or None, **_style(look))
    else:
        x, y = _smooth(x, y) if look.kind == "smooth" else (x, y)
        axes.plot(x, y, label=trace.name or None, rasterized=look.dashes == "" and x.size > _CLOUD, **_style(look))


def _style(look: Look) -> dict[str, Any]:
    """The look of a line or of points, for matplotlib."""
    steps = {"drawstyle": look.kind} if look.kind == "steps-pre" else {}
    line = {"linestyle": look.dashes or "none", "linewidth": look.width, "marker": look.marker or "none", **steps}
    return {"color": look.ink, "markersize": look.size, "markerfacecolor": "white" if look.hollow else look.ink} | line


def _smooth(x: Array, y: Array) -> tuple[Array, Array]:
    """Curves through the points, a gap between them where there was one: cubic splines over the length along them, each axis in
    units of its range."""
    from scipy.interpolate import make_interp_spline

    parts, gaps = [], [-1, *np.flatnonzero(np.isnan(x)), x.size]
    for before, after in pairwise(gaps):
        part = np.column_stack([x, y])[before + 1 : after]
        sizes = np.ptp(part, axis=0) if len(part) > 1 else np.zeros(2)
        along = np.r_[0.0, np.cumsum(np.hypot(*(np.diff(part, axis=0) / np.where(sizes > 0.0, sizes, 1.0)).T))]
        apart = np.r_[True, np.diff(along) > _APART]
        if apart.sum() > 1:
            curve = make_interp_spline(along[apart], part[apart], k=min(3, int(apart.sum()) - 1))
            part = curve(np.interp(np.linspace(0.0, len(part) - 1.0, _FINE * (len(part) - 1) + 1), np.arange(len(part)), along))
        parts += [part, np.full((1, 2), np.nan)]
    whole = np.concatenate(parts[:-1])
    return whole[:, 0], whole[:, 1]


def _draw_cells(axes: Axes, panel: Panel, trace: Trace) -> None:
    from matplotlib.colors import BoundaryNorm, ListedColormap

    look, values = trace.look, np.ma.masked_invalid(np.asarray(trace.value, float))
    colors: Any = look.colors
    norm = None
    if not isinstance(look.colors, str):  # values below 0 are absent
        norm = BoundaryNorm(np.arange(-1.5, len(look.colors) + 0.5), len(look.colors) + 1)
        colors = ListedColormap(["#ffffff", *look.colors.values()])
    x, y = cell_edges(trace.x, panel.x.kind), cell_edges(trace.y, panel.y.kind)
    mesh = axes.pcolormesh(x, y, values, shading="flat", cmap=colors, norm=norm, rasterized=True)
    if isinstance(look.colors, str):
        axes.figure.colorbar(mesh, ax=axes, label=trace.name)
        return
    for number, word in enumerate(look.colors):
        if word in look.hatches and (values == number).any():
            _hatch(axes, x, y, np.ma.filled(values == number, False), look.hatches[word])


def _hatch(axes: Axes, x: Array, y: Array, there: Any, pattern: str) -> None:
    """A pattern over the cells that are `there`, between the edges x and y: one shape, in which it runs on from cell to cell."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    shapes = []
    for row, cells in enumerate(there):
        changes = np.flatnonzero(np.diff(np.r_[False, cells, False]))
        for begin, end in changes.reshape(-1, 2).tolist():
            corners = [(x[begin], y[row]), (x[end], y[row]), (x[end], y[row + 1]), (x[begin], y[row + 1])]
            shapes.append(Path([*corners, corners[0]], closed=True))
    axes.add_patch(
        PathPatch(Path.make_compound_path(*shapes), facecolor="none", edgecolor=_HATCHED, hatch=pattern, linewidth=0.0)
    )


def _keys(traces: Sequence[Trace]) -> list[Any]:
    """The entries of a legend: the first trace of each name, and each colour of pictures that has a word."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    keys: dict[str, Any] = {}
    for name, look, trace in ((curve.name, curve.look, curve) for curve in traces if curve.look.kind != "text"):
        if look.kind == "cells":
            there = set(np.asarray(trace.value, float).ravel().tolist())
            words = {} if isinstance(look.colors, str) else look.colors
            for color in (color for number, color in enumerate(words.items()) if number in there):
                hatch = look.hatches.get(color[0])
                keys.setdefault(
                    color[0], Patch(facecolor=color[1], edgecolor=_HATCHED, linewidth=0.4, label=color[0], hatch=hatch)
                )
        elif name and look.kind == "area":
            keys.setdefault(name, Patch(facecolor=look.ink, label=name))
        elif name:
            keys.setdefault(name, Line2D([], [], label=name, **_style(look)))
    return list(keys.values())


def _share(places: dict[int, Axes], chart: Chart) -> None:
    """Leave out what the panel below, or on the left, says too: the same label, and ticks at the same limits."""
    grid = np.array(chart.grid)
    above = zip(grid[:-1].ravel().tolist(), grid[1:].ravel().tolist(), strict=True)
    right = zip(grid[:, 1:].ravel().tolist(), grid[:, :-1].ravel().tolist(), strict=True)
    for which, pairs in (("x", above), ("y", right)):
        for place, other in pairs:
            if EMPTY in (place, other) or place == other:
                continue
            own, same = (getattr(chart.panels[number], which) for number in (place, other))
            if own.label == same.label:
                places[place].set(**{f"{which}label": ""})
                if own.limits == same.limits:
                    none: Any = {"labelbottom": False} if which == "x" else {"labelleft": False}
                    places[place].tick_params(which="both", **none)
