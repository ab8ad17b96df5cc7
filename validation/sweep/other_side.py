"""The second scale of a map's axis, for scenes with units: in SI beside a dimensionless axis, dimensionless beside one in SI."""

import tomllib
from typing import Any, NamedTuple

import numpy as np

import slipwave
from slipwave.errors import SceneError
from validation.results.result import DataArray, Dataset
from validation.sweep.axes import changed

_VELOCITIES, _TRANSITS = ("V", "drive.velocity"), ("r", "log10_r", "slab.r", "slab.log10_r", "slab.thickness")
"""Keys to whose values, or powers of ten of a logarithm, V and the transit are proportional."""


class Scale(NamedTuple):
    """`factor` times the axis' value, or times its power of ten, is what the other side shows under `label`."""

    label: str
    factor: float
    is_power: bool

    def add(self, axes: Any, across: bool) -> None:
        """Draw it above or to the right of `axes`."""
        functions: Any = (lambda values: self.factor * values, lambda values: values / self.factor)
        if self.is_power:
            there, back = functions
            functions = (lambda values: there(10.0**values), lambda values: np.log10(np.maximum(back(values), 1e-300)))
        second = axes.secondary_xaxis("top", functions) if across else axes.secondary_yaxis("right", functions)
        (second.set_xlabel if across else second.set_ylabel)(self.label)


def other_side(data: Dataset, coordinate: DataArray) -> Scale | None:
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
    return Scale(label, size / here, is_power) if in_si else Scale(plain, value / here, is_power)
