"""Charts of a sweep: regimes over two axes with boundaries, a column over two axes, or all columns over one."""

import math
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

import slipwave
from reduced.parameters import LABELS
from slipwave.errors import SceneError
from slipwave.input.overrides import label_of
from validation.chart import POINTS, Chart, Look, Panel, Scale, Second, Trace, color_number
from validation.data.datasets import DataArray, Dataset
from validation.models.parameter import Variation

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
_OTHER = "#999999"
_LINE = Look(dashes=(0, (4, 1.5)))
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


def chart_of_sweep(data: Dataset, shown: str | None = None, lines: Sequence[Line] = ()) -> Chart:
    """The chart of a gathered sweep with `lines` over its maps; `shown` is the column (default: regimes, period, stress drop).

    Raises SceneError for more than two axes, or a missing column."""
    data = _words_as_models(data)
    axes = [str(name) for name in data["status" if "status" in data else next(iter(data))].dims if name != "model"]
    if shown is not None and shown not in data:
        raise SceneError(f"--show = {shown!r}: must be one of {', '.join(map(str, data.data_vars))}")
    if len(axes) == 1:
        return _over_one(data, axes[0], shown)
    if len(axes) == 2:
        return _over_two(data, axes, shown, lines)
    raise SceneError(f"a figure needs one or two axes, this sweep has {len(axes)}; choose values of the others first")


def _words_as_models(data: Dataset) -> Dataset:
    """The data with each word of an axis of words as a further model."""
    names = [str(name) for name in data.dims if name != "model" and name in data.coords and data[name].dtype.kind in "OU"]
    if not names:
        return data
    together = (data if "model" in data.dims else data.expand_dims("model")).stack(which=("model", *names))
    words = [", ".join(map(str, one)) for one in together["which"].values]
    return together.drop_vars(["which", "model", *names]).rename(which="model").assign_coords(model=words)


def _models(data: Dataset) -> list[Dataset]:
    return [data.isel(model=number) for number in range(data.sizes["model"])] if "model" in data.dims else [data]


def _over_two(data: Dataset, names: Sequence[str], shown: str | None, lines: Sequence[Line]) -> Chart:
    columns = [shown] if shown else [name for name in ("verdict", "stable", "other_regime", *_PICTURES) if name in data]
    columns = columns or [str(next(iter(data.data_vars)))]
    panels = []
    for model in _models(data):
        across, up = (_scale(data, model[name]) for name in names)
        for column in columns:
            title = model["model"].item() if len(columns) == 1 else f"{model['model'].item()}: {column.replace('_', ' ')}"
            own = [line for line in lines if line.model in ("", model["model"].item())]
            edges = [Trace(line.name.partition(",")[0], line.across, line.up, _LINE) for line in own]
            panels.append(Panel(title, across, up, [_cells(model, names, column), *edges]))
    width = min(len(panels), _ABREAST) if len(columns) == 1 else len(columns)
    height = 3.2 * math.ceil(len(panels) / width)
    return Chart(panels, height, width, 3.7 * width, legend="outside lower center", legend_columns=6)


def _cells(data: Dataset, names: Sequence[str], column: str) -> Trace:
    """One column of a model as a picture."""
    across, up = (data[name].values for name in names)
    values = data[column].transpose(names[1], names[0])
    name, words = str(values.attrs.get("in_units_of", column)), {}
    if column == "other_regime":
        words = {"the same regime": "#dfe6ec", "another regime": "#c5523f"}
    elif "flag_meanings" in values.attrs:
        said = [word.replace("_", " ") for word in values.attrs["flag_meanings"].split()]
        words = {word: _COLOURS.get(word, _OTHER) for word in said}
    return Trace(name, across, up, Look(kind="cells", colors=words or "viridis"), value=values.values)


def _scale(data: Dataset, coordinate: DataArray) -> Scale:
    """The scale along a coordinate, with its second one where there are units."""
    kind = "log" if is_logarithmic(coordinate.values) else "linear"
    ends = float(coordinate.min()), float(coordinate.max())
    return Scale(_label(coordinate), kind, ends, second=other_side(data, coordinate))


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


def _over_one(data: Dataset, name: str, shown: str | None) -> Chart:
    usual = _BRUSH if _BRUSH[0] in data else _PICTURES
    columns = [shown] if shown else [name for name in usual if name in data] or [str(next(iter(data.data_vars)))]
    along = replace(_scale(data, data[name]), limits=(None, None), second=None)
    panels = list[Panel]()
    for column in columns:
        traces = []
        for number, model in enumerate(_models(data)):
            values = model[column].values.reshape(model.sizes[name], -1)
            across = np.repeat(model[name].values, values.shape[1])
            look = POINTS.but(color=color_number(number), marker=".", size=2.5)
            traces.append(Trace(str(model["model"].item()), across, values.ravel(), look))
        unit = data[column].attrs.get("units", "1")
        label = column.replace("_", " ") + (f" [{unit}]" if unit != "1" else "")
        panels.append(Panel("", along, Scale(label), traces, legend="best" if "model" in data.dims and not panels else ""))
    return Chart(panels, 2.9 * len(columns))


def other_side(data: Dataset, coordinate: DataArray) -> Second | None:
    """The other scale of this axis of a sweep; None for a scene without units, and for a key that is no velocity or thickness."""
    key, unit = str(coordinate.attrs.get("long_name", coordinate.name)), str(coordinate.attrs.get("units", "1"))
    if key not in (*_VELOCITIES, *_TRANSITS) or "scene_toml" not in data.attrs:
        return None
    in_si, first, is_power = unit == "1", float(coordinate[0]), "log10" in key
    base = slipwave.read_scene(tomllib.loads(data.attrs["scene_toml"]))
    try:
        scene = Variation(base).scene({key: first if in_si else f"{first!r} {unit}"}) if base.units else base
    except SceneError:
        return None
    if scene.units is None:
        return None
    (plain, value), (label, size) = ("r", scene.transit), ("transit [s]", scene.units.size("transit", scene.transit))
    if key in _VELOCITIES:
        (plain, value), (label, size) = ("V/V*", scene.velocity), ("V [m/s]", scene.velocity * scene.units.reference_velocity)
    here = 10.0**first if is_power else first
    return Second(label, size / here, is_power) if in_si else Second(plain, value / here, is_power)
