"""The second scale of a map's axis, for scenes with units: in SI beside a dimensionless axis, dimensionless beside one in SI."""

import tomllib
from typing import TYPE_CHECKING, Any, NamedTuple

import slipwave
from slipwave.errors import SceneError
from slipwave.scene import Scene
from validation.sweep.axes import changed

if TYPE_CHECKING:
    from xarray import DataArray, Dataset
else:
    DataArray = Dataset = Any


class Scale(NamedTuple):
    """`factor` times the axis' value, or times its power of ten, is what the other side shows under `label`."""

    label: str
    factor: float
    is_power: bool

    def add(self, axes: Any, across: bool) -> None:
        """Draw it above or to the right of `axes`."""
        import numpy as np

        def there(values: Any) -> Any:
            """From the axis to the other side."""
            return self.factor * (10.0 ** np.asarray(values) if self.is_power else np.asarray(values))

        def back(values: Any) -> Any:
            """From the other side to the axis."""
            shares = np.asarray(values) / self.factor
            return np.log10(np.maximum(shares, 1e-300)) if self.is_power else shares

        if across:
            axes.secondary_xaxis("top", functions=(there, back)).set_xlabel(self.label)
        else:
            axes.secondary_yaxis("right", functions=(there, back)).set_ylabel(self.label)


def _velocity(scene: Scene, in_si: bool) -> tuple[str, float]:
    assert scene.units is not None
    return ("V [m/s]", scene.velocity * scene.units.reference_velocity) if in_si else ("V/V*", scene.velocity)


def _transit(scene: Scene, in_si: bool) -> tuple[str, float]:
    assert scene.units is not None
    return ("transit [s]", scene.units.size("transit", scene.transit)) if in_si else ("r", scene.transit)


_QUANTITIES = {
    "V": _velocity,
    "drive.velocity": _velocity,
    **dict.fromkeys(("r", "log10_r", "slab.r", "slab.log10_r", "slab.thickness"), _transit),
}
"""By key: what is proportional to the axis' value or, of a logarithm, to its power of ten."""


def other_side(data: Dataset, coordinate: DataArray) -> Scale | None:
    """The other scale of this axis of a sweep; None for a scene without units, and for a key that is no velocity or thickness."""
    key, unit = str(coordinate.attrs.get("long_name", coordinate.name)), str(coordinate.attrs.get("units", "1"))
    if key not in _QUANTITIES or "scene_toml" not in data.attrs:
        return None
    scene, first, is_power = slipwave.read_scene(tomllib.loads(data.attrs["scene_toml"])), float(coordinate[0]), "log10" in key
    if scene.units is None:
        return None
    try:
        label, value = _QUANTITIES[key](changed(scene, {key: f"{first!r} {unit}" if unit != "1" else first}), unit == "1")
    except SceneError:
        return None
    return Scale(label, value / (10.0**first if is_power else first), is_power)
