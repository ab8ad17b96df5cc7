"""What a figure shows, as lines of text: one for each of its axes, and one for every line, patch, collection and text in them."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import Collection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.spines import Spine
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator


def number(value: float) -> str:
    """Seven digits."""
    return f"{value:.7g}"


def drawn(figure: Figure) -> Iterator[str]:
    """The figure's size and legends, then its axes with their artists."""
    yield f"size {_pair(figure.get_size_inches())}"
    for text in figure.texts:
        yield _text(text)
    for legend in figure.legends:
        yield _legend(legend)
    for axes in figure.axes:
        yield from _axes(axes)


def _axes(axes: Axes) -> Iterator[str]:
    title = " ".join(text for place in ("left", "center", "right") if (text := axes.get_title(place).strip()))
    yield f'axes "{title}", grid {_grid(axes)}, below {axes.get_axisbelow()}'
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        yield f'  {name} "{axis.label.get_text()}", {axis.get_scale()}, from {_pair(axis.get_view_interval())}{_ticks(axis)}'
    for artist in axes.get_children():
        yield from (f"  {line}" for line in _artist(artist, axes))


def _grid(axes: Axes) -> str:
    return " ".join(str(any(line.get_visible() for line in axis.get_gridlines())) for axis in (axes.xaxis, axes.yaxis))


def _ticks(axis: Axis) -> str:
    """Those that were set by hand, whether there are small ones, and whether they have numbers."""
    places, words = axis.get_major_locator(), axis.get_major_formatter()
    told = f", ticks {_list(places.locs)}" if isinstance(places, FixedLocator) else ""
    told += f" called {_list(words.seq)}" if isinstance(words, FixedFormatter) else ""
    told += ", no small ticks" if isinstance(axis.get_minor_locator(), NullLocator) else ", small ticks"
    side = "labelbottom" if axis.axis_name == "x" else "labelleft"
    return told + ("" if axis.get_tick_params()[side] else ", no numbers")


def _artist(artist: Artist, axes: Axes) -> Iterator[str]:
    if isinstance(artist, Line2D):
        yield f"line {_label(artist)} {_strokes(artist)}, {_points(artist.get_xydata())}"
    elif isinstance(artist, Collection):
        yield f"{type(artist).__name__} {_label(artist)} {_collection(artist)}"
    elif isinstance(artist, Patch) and artist is not axes.patch and not isinstance(artist, Spine):
        path = artist.get_transform().transform_path(artist.get_path()).transformed(axes.transData.inverted())
        colors = " ".join(to_hex(color, keep_alpha=True) for color in (artist.get_facecolor(), artist.get_edgecolor()))
        yield f"{type(artist).__name__} {_label(artist)} {colors}, {_points(path.vertices)}"
    elif artist in axes.texts:
        yield _text(artist)
    elif isinstance(artist, Legend):
        yield _legend(artist)


def _label(artist: Artist) -> str:
    label = str(artist.get_label())
    return '""' if label.startswith("_") else f'"{label}"'


def _strokes(line: Line2D) -> str:
    """Colour, width and dashes; marker with size and face, if there is one."""
    told = f"{to_hex(line.get_color(), keep_alpha=True)} {number(line.get_linewidth())} {line.get_linestyle()} {_dashes(line)}"
    marker = line.get_marker()
    if marker in ("None", "", " ", None):
        return told
    face = line.get_markerfacecolor()
    return f"{told} marker {marker} {number(line.get_markersize())} {face if face == 'none' else to_hex(face)}"


def _dashes(line: Line2D) -> str:
    _, dashes = line._unscaled_dash_pattern
    return "solid" if dashes is None else _list(dashes)


def _collection(some: Collection) -> str:
    """Its colours, or the map with what is coloured by it; where it is."""
    if some.get_array() is None:
        look = " ".join(to_hex(color, keep_alpha=True) for color in (*some.get_facecolor()[:3], *some.get_edgecolor()[:3]))
    else:
        values = np.ravel(some.get_array())
        look = f"map {some.get_cmap().name} from {_pair(some.get_clim())}: {_spread(values)}, as {_spread(some.norm(values))}"
    if isinstance(some, QuadMesh):
        return f"{look}, {_points(some.get_coordinates().reshape(-1, 2))}"
    outlines = [path.vertices for path in some.get_paths()]
    shape = _points(np.concatenate([*outlines, np.empty((0, 2))]))
    return f"{look}, {len(outlines)} outlines, {shape}, at {_points(some.get_offsets())}"


def _text(text: Text) -> str:
    look = (
        f"{to_hex(text.get_color())} {number(text.get_fontsize())} {text.get_ha()} {text.get_va()} {number(text.get_rotation())}"
    )
    at = _pair(text.xy) + " and " + _pair(text.xyann) if isinstance(text, Annotation) else _pair(text.get_position())
    return f'text "{text.get_text()}" {look} at {at}'


def _legend(legend: Legend) -> str:
    names = ", ".join(text.get_text() for text in legend.get_texts())
    strokes = ", ".join(_strokes(line) for line in legend.get_lines())
    return f'legend "{legend.get_title().get_text()}", {legend._ncols} columns, place {legend._loc}: {names}; {strokes}'


def _points(points: Any) -> str:
    points = np.asarray(points, dtype=float)
    return f"{len(points)} points, x {_spread(points[:, 0])}, y {_spread(points[:, 1])}"


def _spread(values: Any) -> str:
    """First and last, least and greatest, and mean size, of those that are finite; how many are not."""
    values = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)
    known = values[np.isfinite(values)]
    if not known.size:
        return "nothing"
    ends = [number(value) for value in (known[0], known[-1], known.min(), known.max(), np.abs(known).mean())]
    return " ".join(ends) + (f" ({values.size - known.size} unknown)" if known.size < values.size else "")


def _pair(values: Any) -> str:
    return f"({_list(values)})"


def _list(values: Any) -> str:
    return ", ".join(value if isinstance(value, str) else number(float(value)) for value in values)
