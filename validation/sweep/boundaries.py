"""Theoretical lines over a map: the stability boundary of steady sliding, and special curves of orbits."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from reduced.parameters import PARAMETERS
from reduced.stability.boundary import boundary
from slipwave.errors import NumericsError, SceneError
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from validation.data.datasets import Dataset, load_dataset
from validation.models.by_name import one_port_of
from validation.models.parameter import SHORT, Variation
from validation.sweep.map_figures import Line, axes_of, is_logarithmic, other_side, parameter_of, scenes_over

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
    values, key = np.asarray(data[axis].values, dtype=float), parameter_of(data[axis]).name
    name, factor, other = SHORT.get(key, key), 1.0, other_side(data, data[axis])
    if key.startswith("slab.face.") and "normal_stress" not in data.attrs["scene_toml"]:
        name = _FACES.get(key.removeprefix("slab.face."), key)
    if other is not None and other.label in _PLAIN:  # the axis is in SI
        name, factor = _PLAIN[other.label], other.factor
    if is_logarithmic(values) and f"log10_{name}" in PARAMETERS:
        return _Side(f"log10_{name}", np.log10(factor * values), factor, True)
    return _Side(name, factor * values, factor, False) if name in PARAMETERS else None


def _own_sides(data: Dataset, scenes: Variation) -> tuple[list[_Side], Callable[[float, float], Scene]]:
    """Two axes of numbers as they are, over any keys and variables, and the scene at values of both."""
    sides = list[_Side]()
    for axis in axes_of(data):
        values = np.asarray(data[axis].values, dtype=float)
        is_power = is_logarithmic(values)
        sides.append(_Side(axis, np.log10(values) if is_power else values, 1.0, is_power))
    parameters = [parameter_of(data[axis]) for axis in axes_of(data)]

    def scene_at(*found: float) -> Scene:
        """The scene at values of both sides."""
        return scenes.at(parameters, [float(side.on_axis(np.asarray(value))) for side, value in zip(sides, found, strict=True)])

    return sides, scene_at


def onset_lines(data: Dataset) -> tuple[tuple[Line, ...], list[str]]:
    """The curves on which steady sliding loses its stability, of each model of a map over two axes, and for each without one a
    line why not."""
    axes = axes_of(data)
    if len(axes) != 2:
        return (), []
    words = [axis for axis in axes if data[axis].dtype.kind not in "iuf"]
    if words:
        return (), [f"no boundary of stability: it is not computed over {' and '.join(words)}"]
    scenes, scene_at = scenes_over(data, axes), None
    sides = [side for axis in axes if (side := _side(data, axis))]
    if len(sides) < len(axes) or scenes.sets:
        sides, scene_at = _own_sides(data, scenes)
    across, up = sides
    ranges = tuple((float(side.values.min()), float(side.values.max())) for side in (across, up))
    lines, notes = [], []
    for model in (str(name) for name in np.atleast_1d(data["model"].values)):
        try:
            curves = boundary(scenes.base, one_port_of(model), (across.parameter, up.parameter), (ranges[0], ranges[1]), scene_at)
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
