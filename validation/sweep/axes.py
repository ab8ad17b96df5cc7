"""An axis of a sweep: a key of the scene and its values."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

import slipwave
from reduced.parameters import PARAMETERS
from slipwave.errors import SceneError
from slipwave.input.overrides import full_key
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from validation.models.parameter import has_key

LONGEST = 100_000
"""Most values of an axis."""

Values: TypeAlias = str | tuple[float | str, float | str, int] | Iterable[float | str]
"""The values of an axis: "FROM:TO:COUNT" or "FROM:TO:COUNT:log" as text, (first, last, count), or all of them."""

_PLAIN = ("slab.log10_r", "slab.r", "slab.epsilon", "interface.a", "interface.b")
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)")


@dataclass(frozen=True)
class Axis:
    """The `values` of the scene's `key`, in its `unit` (empty: as the scene's key takes numbers)."""

    key: str
    values: tuple[float, ...]
    unit: str = ""

    @property
    def name(self) -> str:
        """The name of the coordinate: slab_thickness for slab.thickness."""
        return self.key.rpartition(".")[2] if self.key in _PLAIN else self.key.replace(".", "_")

    def written(self, number: int) -> float | str:
        """A value for the scene's key."""
        value = self.values[number]
        return f"{value!r} {self.unit}" if self.unit else value


def axis_of(key: str, values: Values) -> Axis:
    """The axis over `key`. Raises SceneError for no, too many, equal or invalid values, and for different units."""
    where = f"--vary {key}"
    if isinstance(values, str):
        return _from_text(key, values, where)
    if not isinstance(values, Iterable):
        raise SceneError(f"{where}: {shorten(values)} must be several values, or FROM:TO:COUNT")
    listed = list(values)
    if isinstance(values, tuple) and len(listed) == 3 and isinstance(listed[2], int) and not isinstance(listed[2], bool):
        first, last, count = listed
        return _from_text(key, f"{first}:{last}:{count}", where)
    return _checked(key, [_number(where, value) for value in listed], where)


def _from_text(key: str, text: str, where: str) -> Axis:
    words = text.split(":")
    if len(words) == 1:
        return _checked(key, [_number(where, word) for word in text.split(",")], where)
    if len(words) not in (3, 4) or (len(words) == 4 and words[3] != "log"):
        raise SceneError(f"{where}={shorten(text)}: must be KEY=FROM:TO:COUNT, KEY=FROM:TO:COUNT:log or KEY=A,B,C")
    (first, unit), (last, other) = (_number(where, word) for word in words[:2])
    if not words[2].strip().isdecimal() or not 2 <= int(words[2]) <= LONGEST:
        raise SceneError(f"{where}={shorten(text)}: COUNT must be a whole number from 2 to {LONGEST}")
    logarithmic = len(words) == 4
    if logarithmic and not min(first, last) > 0.0:
        raise SceneError(f"{where}={shorten(text)}: FROM and TO must be above 0 on a logarithmic axis")
    spaced = (np.geomspace if logarithmic else np.linspace)(first, last, int(words[2]))
    return _checked(key, [(float(value), unit) for value in spaced] + ([(last, other)] if other != unit else []), where)


def _number(where: str, value: Any) -> tuple[float, str]:
    match = _NUMBER.fullmatch(str(value))
    number = float(match[1]) if match else math.nan
    if not match or not math.isfinite(number):
        raise SceneError(f"{where}: {shorten(str(value))} must be a number, with or without a unit")
    return number, match[2].strip()


def _checked(key: str, values: list[tuple[float, str]], where: str) -> Axis:
    units = sorted({unit for _, unit in values})
    if len(units) > 1:
        raise SceneError(f"{where}: all values must have the same unit, or none; found {' and '.join(map(repr, units))}")
    numbers = tuple(value for value, _ in values)
    if not 1 <= len(numbers) <= LONGEST or len(set(numbers)) < len(numbers):
        raise SceneError(f"{where}: must be 1 to {LONGEST} different values")
    return Axis(key, numbers, units[0])


def changed(base: Scene, values: Mapping[str, float | str]) -> Scene:
    """`base` with `values` of its keys. A parameter that is no key of this scene (epsilon in SI, ratio_r ...) changes both slabs.

    Raises SceneError for a value out of range, naming its key."""
    others = {key: value for key, value in values.items() if _is_parameter(base, key)}
    scene = slipwave.read(base, {key: value for key, value in values.items() if key not in others})
    for key, value in others.items():
        if isinstance(value, str):
            raise SceneError(f"{key} = {value}: must be a number without a unit")
        scene = PARAMETERS[key](scene, value)
    return scene


def whole_key(key: str, base: Scene) -> str:
    """The full key of the scene that ends in `key`, resolved once for all points; `key` itself if there is none."""
    if _is_parameter(base, key):
        return key
    return ".".join(full_key(key.split("."), "", base.tables or {}))


@lru_cache(maxsize=256)
def _is_parameter(base: Scene, key: str) -> bool:
    """Whether `key` is a parameter (`reduced.parameters`), but no key of the scene."""
    return key in PARAMETERS and not has_key(base, key, key)
