"""Figures of a sweep: regimes over two axes with boundaries, a column over two axes, or all columns over one."""

import math
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

import slipwave
from reduced.parameters import LABELS
from slipwave.errors import SceneError
from slipwave.input.overrides import label_of
from validation.chart import Second
from validation.chart.draw import draw_second
from validation.results.result import DataArray, Dataset
from validation.study.drawing import Axes, Drawing, canvas, styled
from validation.sweep.axes import changed

_COLOURS = {
    "steady": "#e8eef4",
    "decaying": "#cfe0ee",
    "settling": "#dddddd",
    "growing": "#b9b4d8",
    "periodic": "#f3c77a",
    "torus": "#5aa28c",
    "irregular": "#c5523f",
    "driven": "#bbbbbb",
    "protocol": "#bbbbbb",
    "too short": "#f6f6f6",
    "no": "#f3c77a",
    "yes": "#e8eef4",
}
_OTHER, _ABSENT = "#999999", "#ffffff"
_LINE: Any = {"color": "#111111", "linewidth": 1.3, "dashes": (4, 1.5)}
_ABREAST = 3
_PICTURES = ("period", "stress_drop")
_BRUSH = ("cycle_period", "cycle_stress_drop")


_VELOCITIES, _TRANSITS = ("V", "drive.velocity"), ("r", "log10_r", "slab.r", "slab.log10_r", "slab.thickness")
"""Keys whose values (for a logarithm, its power of ten) are proportional to V and to the transit."""


class Line(NamedTuple):
    """A boundary over a map: values on both axes, and its model (empty: all)."""

    name: str
    across: Any
    up: Any
    model: str


def figure_of(data: Dataset, shown: str | None = None, lines: Sequence[Line] = ()) -> Drawing:
    """The figure of a gathered sweep with `lines` over its maps; `shown` is the column (default: regimes, period, stress drop).

    Raises SceneError for more than two axes, or a missing column."""
    axes = [str(name) for name in data["status" if "status" in data else next(iter(data))].dims if name != "model"]
    if shown is not None and shown not in data:
        raise SceneError(f"--show = {shown!r}: must be one of {', '.join(map(str, data.data_vars))}")
    with styled():
        if len(axes) == 1:
            return _over_one(data, axes[0], shown)
        if len(axes) == 2:
            return _over_two(data, axes, shown, lines)
    raise SceneError(f"a figure needs one or two axes, this sweep has {len(axes)}; choose values of the others first")


def _models(data: Dataset) -> list[Dataset]:
    return [data.isel(model=number) for number in range(data.sizes["model"])] if "model" in data.dims else [data]


def _over_two(data: Dataset, names: Sequence[str], shown: str | None, lines: Sequence[Line]) -> Drawing:
    columns = [shown] if shown else [name for name in ("verdict", "stable", "other_regime", *_PICTURES) if name in data]
    panels = [(model, column) for model in _models(data) for column in columns]
    width = min(len(panels), _ABREAST) if len(columns) == 1 else len(columns)
    rows = math.ceil(len(panels) / width)
    figure = canvas(3.7 * width, 3.2 * rows)
    grid = figure.subplots(rows, width, squeeze=False).ravel()
    marks: dict[str, Any] = {}
    for axes, (model, column) in zip(grid, panels, strict=False):
        marks |= _image(axes, model, names, column, len(columns) == 1)
        for line in lines:
            if line.model in ("", model["model"].item()):
                marks[line.name.partition(",")[0]] = axes.plot(line.across, line.up, **_LINE)[0]
        across, up = ((float(model[name].min()), float(model[name].max())) for name in names)
        axes.set(xlim=across, ylim=up)
    for axes in grid[len(panels) :]:
        axes.remove()
    if marks:
        figure.legend(marks.values(), marks, loc="outside lower center", ncols=6, fontsize=9)
    return figure


def _image(axes: Axes, data: Dataset, names: Sequence[str], column: str, alone: bool) -> dict[str, Any]:
    """Draw one column of a model (`alone`: the only one); returns the colours by words."""
    across, up = (data[name] for name in names)
    values = data[column].transpose(names[1], names[0])
    _scales(axes, data, across, up)
    axes.set_title(data["model"].item() if alone else f"{data['model'].item()}: {column.replace('_', ' ')}")
    if column == "other_regime":
        return _words(axes, across, up, values.fillna(-1), {"the same regime": "#dfe6ec", "another regime": "#c5523f"})
    if "flag_meanings" in values.attrs:
        words = [word.replace("_", " ") for word in values.attrs["flag_meanings"].split()]
        return _words(axes, across, up, values, {word: _COLOURS.get(word, _OTHER) for word in words})
    picture = axes.pcolormesh(across, up, np.ma.masked_invalid(values), shading="nearest", cmap="viridis", rasterized=True)
    axes.figure.colorbar(picture, ax=axes, label=values.attrs.get("in_units_of", ""))
    return {}


def _words(axes: Axes, across: DataArray, up: DataArray, values: DataArray, colours: Mapping[str, str]) -> dict[str, Any]:
    from matplotlib.colors import BoundaryNorm, ListedColormap
    from matplotlib.patches import Patch

    norm = BoundaryNorm(np.arange(-1.5, len(colours) + 0.5), len(colours) + 1)
    palette = ListedColormap([_ABSENT, *colours.values()])
    axes.pcolormesh(across, up, values, shading="nearest", cmap=palette, norm=norm, rasterized=True)
    there = [word for number, word in enumerate(colours) if bool((values == number).any())]
    return {word: Patch(facecolor=colours[word], edgecolor="#888888", linewidth=0.4) for word in there}


def _scales(axes: Axes, data: Dataset, across: DataArray, up: DataArray) -> None:
    from matplotlib.ticker import MaxNLocator

    for coordinate, scale, label in ((across, axes.set_xscale, axes.set_xlabel), (up, axes.set_yscale, axes.set_ylabel)):
        if is_logarithmic(coordinate.values):
            scale("log")
            axis = axes.xaxis if coordinate is across else axes.yaxis
            axis.set_minor_formatter("")
            if coordinate.max() < 10.0 * coordinate.min():  # powers of ten alone would be one tick
                axis.set_major_locator(MaxNLocator(5))
            axis.set_major_formatter("{x:g}")
        other = other_side(data, coordinate)
        if other:
            draw_second(axes, "x" if coordinate is across else "y", other)
        label(_label(coordinate))


def _label(coordinate: DataArray) -> str:
    """Label of an axis of a sweep: title, symbol and unit."""
    key, unit = str(coordinate.attrs.get("long_name", coordinate.name)), str(coordinate.attrs.get("units", "1"))
    name, power = key.removeprefix("log10_"), r"$\log_{10}$"
    if name in LABELS:
        return LABELS[name] if name == key else f"{power} of the {LABELS[name]}"
    return label_of(key, "" if unit == "1" else unit).replace("log₁₀", power)  # the report's font has no small figures


def is_logarithmic(values: Any) -> bool:
    """Whether values are spaced logarithmically."""
    if len(values) < 3 or np.min(values) <= 0.0:
        return False
    powers = np.diff(np.log(values))
    return bool(np.ptp(powers) < 1e-6 * abs(powers.mean()))


def _over_one(data: Dataset, name: str, shown: str | None) -> Drawing:
    usual = _BRUSH if _BRUSH[0] in data else _PICTURES
    columns = [shown] if shown else [name for name in usual if name in data] or [str(next(iter(data.data_vars)))]
    figure = canvas(7.4, 2.9 * len(columns))
    grid = figure.subplots(len(columns), 1, squeeze=False, sharex=True)[:, 0]
    for axes, column in zip(grid, columns, strict=True):
        for number, model in enumerate(_models(data)):
            values = model[column].values.reshape(model.sizes[name], -1)
            across = np.repeat(model[name].values, values.shape[1])
            axes.plot(across, values.ravel(), ".", color=f"C{number}", markersize=2.5, label=model["model"].item())
        unit = data[column].attrs.get("units", "1")
        axes.set_ylabel(column.replace("_", " ") + (f" [{unit}]" if unit != "1" else ""))
    if is_logarithmic(data[name].values):
        grid[-1].set_xscale("log")
    if "model" in data.dims:
        grid[0].legend(loc="best", fontsize=9)
    grid[-1].set_xlabel(_label(data[name]))
    return figure


def other_side(data: Dataset, coordinate: DataArray) -> Second | None:
    """The other scale of this axis of a sweep; None for a scene without units, and for a key that is no velocity or thickness."""
    key, unit = str(coordinate.attrs.get("long_name", coordinate.name)), str(coordinate.attrs.get("units", "1"))
    if key not in (*_VELOCITIES, *_TRANSITS) or "scene_toml" not in data.attrs:
        return None
    in_si, first, is_power = unit == "1", float(coordinate[0]), "log10" in key
    base = slipwave.read_scene(tomllib.loads(data.attrs["scene_toml"]))
    try:
        scene = changed(base, {key: first if in_si else f"{first!r} {unit}"}) if base.units else base
    except SceneError:
        return None
    if scene.units is None:
        return None
    (plain, value), (label, size) = ("r", scene.transit), ("transit [s]", scene.units.size("transit", scene.transit))
    if key in _VELOCITIES:
        (plain, value), (label, size) = ("V/V*", scene.velocity), ("V [m/s]", scene.velocity * scene.units.reference_velocity)
    here = 10.0**first if is_power else first
    return Second(label, size / here, is_power) if in_si else Second(plain, value / here, is_power)
