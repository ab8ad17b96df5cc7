"""The parameter of a branch: any number of a scene, by a short name or by its key, with the range to be covered."""

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

_SHORT = {
    "slab.log10_r": "log10_r",
    "slab.r": "r",
    "slab.epsilon": "epsilon",
    "drive.velocity": "V",
    "interface.a": "a",
    "interface.b": "b",
}
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

    def written(self, value: float) -> float | str:
        """A value as the scene's key takes it: with its unit, if both ends of the range had one."""
        return f"{value!r} {self.unit}" if self.unit else value

    @property
    def ends(self) -> tuple[float, float]:
        """The smaller and the larger end."""
        return min(self.first, self.last), max(self.first, self.last)

    def holds(self, value: float) -> bool:
        """Whether `value` lies in the range."""
        low, high = self.ends
        return low <= value <= high


def range_text(values: Values | None) -> str | None:
    """The parameter and its range as the text of `--over`."""
    if values is None or isinstance(values, str):
        return values
    ranges = [(name, *ends) for name, ends in values.items()] if isinstance(values, Mapping) else [values]
    return ",".join(f"{name}={first}:{last}" for name, first, last in ranges)


def scene_along(over: Over, value: float) -> Scene:
    """The scene with this `value` of the parameter, with the tables to change it if one of its keys is the parameter."""
    name = next((key for key, short in _SHORT.items() if short == over.name), over.name)
    with suppress(SceneError):
        return slipwave.read(over.base, {name: value})
    return over.scene_at(value)


def over_range(text: str, source: SceneSource, option: str = "--over") -> Over:
    """The parameter of `--over KEY=FROM:TO`, or of another `option`, for a scene.

    Raises SceneError if the text is not of that form, and if the scene cannot be read at one of both ends.
    """
    found = _RANGE.fullmatch(text)
    if found is None:
        raise SceneError(f"{option} {shorten(text)}: must be KEY=FROM:TO, as in log10_r=-2.72:-2.30")
    key = found["name"].strip()
    name = _SHORT.get(key, key)
    base = slipwave.read(source)
    measured = [_has_unit(found[word]) for word in ("first", "last")]
    if measured[0] is not measured[1]:
        raise SceneError(f"{option} {shorten(text)}: FROM and TO must both have a unit, or none")
    if measured[0]:
        (first, unit), (last, other) = (_measured(name, key, base, found[word]) for word in ("first", "last"))
        if unit != other:
            raise SceneError(f"{option} {shorten(text)}: FROM and TO must have units of one kind")
    else:
        unit, (first, last) = "", (_number(text, found[word], option) for word in ("first", "last"))
    if first == last:
        raise SceneError(f"{option} {shorten(text)}: FROM and TO must differ")
    if name not in PARAMETERS and "." not in name:
        raise SceneError(
            f"{option} {shorten(text)}: {shorten(name)} is no parameter; must be one of {', '.join(PARAMETERS)}, or a key of the "
            "scene with its dots, as upper.epsilon or slab.face.stiffness"
        )
    if not base.drive.is_constant:
        raise SceneError(f"scene {base.name!r}: a branch of periodic orbits needs a constant drive.velocity")
    over = Over(base, name, first, last, _reader(name, base, (first, last), unit), unit)
    for value in over.ends:
        over.scene_at(value)
    return over


def _has_unit(text: str) -> bool:
    """Whether a text is a number with a unit; 2e-5 is none with the unit e^-5."""
    with suppress(ValueError):
        float(text)
        return False
    return looks_measured(text)


def _measured(name: str, key: str, base: Scene, text: str) -> tuple[float, str]:
    """The value of a parameter given with a unit, and the SI unit of it; of a short name the number in the scene's own units."""
    scene = slipwave.read(base, {key: text.strip()})
    if name in PARAMETERS:
        return _present(name, scene), ""
    given = quantity(text.strip(), *KINDS)
    return given.value, given.unit


def _number(text: str, word: str, option: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SceneError(f"{option} {shorten(text)}: {shorten(word)} must be a number")
    return value


def _reader(name: str, base: Scene, ends: tuple[float, float], unit: str) -> Callable[[float], Scene]:
    """The scene with a value of its key. A short name without a key in this scene, as epsilon of unlike slabs or in SI, changes
    both slabs by the same factor. One with a key is read with it at both `ends`, so that an error names the key of a wrong value,
    and set in the scene in between, which takes a hundredth of the time."""
    if name not in PARAMETERS:
        return lambda value: slipwave.read(base, {name: f"{value!r} {unit}" if unit else value})
    key = next((key for key, short in _SHORT.items() if short == name), "")
    keyed = _keyed(key, base)
    if key and _has(keyed, _present(name, base)):
        for value in ends:
            keyed(value)
    return lambda value: PARAMETERS[name](base, _positive(name, value))


def _has(keyed: Callable[[float], Scene], present: float) -> bool:
    """Whether the scene has the key: then it can be read with the value that it has."""
    with suppress(SceneError):
        keyed(present)
        return True
    return False


def _keyed(key: str, base: Scene) -> Callable[[float], Scene]:
    return lambda value: slipwave.read(base, {key: value})


def _present(name: str, base: Scene) -> float:
    """The value of a short name in a scene."""
    values = {"r": base.transit, "log10_r": math.log10(base.transit), "epsilon": base.upper.epsilon, "V": base.velocity}
    return values[name] if name in values else float(getattr(base.law, name))


def _positive(name: str, value: float) -> float:
    if name in ("r", "epsilon", "ratio_r", "ratio_epsilon") and not value > 0.0:
        raise SceneError(f"{name} = {value:g}: must be above 0")
    return value
