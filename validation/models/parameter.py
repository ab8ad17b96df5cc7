"""The parameter of a branch: any number of a scene, by short name or key, with its range."""

import math
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias

import slipwave
from reduced.parameters import PARAMETERS
from slipwave.errors import SceneError
from slipwave.input import SceneSource
from slipwave.input.quantity import KINDS, looks_measured, quantity
from slipwave.input.wording import shorten
from slipwave.scene import Scene

SHORT = {
    "slab.log10_r": "log10_r",
    "slab.r": "r",
    "slab.epsilon": "epsilon",
    "drive.velocity": "V",
    "interface.a": "a",
    "interface.b": "b",
}
"""Short name -> key of a scene."""

Values: TypeAlias = str | tuple[str, float | str, float | str] | Mapping[str, tuple[float | str, float | str]]
"""A parameter with its range: "log10_r=-2.72:-2.30", ("log10_r", -2.72, -2.30) or {"log10_r": (-2.72, -2.30)}."""
_RANGE = re.compile(r"(?P<name>[^=]+)=(?P<first>[^:]+):(?P<last>[^:]+)")


@dataclass(frozen=True)
class Over:
    """The parameter `name` of the `base` scene between `first` and `last`; `scene_at` is the scene with a value of it."""

    base: Scene
    name: str
    first: float
    last: float
    scene_at: Callable[[float], Scene]
    unit: str = ""

    @property
    def column(self) -> str:
        """Its name in datasets: slab_thickness for slab.thickness."""
        return self.name.replace(".", "_")

    def written(self, value: float) -> float | str:
        """A value for the scene's key, with its unit if both ends of the range had one."""
        return f"{value!r} {self.unit}" if self.unit else value

    @property
    def ends(self) -> tuple[float, float]:
        """The smaller and the larger end."""
        return min(self.first, self.last), max(self.first, self.last)

    def holds(self, value: float) -> bool:
        """Whether `value` lies in the range."""
        return self.beyond(value) <= 0.0

    def beyond(self, value: float) -> float:
        """How far `value` lies outside the range, in its length; inside, minus the distance from the nearer end."""
        low, high = self.ends
        return max(low - value, value - high) / (high - low)


def range_text(values: Values | None) -> str | None:
    """The parameter and its range as the text of `--over`."""
    if values is None or isinstance(values, str):
        return values
    ranges = [(name, *ends) for name, ends in values.items()] if isinstance(values, Mapping) else [values]
    return ",".join(f"{name}={first}:{last}" for name, first, last in ranges)


def scene_along(over: Over, value: float) -> Scene:
    """The scene with this `value` of the parameter, with tables if the parameter is one of its keys."""
    name = next((key for key, short in SHORT.items() if short == over.name), over.name)
    with suppress(SceneError):
        return slipwave.read(over.base, {name: value})
    return over.scene_at(value)


def over_range(text: str, source: SceneSource, option: str = "--over") -> Over:
    """The parameter of `--over KEY=FROM:TO`, or of another `option`, for a scene.

    Raises SceneError if the text has another form, and if the scene cannot be read at one of the ends.
    """

    def require(holds: object, reason: str) -> None:
        """Raises SceneError with the `reason` unless it holds."""
        if not holds:
            raise SceneError(f"{option} {shorten(text)}: {reason}")

    found = _RANGE.fullmatch(text)
    require(found, "must be KEY=FROM:TO, as in log10_r=-2.72:-2.30")
    assert found is not None
    key, words = found["name"].strip(), (found["first"], found["last"])
    name, base = SHORT.get(key, key), slipwave.read(source)
    measured = [not math.isfinite(_number(word)) and looks_measured(word) for word in words]  # 2e-5 has no unit e^-5
    require(measured[0] is measured[1], "FROM and TO must both have a unit, or none")
    if measured[0]:
        ends = [_measured(name, key, base, word.strip()) for word in words]
        require(ends[0][1] == ends[1][1], "FROM and TO must have units of one kind")
    else:
        ends = [(_number(word), "") for word in words]
        wrong = next((word for word, (value, _) in zip(words, ends, strict=True) if not math.isfinite(value)), None)
        require(wrong is None, f"{shorten(wrong)} must be a number")
    (first, unit), (last, _) = ends
    require(first != last, "FROM and TO must differ")
    require(
        name in PARAMETERS or "." in name,
        f"{shorten(name)} is no parameter; must be one of {', '.join(PARAMETERS)}, or a key of the scene with its dots, as "
        "upper.epsilon or slab.face.stiffness",
    )
    if not base.drive.is_constant:
        raise SceneError(f"scene {base.name!r}: a branch of periodic orbits needs a constant drive.velocity")
    over = Over(base, name, first, last, _reader(name, base, (first, last), unit), unit)
    for value in over.ends:
        over.scene_at(value)
    return over


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _measured(name: str, key: str, base: Scene, text: str) -> tuple[float, str]:
    """Value and SI unit of a parameter given with a unit; for a short name the number in the scene's own units."""
    scene = slipwave.read(base, {key: text})
    if name in PARAMETERS:
        return _present(name, scene), ""
    given = quantity(text, *KINDS)
    return given.value, given.unit


def _reader(name: str, base: Scene, ends: tuple[float, float], unit: str) -> Callable[[float], Scene]:
    """Function that gives the scene at a value of the parameter. A short name without a key in this scene, as epsilon of unlike
    slabs or in SI, changes both slabs by the same factor. With a key, the scene is read at both `ends`, so that an error names
    the key, and set in between, in a hundredth of the time."""
    if name not in PARAMETERS:
        return lambda value: slipwave.read(base, {name: f"{value!r} {unit}" if unit else value})
    key = next((key for key, short in SHORT.items() if short == name), "")
    if key and has_key(base, key, name):
        for value in ends:
            slipwave.read(base, {key: value})
    return lambda value: PARAMETERS[name](base, _positive(name, value))


def has_key(base: Scene, key: str, name: str) -> bool:
    """Whether the scene has the key of a parameter: whether it can be read again with its present value."""
    with suppress(SceneError):
        slipwave.read(base, {key: _present(name, base)})
        return True
    return False


def _present(name: str, base: Scene) -> float:
    """The value of a parameter in a scene; 1 for ratios and values relative to a slab."""
    values = {"r": base.transit, "log10_r": math.log10(base.transit), "epsilon": base.upper.epsilon, "V": base.velocity}
    return values[name] if name in values else float(base.law._asdict().get(name, 1.0))


def _positive(name: str, value: float) -> float:
    if name in ("r", "epsilon", "ratio_r", "ratio_epsilon") and not value > 0.0:
        raise SceneError(f"{name} = {value:g}: must be above 0")
    return value
