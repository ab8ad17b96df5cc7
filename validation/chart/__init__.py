"""Charts are data: panels of named traces, with what was computed, units, errors, looks and limits.

`validation.chart.draw` draws one with matplotlib, `table` writes its CSV file and reads it again (`read_chart`), `words` says it
in words, and `render` writes all files of one. Labels name the quantity and its unit; formulas in them stand between $.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from slipwave.family import PlotStyle
from slipwave.observe.pieces import Array
from validation.chart.colors import PAPER, legible

INK, GREY, PALE, BLUE, ORANGE = "#111111", "#777777", "#b5b5b0", "#0072b2", "#d55e00"
WIDTH = 7.4
"""Width of a chart over the whole page, inches: the text width of A4 paper."""

DASHED, DOTTED, EMPTY = (0, (5, 1.5)), (0, (1.5, 1.2)), -1
"""Dashes of lines; the number of an empty place in `Chart.layout`."""

_COLORS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f", "#bcbd22", "#17becf")
_MARGIN = 0.05  # of the range of what is drawn
_UNSAID = ("text", "area", "guide")


@dataclass(frozen=True)
class Look:
    """How a trace is drawn: colour, dashes as in matplotlib ("" for points alone), marker and its size, width of the line.

    `kind`: "line"; "steps-pre"; "smooth", a spline through the points; "guide", a line whose infinite ends lie on the edges of
    the panel; "area", within an outline; "text", the name of the trace at its points, aligned by `marker`; "cells", a picture:
    `colors` are those of the values 0, 1 ..., with their words, or a map of matplotlib, with the name of the trace at its bar;
    `hatches` are the patterns over the cells of some of the words."""

    color: str = INK
    dashes: Any = "-"
    marker: str = ""
    width: float = 1.3
    size: float = 5.0
    hollow: bool = False
    kind: str = "line"
    colors: str | Mapping[str, str] = "viridis"
    hatches: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, style: PlotStyle, **changes: Any) -> "Look":
        """The line of a model's plot style, without marker, with `changes`."""
        return cls(style.color, style.dashes, width=style.width).but(**changes)

    @property
    def ink(self) -> str:
        """Its colour as drawn: darker, except of an area, where it would not be clear on white paper; a line of the paper's own
        colour parts another one from what is below."""
        return self.color if self.kind == "area" or self.color == PAPER else legible(self.color)

    def but(self, **changes: Any) -> "Look":
        """This look with `changes`."""
        return replace(self, **changes)


GUIDE = Look(PALE, width=0.8, kind="guide")
POINTS = Look(dashes="", marker="o")


@dataclass(frozen=True, eq=False)
class Trace:
    """What one entry of a legend names: numbers `x` and `y` as they were computed (NaN: a gap), half widths of error bars, or a
    picture's `value`s, a row for each y. It is drawn moved by `shift`, so that bars, or curves, do not lie on each other."""

    name: str
    x: ArrayLike
    y: ArrayLike
    look: Look = field(default_factory=Look)
    y_error: ArrayLike | None = None
    value: ArrayLike | None = None
    shift: tuple[float, float] = (0.0, 0.0)

    @property
    def columns(self) -> dict[str, Array]:
        """Its numbers by their columns in the file, point by point or cell by cell."""
        x, y = np.atleast_1d(np.asarray(self.x, float)), np.atleast_1d(np.asarray(self.y, float))
        if self.value is not None:
            x, y = np.meshgrid(x, y)
            return {"x": x.ravel(), "y": y.ravel(), "value": np.asarray(self.value, float).ravel()}
        bars = {} if self.y_error is None else {"y_error": np.asarray(self.y_error, float)}
        return {
            name: np.broadcast_to(values, np.broadcast_shapes(x.shape, y.shape))
            for name, values in (("x", x), ("y", y), *bars.items())
        }

    @property
    def is_said(self) -> bool:
        """Whether words describe it."""
        return self.look.kind not in _UNSAID


class SecondScale(NamedTuple):
    """Another scale of an axis: `factor` times its value or, if `is_power`, its power of ten."""

    label: str
    factor: float
    is_power: bool = False


@dataclass(frozen=True)
class Scale:
    """Along one side of a panel: quantity and unit, "linear", "log" or "symlog" (linear about zero), limits (None: from what is
    drawn), ticks with their words, second scale. Values below `floor` are drawn there."""

    label: str = ""
    kind: str = "linear"
    limits: tuple[float | None, float | None] = (None, None)
    ticks: Mapping[float, str] | None = None
    second: SecondScale | None = None
    floor: float = -np.inf

    @property
    def ends(self) -> tuple[float, float]:
        """The limits once they are known (`with_limits`)."""
        low, high = self.limits
        assert low is not None
        assert high is not None
        return low, high


@dataclass(frozen=True)
class Panel:
    """Traces over the same scales, under a title; `legend`: where its own is, if it has one; `grid`: whether there is one."""

    name: str
    x: Scale
    y: Scale
    traces: Sequence[Trace]
    legend: str = ""
    grid: bool = False

    def placed(self, trace: Trace) -> tuple[Array, Array]:
        """Points of one of its traces: infinite ends of guides on its edges."""
        columns, axes = trace.columns, (self.x, self.y)
        x, y = (np.where(np.isinf(v), np.clip(v, *a.ends), v) for v, a in zip((columns["x"], columns["y"]), axes, strict=True))
        return (x, y) if trace.look.kind in ("guide", "area") else (columns["x"], columns["y"])


@dataclass(frozen=True)
class Chart:
    """Panels row by row in `columns`, or as the rows of `layout` place their numbers; sizes in inches, `widths` and `heights`
    of columns and rows relative to each other. Panels of one label `share` their limits along x in a "column" and along y in a
    "row"; or "all" do, or none (""). `legend`: its place, for `keys` or all traces. `letters`: their size over
    the usual one; `is_exact`: whether a file has this size to the last point, not without white margins."""

    panels: Sequence[Panel]
    height: float = 4.0
    columns: int = 1
    width: float = WIDTH
    layout: Sequence[Sequence[int]] = ()
    widths: tuple[float, ...] = ()
    heights: tuple[float, ...] = ()
    share: tuple[str, str] = ("column", "row")
    legend: str = ""
    legend_columns: int = 1
    keys: Sequence[Trace] = ()
    title: str = ""
    letters: float = 1.0
    is_exact: bool = False

    @property
    def grid(self) -> list[list[int]]:
        """Numbers of the panels, row by row."""
        count = len(self.panels)
        rows = range(0, count, self.columns)
        return [[*row] for row in self.layout] or [[k if k < count else EMPTY for k in range(n, n + self.columns)] for n in rows]


def color_number(number: int) -> str:
    """A colour for the n-th of several alike."""
    return _COLORS[number % len(_COLORS)]


def outline(x: ArrayLike, low: ArrayLike, high: ArrayLike) -> tuple[Array, Array]:
    """Outline of the area between two curves."""
    x, low, high = (np.asarray(values, float) for values in (x, low, high))
    return np.concatenate((x, x[::-1])), np.concatenate((low, high[::-1]))


def cell_edges(centres: ArrayLike, kind: str = "linear") -> Array:
    """Edges of the cells of a picture around their `centres`, half way between them on a scale of this `kind`; of one centre
    alone 5 % away, of 0 alone one half; above half the least one if all are above 0."""
    values = np.asarray(centres, float)
    values = np.log(values) if kind == "log" else values
    if values.size == 1:
        away = 0.05 if kind == "log" else 0.05 * abs(float(values[0])) or 0.5
        edges = np.array([values[0] - away, values[0] + away])
    else:
        middle = 0.5 * (values[:-1] + values[1:])
        edges = np.concatenate([[2.0 * values[0] - middle[0]], middle, [2.0 * values[-1] - middle[-1]]])
    if kind == "log":
        return np.asarray(np.exp(edges))
    least = float(values.min())
    return np.maximum(edges, 0.5 * least) if least > 0.0 else edges


def with_gaps(parts: Iterable[tuple[ArrayLike, ArrayLike]]) -> tuple[Array, Array]:
    """Parts of a curve as one, with gaps between them."""
    gaps = [part for x, y in parts for part in (([np.nan], [np.nan]), (x, y))][1:] or [([], [])]
    x, y = (np.concatenate([np.asarray(part[k], float) for part in gaps]) for k in (0, 1))
    return x, y


def with_limits(chart: Chart) -> Chart:
    """The chart whose panels have all limits: those that they have, or else the range of what is drawn."""
    grid, ranges = np.array(chart.grid), dict[tuple[Any, ...], list[tuple[int, Scale, tuple[float, float]]]]()
    for which, share in zip("xy", chart.share, strict=True):
        for number, panel in enumerate(chart.panels):
            scale: Scale = getattr(panel, which)
            row, column = np.argwhere(grid == number)[0].tolist()
            group = {"column": column, "row": row, "all": 0}.get(share, -1 - number), scale.label, scale.kind, which
            ranges.setdefault(group, []).append((number, scale, _range(panel, which)))
    limits = {}
    for (*_, which), members in ranges.items():
        low, high = min(low for *_, (low, _) in members), max(high for *_, (_, high) in members)
        for number, scale, _ in members:
            least, most = scale.limits
            limits[number, which] = replace(scale, limits=(low if least is None else least, high if most is None else most))
    every = (replace(panel, x=limits[n, "x"], y=limits[n, "y"]) for n, panel in enumerate(chart.panels))
    return replace(chart, panels=tuple(every))


def _range(panel: Panel, which: str) -> tuple[float, float]:
    """The range of what a panel shows along "x" or "y", with a margin unless it is a picture's."""
    scale: Scale = getattr(panel, which)
    ends, margin = [np.array([])], 0.0
    for trace in (trace for trace in panel.traces if trace.look.kind != "text"):
        columns = trace.columns
        values = columns[which] + trace.shift["xy".index(which)]
        bars = columns.get(f"{which}_error", 0.0)
        ends += [np.maximum(values, scale.floor), values - bars, values + bars]
        margin = margin if trace.look.kind == "cells" else _MARGIN
    every = np.concatenate(ends)
    is_log = scale.kind == "log"
    every = np.log10(every[every > 0.0]) if is_log else every
    every = every[np.isfinite(every)]
    low, high = (float(every.min()), float(every.max())) if every.size else (0.0, 1.0)
    more = margin * (high - low) if high > low else _MARGIN * max(abs(low), 1.0)
    return (10.0 ** (low - more), 10.0 ** (high + more)) if is_log else (low - more, high + more)
