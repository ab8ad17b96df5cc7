"""Charts of a sweep: regimes over two axes with boundaries, a column over two axes, or regimes and all columns over one; and the
boundaries over a map: where theory has steady sliding lose its stability, and special curves of orbits."""

import itertools
import json
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import slipwave
from reduced.stability.boundary import boundary
from slipwave.errors import NumericsError, SceneError
from slipwave.scene import Scene
from validation.chart import POINTS, Chart, Look, Panel, Scale, SecondScale, Trace, cell_edges, color_number
from validation.chart.colors import PAPER, REGIMES
from validation.data.datasets import DataArray, Dataset, flag_numbers, flag_words, load_dataset
from validation.models.by_name import one_port_of
from validation.models.own import require_files
from validation.models.parameter import SHORT, Parameter, Variation, measured_value, scenes_with

_COLOURS = REGIMES | {"driven": "#1a1a1a", "protocol": "#1a1a1a", "too short": PAPER, "no": "#e69f00", "yes": "#f4f8fc"}
_OTHER = {"the same regime": "#dfe6ec", "another regime": "#66152f"}
_ABSENT = ("no figures", "not computed")
HATCHES = {"too short": "////", "no figures": "xxx", "not computed": "..."}
"""Patterns of cells without a regime, the last two for points that were refused or failed and for those still to be computed."""

_LINE, _HALO = Look(dashes=(0, (4, 1.5))), Look(PAPER, width=3.2)
_CURVES = ("-", (0, (1, 1.2)), (0, (5, 1.2, 1, 1.2)))
_ABREAST = 3
_PICTURES = ("exponent", "period", "stress_drop")
_BRUSH = ("cycle_period", "cycle_stress_drop")
_STRIP = 0.16
"""Height of a strip of regimes over one axis, for each model, over that of a panel."""

_CONTINUED = ("point_first", "point_second")
"""The parameters of a curve in a file from which it can be continued; their `long_name` is that of the key."""

_VELOCITIES, _TRANSITS = ("V", "drive.velocity"), ("r", "log10_r", "slab.r", "slab.log10_r", "slab.thickness")
"""Keys whose values (for a logarithm, its power of ten) are proportional to V and to the transit."""

SIZES = {"single": 8.5, "double": 17.0}
"""Widths of columns of a paper, cm."""

_PRINT, _MOST_READ, _MOST_TICKS = 8.0 / 11.0, 20_000, 10


class Line(NamedTuple):
    """A boundary over a map: values on both axes, and its model (empty: all)."""

    name: str
    across: Any
    up: Any
    model: str


def _axes_of(data: Dataset) -> list[str]:
    """The names of the axes of a sweep, without the models."""
    return [str(name) for name in data["status" if "status" in data else next(iter(data))].dims if name != "model"]


def chart_of_sweep(data: Dataset, shown: str | None = None, lines: Sequence[Line] = ()) -> Chart:
    """The chart of a gathered sweep with `lines` over its maps; `shown` is the column (default: regimes, period, stress drop).

    Raises SceneError for more than two axes, or a missing column."""
    data = _words_as_models(data)
    axes = _axes_of(data)
    if shown is not None and shown not in data:
        raise SceneError(f"--show = {shown!r}: must be one of {', '.join(map(str, data.data_vars))}")
    if len(axes) == 1:
        return _over_one(data, axes[0], shown)
    if len(axes) == 2:
        return _over_two(data, axes, shown, lines)
    raise SceneError(f"a figure needs one or two axes, this sweep has {len(axes)}; choose values of the others first")


def _words_as_models(data: Dataset) -> Dataset:
    """The data with each word of an axis of words beside an axis of numbers as a further model."""
    names = [name for name in _axes_of(data) if name in data.coords and data[name].dtype.kind in "OU"]
    if not names or len(names) == len(_axes_of(data)):
        return data
    together = (data if "model" in data.dims else data.expand_dims("model")).stack(which=("model", *names))
    words = [", ".join(map(str, which)) for which in together["which"].values]
    return together.drop_vars(["which", "model", *names]).rename(which="model").assign_coords(model=words)


def in_print(chart: Chart, size: str) -> Chart:
    """The chart in one of `SIZES`, with letters of 8 points, in one column or two."""
    width, columns = SIZES[size] / 2.54, min(chart.columns, 1 if size == "single" else 2)
    rows, before = (math.ceil(len(chart.panels) / number) for number in (columns, chart.columns))
    narrower = (width / columns) / (chart.width / chart.columns)
    height = chart.height * rows / before * max(narrower, _PRINT)  # as high as its letters at least
    heights = chart.heights if columns == chart.columns else ()
    legend = max(2, min(6, round(2.6 * width / 2.54)))
    changes: dict[str, Any] = {"columns": columns, "heights": heights, "legend_columns": legend}
    return replace(chart, width=width, height=height, letters=_PRINT, is_exact=True, **changes)


def _models(data: Dataset) -> list[Dataset]:
    return [data.isel(model=number) for number in range(data.sizes["model"])] if "model" in data.dims else [data]


def _over_two(data: Dataset, names: Sequence[str], shown: str | None, lines: Sequence[Line]) -> Chart:
    usual = [name for name in ("verdict", "stable", "other_regime", *_PICTURES) if name in data]
    columns = [shown] if shown else [name for name in usual if name not in _PICTURES or np.isfinite(data[name].values).any()]
    columns = columns or [_first_figure(data)]
    panels = []
    for model in _models(data):
        across, up = (_scale(data, model[name]) for name in names)
        for column in columns:
            title = str(model["model"].item())
            if len(columns) > 1 or column == "stable":
                title += f": {'regime' if column == 'verdict' else column.replace('_', ' ')}"
            panels.append(Panel(title, across, up, [*_cells(model, names, column), *_edges(lines, str(model["model"].item()))]))
    width = min(len(panels), _ABREAST) if len(columns) == 1 else len(columns)
    height = 3.6 * math.ceil(len(panels) / width)
    return Chart(panels, height, width, 4.0 * width, legend="outside lower center", legend_columns=6)


def _edges(lines: Sequence[Line], model: str) -> list[Trace]:
    """The lines over a panel of the `model`: onsets are dashed; each curve of orbits has a line of its own and the name of its
    model, which may be another one."""
    own = [line for line in lines if line.model in ("", model)]
    curves = [*dict.fromkeys(line.name for line in own if not line.model)]
    edges = [Trace("", line.across, line.up, _HALO) for line in own]
    for line in own:
        look = _LINE if line.model else Look(dashes=_CURVES[curves.index(line.name) % len(_CURVES)])
        edges.append(Trace(line.name.partition(",")[0] if line.model else line.name, line.across, line.up, look))
    return edges


def _cells(data: Dataset, names: Sequence[str], column: str) -> list[Trace]:
    """One column of a model as a picture, over hatched cells where it has no figures."""
    across, up = (_positions(data[name]) for name in names)
    if column == "other_regime":
        look = Look(kind="cells", colors=_OTHER)
        return [Trace(column, across, up, look, value=data[column].transpose(names[1], names[0]).values)]
    words, numbers = _regimes(data, column if "flag_meanings" in data[column].attrs else "")
    there, turned = Look(kind="cells", colors=words, hatches=HATCHES), numbers.transpose(names[1], names[0]).values
    if "flag_meanings" in data[column].attrs:
        return [Trace("regime", across, up, there, value=turned)]
    values, label = figures_on_clock(data, column)
    hatched = np.isin(turned, [number for number, word in enumerate(words) if word in HATCHES])
    under = [Trace("", across, up, there, value=np.where(hatched, turned, -1))] if hatched.any() else []
    if not np.isfinite(values.values).any():
        x, y = (float(side[len(side) // 2]) for side in (across, up))
        return [*under, Trace("no cycles at any point", [x], [y], Look(kind="text", marker="center"))]
    return [*under, Trace(label, across, up, Look(kind="cells"), value=values.transpose(names[1], names[0]).values)]


def _regimes(data: Dataset, column: str = "") -> tuple[Mapping[str, str], DataArray]:
    """Colours by word, and the number of each point's word; without `column` those of verdicts, if there are any."""
    column = column or _flags_in(data)
    if not column:
        return dict.fromkeys(_ABSENT, PAPER), _absent(data, -np.ones(data["status"].shape), 0)
    flags = data[column]
    said = flag_words(flags)
    words = {word: _COLOURS.get(word, "#999999") for word in said} | dict.fromkeys(_ABSENT, PAPER)
    return words, _absent(data, flag_numbers(flags), len(said))


def _first_figure(data: Dataset) -> str:
    """The first column that is neither words nor how the points ended."""
    names = [str(name) for name in data.data_vars if name not in ("status", "reason", _flags_in(data))]
    return names[0] if names else "status"


def _flags_in(data: Dataset) -> str:
    return next((name for name in ("verdict", "stable") if name in data), "")


def _absent(data: Dataset, numbers: Any, first: int) -> DataArray:
    """The `numbers` of words, where there is none that of the reason: `first` for a point without figures, the next for one that
    is not computed."""
    status = data["status"]
    reasons = np.where(status.values > 0, first, np.where(status.values < 0, first + 1, -1))
    return status.copy(data=np.where(numbers >= 0, numbers, reasons))


def figures_on_clock(data: Dataset, column: str) -> tuple[DataArray, str]:
    """A column with its label: in SI for a scene in units, and periods in L/V*, exponents in V*/L, where the transit changes
    along an axis."""
    name = column.replace("_", " ")
    if "other_regime" in data:  # a map of differences
        return data[column], str(data[column].attrs["long_name"])
    for ending, unit in (("_s", "s"), ("_Pa", "Pa"), ("_m_per_s", "(m/s)"), ("_per_s", "(1/s)")):
        if f"{column}{ending}" in data:
            return data[f"{column}{ending}"], f"{name} / {unit}"
    unit = str(data[column].attrs.get("units", "1"))
    clock = str(data[column].attrs.get("in_units_of", ""))
    if clock in ("transit", "1/transit") and (sizes := _transits(data)):
        power, told = (1, "(L/V*)") if clock == "transit" else (-1, "(V*/L)")
        return reduce(lambda values, size: values * size**power, sizes, data[column]), f"{name} / {told}"
    told = {"transit": "transits", "1/transit": "(1/transit)"}.get(clock, clock) or ("" if unit == "1" else unit)
    return data[column], f"{name} / {told}" if told else name


def _transits(data: Dataset) -> list[DataArray]:
    """The transit (L/V*) at the points of a sweep, as factors along the axes that change it each on its own; none if it is the
    same everywhere."""
    names = [name for name in _axes_of(data) if name in data.coords and data[name].dtype.kind in "iuf"]
    if "scene_toml" not in data.attrs or not names:
        return []
    scenes = _scenes_over(data, names)
    transits = list[DataArray]()
    for axes in [names] if scenes.sets else [[name] for name in names]:  # what is set may depend on all of them
        if math.prod(data.sizes[name] for name in axes) > _MOST_READ:
            continue
        varied = [_parameter_of(data[name]) for name in axes]
        try:
            known = [
                scenes.at(varied, point).transit for point in itertools.product(*(data[name].values.tolist() for name in axes))
            ]
        except SceneError:
            continue
        if max(known) > min(known):
            over = data["status"].isel({name: 0 for name in data["status"].dims if name not in axes}, drop=True).transpose(*axes)
            transits.append(over.copy(data=np.reshape(known, over.shape) / (scenes.base.transit if transits else 1.0)))
    return transits


def _scenes_over(data: Dataset, axes: Iterable[str]) -> Variation:
    """The scenes of a gathered sweep over these axes."""
    base = _base_of(data)
    sets = json.loads(data.attrs.get("manifest", "{}")).get("set", {})
    return scenes_with(base, [_parameter_of(data[axis]).name for axis in axes], sets)


def _base_of(data: Dataset) -> Scene:
    """The scene of a gathered sweep."""
    return slipwave.read_scene(tomllib.loads(data.attrs["scene_toml"]))


def _parameter_of(coordinate: DataArray) -> Parameter:
    """What is varied along an axis of a sweep."""
    unit = str(coordinate.attrs.get("units", "1"))
    return Parameter(str(coordinate.attrs.get("long_name", coordinate.name)), "" if unit == "1" else unit)


def _positions(coordinate: DataArray) -> Any:
    """Where the values of an axis are drawn: words at 0, 1, 2 ..."""
    values = coordinate.values
    return values if values.dtype.kind in "iuf" else np.arange(float(values.size))


def _scale(data: Dataset, coordinate: DataArray) -> Scale:
    """The scale along a coordinate, with its second one where there are units; one of words has them at its ticks."""
    places = _positions(coordinate)
    kind = "log" if _is_logarithmic(places) else "linear"
    edges = cell_edges(places, kind)
    ends = float(edges.min()), float(edges.max())
    label = _parameter_of(coordinate).label_in(_base_of(data) if "scene_toml" in data.attrs else None)
    if coordinate.values.dtype.kind not in "iuf":
        return Scale(label, kind, ends, ticks={float(at): str(word) for at, word in enumerate(coordinate.values)})
    if coordinate.name not in data.coords:  # numbers of scenes
        return Scale(label, kind, ends, ticks={float(at): str(at) for at in places[:: math.ceil(places.size / _MOST_TICKS)]})
    return Scale(label, kind, ends, second=_other_side(data, coordinate))


def _is_logarithmic(values: Any) -> bool:
    """Whether values are spaced logarithmically."""
    if len(values) < 3 or np.min(values) <= 0.0:
        return False
    powers = np.diff(np.log(values))
    return bool(np.ptp(powers) < 1e-6 * abs(powers.mean()))


def _over_one(data: Dataset, name: str, shown: str | None) -> Chart:
    """Columns over one axis, and below them a strip with the regimes of each model."""
    usual = _BRUSH if _BRUSH[0] in data else _PICTURES
    columns = [shown] if shown else [name for name in usual if name in data] or [_first_figure(data)]
    models, along, flags = _models(data), _scale(data, data[name]), _flags_in(data)
    panels = list[Panel]()
    for column in columns:
        if column == flags or (flags and not np.isfinite(data[column].values).any()):
            continue
        traces, label = [], column
        for number, model in enumerate(models):
            figures, label = figures_on_clock(model, column)
            values = figures.values.reshape(model.sizes[name], -1)
            across = np.repeat(_positions(model[name]), values.shape[1])
            look = POINTS.but(color=color_number(number), marker="osv^Dp"[number % 6], size=3.5, hollow=number > 0)
            traces.append(Trace(str(model["model"].item()), across, values.ravel(), look))
        panels.append(Panel("", along if not panels else replace(along, second=None), Scale(label), traces))
    heights = [1.0] * len(panels)
    if flags:
        panels.append(_strip(models, name, replace(along, second=None) if panels else along))
        heights.append(_STRIP * (1 + len(models)))
    return Chart(panels, 2.9 * sum(heights) + 0.6, heights=tuple(heights), legend="outside lower center", legend_columns=6)


def _strip(models: Sequence[Dataset], name: str, along: Scale) -> Panel:
    ticks = {float(number): str(model["model"].item()) for number, model in enumerate(models)}
    colours, _ = _regimes(models[0])
    values = np.array([_regimes(model)[1].values for model in models])
    look = Look(kind="cells", colors=colours, hatches=HATCHES)
    side = Scale("stable" if _flags_in(models[0]) == "stable" else "regime", limits=(-0.5, len(models) - 0.5), ticks=ticks)
    return Panel("", along, side, [Trace("regime", _positions(models[0][name]), [*ticks], look, value=values)])


def _other_side(data: Dataset, coordinate: DataArray) -> SecondScale | None:
    """The other scale of this axis of a sweep; None for a scene without units, and for a key that is no velocity or thickness."""
    own = _parameter_of(coordinate)
    key = own.name
    if key not in (*_VELOCITIES, *_TRANSITS) or "scene_toml" not in data.attrs:
        return None
    first, is_power = float(coordinate[0]), "log10" in key
    base = _base_of(data)
    try:
        scene = Variation(base).at([own], [first])
    except SceneError:
        return None
    if scene.units is None:
        return None
    (plain, value), (label, size) = ("r", scene.transit), ("transit / s", scene.units.size("transit", scene.transit))
    if key in _VELOCITIES:
        (plain, value), (label, size) = ("V/V*", scene.velocity), ("V / (m/s)", scene.velocity * scene.units.reference_velocity)
    here = 10.0**first if is_power else first
    return SecondScale(plain, value / here, is_power) if own.unit else SecondScale(label, size / here, is_power)


def onset_lines(data: Dataset) -> tuple[tuple[Line, ...], list[str]]:
    """The curves on which steady sliding loses its stability, of each model of a map over two axes, and for each without one a
    line why not."""
    axes = _axes_of(data)
    if len(axes) != 2:
        return (), []
    words = [axis for axis in axes if data[axis].dtype.kind not in "iuf"]
    if words:
        return (), [f"no boundary of stability: it is not computed over {' and '.join(words)}"]
    scenes, varied = _scenes_over(data, axes), [_parameter_of(data[axis]) for axis in axes]
    # a short name is sooner set than a key is read, but a slab of its own would follow it
    varied = [
        parameter if parameter.unit or scenes.sets else replace(parameter, name=SHORT.get(parameter.name, parameter.name))
        for parameter in varied
    ]
    ends = [(float(np.min(data[axis].values)), float(np.max(data[axis].values))) for axis in axes]
    powers = [_is_logarithmic(data[axis].values) for axis in axes]
    across, up = (
        (math.log10(low), math.log10(high)) if is_power else (low, high)
        for (low, high), is_power in zip(ends, powers, strict=True)
    )

    def on_axes(*values: Any) -> list[Any]:
        return [10.0**value if is_power else value for value, is_power in zip(values, powers, strict=True)]

    def scene_at(*values: float) -> Scene:
        return scenes.at(varied, [float(f"{x:.15g}") for x in on_axes(*values)])  # the end of an axis may be that of its key

    lines, notes = [], []
    for model in (str(name) for name in np.atleast_1d(data["model"].values)):
        try:
            curves = boundary(scene_at, one_port_of(model), (across, up), single=True)
        except (NumericsError, SceneError, ValueError) as error:
            notes.append(f"no boundary of stability of {model}: {error}")
            continue
        onsets = list[Line]()
        for curve in curves:
            # where another root grows, steady sliding has lost its stability before
            turns = np.flatnonzero(np.diff(curve.growing == 0, prepend=False, append=False))
            for begin, end in turns.reshape(-1, 2).tolist():
                first, second = on_axes(curve.first[begin:end], curve.second[begin:end])
                onsets.append(Line(f"onset of instability, {model}", first, second, model))
        if not onsets:
            notes.append(f"no boundary of stability of {model}: steady sliding does not change its stability on this map")
        lines += onsets
    return tuple(lines), notes


def lines_of_curve(files: Iterable[str | Path], data: Dataset) -> tuple[Line, ...]:
    """The special curves in files of `slipwave curve`. Raises SceneError for another file, or one over other parameters or of
    another scene."""
    axes, lines = _axes_of(data), []
    for path in [files] if isinstance(files, str) else files:
        curve = load_dataset(path, f"--curve = {str(path)!r}: is no netCDF file")
        if "law_digest" in curve.attrs:
            require_files(f"--curve = {str(path)!r}", {f"law {curve.attrs['law_file']}": curve.attrs["law_digest"]})
        columns = _columns_of(curve)
        if any(axis not in columns for axis in axes):
            raise SceneError(f"--curve = {str(path)!r}: holds no curve over {' and '.join(axes)}")
        _require_same_scenes(path, curve, data, axes)
        first, second = (np.asarray(columns[axis], dtype=float) / _bare(data[axis], _base_of(data)) for axis in axes)
        kind = curve["type" if "type" in curve else "point_kind"].values[0]
        lines.append(Line(f"{kind}, {curve.attrs['model']}", first, second, ""))
    return tuple(lines)


def _columns_of(curve: Dataset) -> dict[str, Any]:
    """The columns of a curve by the names that axes may have: its V is the drive's velocity too, and r and log10 r are each the
    other too."""
    columns: dict[str, Any] = {str(name): curve[name].values for name in curve.variables}
    # of a curve that can be continued
    columns |= {str(curve[name].attrs["long_name"]).replace(".", "_"): columns[name] for name in _CONTINUED if name in curve}
    columns |= {"drive_velocity": columns["V"]} if "V" in columns else {}
    trips = {name: column for name, column in columns.items() if name.split("_")[-1] == "r"}
    powers = {name.replace("log10_r", "r"): 10.0**column for name, column in trips.items() if name.endswith("log10_r")}
    logarithms = {f"{name[:-1]}log10_r": np.log10(column) for name, column in trips.items() if not name.endswith("log10_r")}
    return powers | logarithms | columns


def _require_same_scenes(path: str | Path, curve: Dataset, data: Dataset, axes: Sequence[str]) -> None:
    """Raises SceneError unless the scenes of a `curve` and of a sweep are the same at the same values of the `axes`, but for the
    start and the length of a run, which move no orbit."""
    varied, values = [_parameter_of(data[axis]) for axis in axes], [data[axis].values[0].item() for axis in axes]
    sets = json.loads(curve.attrs["options"]).get("set", {})
    theirs = scenes_with(_base_of(curve), [parameter.name for parameter in varied], sets).at(varied, values)
    ours = _scenes_over(data, axes).at(varied, values)
    here, there = ((repr(scene.law), repr(scene.upper), repr(scene.lower), repr(scene.drive)) for scene in (ours, theirs))
    parts = ("friction law", "upper slab", "lower slab", "drive")
    others = [part for part, own, other in zip(parts, here, there, strict=True) if own != other]
    if others:
        differ = f"{' and '.join(others)} differ{'s' if len(others) == 1 else ''}"
        raise SceneError(f"--curve = {str(path)!r}: is of another scene, whose {differ} from the sweep's")


def _bare(coordinate: DataArray, base: Scene) -> float:
    """One unit of an axis as the number that its key takes without a unit, in which curves are. Raises SceneError for a key whose
    bare numbers are no SI."""
    own, first = _parameter_of(coordinate), float(coordinate[0])
    if not own.unit:
        return 1.0
    size, _ = measured_value(f"1 {own.unit}")
    if own.name in _VELOCITIES and base.units:
        return size / base.units.reference_velocity
    value, _ = measured_value(str(own.written(first)))
    with suppress(SceneError):
        if slipwave.read(base, {own.name: value}).digest == Variation(base).at([own], [first]).digest:
            return size
    raise SceneError(f"--curve: {own.name} has no unit there; the sweep has it in {own.unit}, which is another number")
