"""Theoretical lines over a map: the stability boundary of steady sliding, and special curves of orbits."""

import tomllib
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

import slipwave
from reduced.parameters import PARAMETERS
from reduced.stability.boundary import boundary
from slipwave.errors import NumericsError, SceneError
from validation.data.datasets import Dataset, load_dataset
from validation.models.by_name import one_port_of
from validation.models.parameter import SHORT
from validation.sweep.map_figures import Line, is_logarithmic


def _side(data: Dataset, axis: str) -> tuple[str, npt.NDArray[np.float64], bool] | None:
    """The axis as a parameter of boundaries: its name, its values, and whether these are powers of ten; None for a key that is
    none, as a thickness."""
    values, key = np.asarray(data[axis].values, dtype=float), str(data[axis].attrs.get("long_name", axis))
    name = SHORT.get(key, key)
    if is_logarithmic(values) and f"log10_{name}" in PARAMETERS:
        return f"log10_{name}", np.log10(values), True
    return (name, values, False) if name in PARAMETERS else None


def onset_lines(data: Dataset) -> tuple[Line, ...]:
    """The curves on which steady sliding loses its stability, of each model of a map over two parameters; none if an axis is no
    such parameter, or if they cannot be computed."""
    axes = [str(name) for name in data["status"].dims if name != "model"]
    of_words = any(data[axis].dtype.kind not in "fi" for axis in axes)
    sides = [] if of_words else [_side(data, axis) for axis in axes]
    if len(sides) != 2 or None in sides:
        return ()
    across, up = (side for side in sides if side is not None)
    scene = slipwave.read_scene(tomllib.loads(data.attrs["scene_toml"]))
    ranges = tuple((float(values.min()), float(values.max())) for _, values, _ in (across, up))
    lines = []
    for model in (str(name) for name in np.atleast_1d(data["model"].values)):
        try:
            curves = boundary(scene, one_port_of(model), (across[0], up[0]), (ranges[0], ranges[1]))
        except (NumericsError, SceneError, ValueError):
            continue
        for curve in curves:
            pairs = ((curve.first, across), (curve.second, up))
            first, second = (10.0**values if is_power else values for values, (_, _, is_power) in pairs)
            lines.append(Line(f"onset of instability, {model}", first, second, model))
    return tuple(lines)


def lines_of_curve(files: Iterable[str], data: Dataset) -> tuple[Line, ...]:
    """The special curves in files of `slipwave curve`. Raises SceneError for another file, or one over other parameters."""
    axes = [str(name) for name in data["status"].dims if name != "model"]
    lines = []
    for path in files:
        curve = load_dataset(path, f"--curve = {str(path)!r}: is no netCDF file")
        names = {str(name): str(name) for name in curve.variables} | ({"drive_velocity": "V"} if "V" in curve else {})
        if any(axis not in names for axis in axes):
            raise SceneError(f"--curve = {str(path)!r}: holds no curve over {' and '.join(axes)}")
        first, second = (np.asarray(curve[names[axis]].values, dtype=float) for axis in axes)
        lines.append(Line(f"{curve.attrs.get('type', 'curve')}, {curve.attrs.get('model', '')}", first, second, ""))
    return tuple(lines)
