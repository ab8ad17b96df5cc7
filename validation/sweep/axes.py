"""An axis of a sweep: a parameter of the scene and its values, numbers or words."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from slipwave.errors import SceneError
from slipwave.input.wording import shorten
from validation.models.parameter import SHORT, Parameter, measured_value, number_of

LONGEST = 100_000
"""Most values of an axis."""

Values: TypeAlias = str | tuple[float | str, float | str, int] | Iterable[float | str]
"""The values of an axis: "FROM:TO:COUNT" or "FROM:TO:COUNT:log" as text, (first, last, count), or all of them."""

_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


@dataclass(frozen=True)
class Axis(Parameter):
    """The `values` of the parameter."""

    values: tuple[float, ...] | tuple[str, ...] = field(kw_only=True)

    @property
    def is_of_words(self) -> bool:
        """Whether its values are words."""
        return isinstance(self.values[0], str)

    @property
    def column(self) -> str:
        """The name of the coordinate: slab_thickness for slab.thickness."""
        return super().column if self.name == "drive.velocity" else SHORT.get(self.name, super().column)


def axis_of(key: str, values: Values) -> Axis:
    """The axis over `key`. Raises SceneError for no, too many, equal or invalid values, and for units of different kinds."""
    where = f"--vary {key}"
    if isinstance(values, str):
        return _from_text(key, values, where)
    if not isinstance(values, Iterable):
        raise SceneError(f"{where}: {shorten(values)} must be several values, or FROM:TO:COUNT")
    listed = list(values)
    if isinstance(values, tuple) and len(listed) == 3 and isinstance(listed[2], int) and not isinstance(listed[2], bool):
        first, last, count = listed
        return _from_text(key, f"{first}:{last}:{count}", where)
    return _checked(key, *_read(where, listed), where)


def _from_text(key: str, text: str, where: str) -> Axis:
    words = text.split(":")
    if len(words) == 1:
        return _checked(key, *_read(where, text.split(",")), where)
    if len(words) not in (3, 4) or (len(words) == 4 and words[3] != "log"):
        raise SceneError(f"{where}={shorten(text)}: must be KEY=FROM:TO:COUNT, KEY=FROM:TO:COUNT:log or KEY=A,B,C")
    if not words[2].strip().isdecimal() or not 2 <= int(words[2]) <= LONGEST:
        raise SceneError(f"{where}={shorten(text)}: COUNT must be a whole number from 2 to {LONGEST}")
    (first, last), unit = _read(where, words[:2])
    if isinstance(first, str) or isinstance(last, str):
        raise SceneError(f"{where}={shorten(text)}: FROM and TO must be numbers")
    logarithmic = len(words) == 4
    if logarithmic and not min(first, last) > 0.0:
        raise SceneError(f"{where}={shorten(text)}: FROM and TO must be above 0 on a logarithmic axis")
    return _checked(key, (np.geomspace if logarithmic else np.linspace)(first, last, int(words[2])).tolist(), unit, where)


def _read(where: str, given: list[Any]) -> tuple[list[float] | list[str], str]:
    """Words, or numbers and their unit: that of all of them, or, where they differ, that of SI."""
    texts = [str(one).strip() for one in given]
    if all(_WORD.fullmatch(text) for text in texts):
        return texts, ""
    read = [number_of(text) for text in texts]
    wrong = next((text for text, (value, _) in zip(texts, read, strict=True) if not math.isfinite(value)), None)
    if wrong is not None:
        raise SceneError(f"{where}: {shorten(wrong)} must be a number, with or without a unit, or all values must be words")
    units = sorted({unit for _, unit in read})
    if len(units) > 1:
        try:
            read = [measured_value(text) if unit else (value, unit) for text, (value, unit) in zip(texts, read, strict=True)]
        except ValueError as error:
            raise SceneError(f"{where}: {error}") from None
    if len({unit for _, unit in read}) > 1:
        raise SceneError(f"{where}: all values must have units of one kind, or none; found {' and '.join(map(repr, units))}")
    return [value for value, _ in read], read[0][1] if read else ""


def _checked(key: str, values: list[float] | list[str], unit: str, where: str) -> Axis:
    if not 1 <= len(values) <= LONGEST or len(set(values)) < len(values):
        raise SceneError(f"{where}: must be 1 to {LONGEST} different values")
    found: Any = tuple(values)
    return Axis(key, unit, values=found)
