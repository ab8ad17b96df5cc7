"""Theoretical lines over a map: the stability boundary of steady sliding, and special curves of orbits."""

import tomllib
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

import slipwave
from reduced.parameters import PARAMETERS
from reduced.stability.boundary import boundary
from slipwave.errors import NumericsError, SceneError
from slipwave.observe.pieces import Array
from validation.data.datasets import Dataset, load_dataset
from validation.models.by_name import one_port_of
from validation.models.parameter import SHORT
from validation.sweep.map_figures import Line, axes_of, is_logarithmic, other_side

_PLAIN = {"r": "r", "V/V*": "V"}
"""Label of the other side of an axis in SI -> parameter."""

_FACES = {"coefficient": "reflection", "impedance": "grip_impedance", "stiffness": "grip_stiffness", "mass": "machine_mass"}
"""Key of a face of both slabs -> parameter, in a scene without units."""


class _Side(NamedTuple):
    """An axis as a `parameter` of boundaries: its values times `factor`, or the logarithm of that."""

    parameter: str
    values: Array
    factor: float
    is_power: bool

    def on_axis(self, found: Array) -> Array:
        """Values of the parameter as values of the axis."""
        return (10.0**found if self.is_power else found) / self.factor


def _side(data: Dataset, axis: str) -> _Side | None:
    """None for an axis that is no such parameter, as a density. Thickness is a round trip, a velocity in SI one in V*."""
    if data[axis].dtype.kind not in "iuf":
        return None
    values, key = np.asarray(data[axis].values, dtype=float), str(data[axis].attrs.get("long_name", axis))
    name, factor, other = SHORT.get(key, key), 1.0, other_side(data, data[axis])
    if key.startswith("slab.face.") and "normal_stress" not in data.attrs["scene_toml"]:
        name = _FACES.get(key.removeprefix("slab.face."), key)
    if other is not None and other.label in _PLAIN:  # the axis is in SI
        name, factor = _PLAIN[other.label], other.factor
    if is_logarithmic(values) and f"log10_{name}" in PARAMETERS:
        return _Side(f"log10_{name}", np.log10(factor * values), factor, True)
    return _Side(name, factor * values, factor, False) if name in PARAMETERS else None


def onset_lines(data: Dataset) -> tuple[tuple[Line, ...], list[str]]:
    """The curves on which steady sliding loses its stability, of each model of a map over two axes, and for each without one a
    line why not."""
    axes = axes_of(data)
    if len(axes) != 2:
        return (), []
    sides = [_side(data, axis) for axis in axes]
    unknown = [axis for axis, side in zip(axes, sides, strict=True) if side is None]
    if unknown:
        return (), [f"no boundary of stability: it is not computed over {' and '.join(unknown)}"]
    across, up = (side for side in sides if side is not None)
    scene = slipwave.read_scene(tomllib.loads(data.attrs["scene_toml"]))
    ranges = tuple((float(side.values.min()), float(side.values.max())) for side in (across, up))
    lines, notes = [], []
    for model in (str(name) for name in np.atleast_1d(data["model"].values)):
        try:
            curves = boundary(scene, one_port_of(model), (across.parameter, up.parameter), (ranges[0], ranges[1]))
        except (NumericsError, SceneError, ValueError) as error:
            notes.append(f"no boundary of stability of {model}: {error}")
            continue
        if not curves:
            notes.append(f"no boundary of stability of {model}: steady sliding does not change its stability on this map")
        for curve in curves:
            lines.append(Line(f"onset of instability, {model}", across.on_axis(curve.first), up.on_axis(curve.second), model))
    return tuple(lines), notes


def lines_of_curve(files: Iterable[str], data: Dataset) -> tuple[Line, ...]:
    """The special curves in files of `slipwave curve`. Raises SceneError for another file, or one over other parameters."""
    axes, lines = axes_of(data), []
    for path in files:
        curve = load_dataset(path, f"--curve = {str(path)!r}: is no netCDF file")
        names = {str(name): str(name) for name in curve.variables} | ({"drive_velocity": "V"} if "V" in curve else {})
        if any(axis not in names for axis in axes):
            raise SceneError(f"--curve = {str(path)!r}: holds no curve over {' and '.join(axes)}")
        first, second = (np.asarray(curve[names[axis]].values, dtype=float) for axis in axes)
        lines.append(Line(f"{curve.attrs.get('type', 'curve')}, {curve.attrs.get('model', '')}", first, second, ""))
    return tuple(lines)
