"""The keys of a scene that a fit changes, as unbounded numbers for least squares."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from slipwave.errors import SceneError
from slipwave.input.assemble import tables_of, validate
from slipwave.input.overrides import full_key
from slipwave.input.quantity import Quantity
from slipwave.input.schema import allowed_numbers
from slipwave.input.wording import choices, key_text, nearest
from slipwave.observe.pieces import Array
from slipwave.scene import Scene
from slipwave.scene.drive import Drive, Start, StartKind
from slipwave.step.sensitivity import ShiftedScenes
from validation.models.parameter import Parameter, Variation, measured_value, number_in

NUISANCES = ("level", "drift")
"""Further free parameters: a constant added to the friction of each record, and its slope over the record."""

_STEP = 1e-5  # of differences of laws and tables
_REACH = 1e4  # a positive parameter may become so much larger or smaller than at its start


@dataclass(frozen=True, kw_only=True)
class FreeParameter(Parameter):
    """A free parameter: its `start` value, the least and the largest. `is_positive`: its logarithm is fitted, else its share of
    the start value, if that is not 0. `shown_unit`: that of SI, also where the scene takes bare numbers in it."""

    start: float
    low: float
    high: float
    is_positive: bool
    shown_unit: str

    def inner(self, value: float) -> float:
        """The value as least squares varies it."""
        return math.log(value) if self.is_positive else value / (abs(self.start) or 1.0)

    def value(self, inner: float) -> float:
        """The inverse of `inner`: the value in its unit; infinite at the end of an interval that is too large."""
        with np.errstate(over="ignore"):
            return float(np.exp(inner)) if self.is_positive else inner * (abs(self.start) or 1.0)


@dataclass(frozen=True)
class Variants:
    """The scenes with values of `free`, with `start` or, if None, from steady sliding (or the jump of
    the base); the load point is driven by the `schedule`, in SI for a scene with units, else in transits and V*."""

    scenes: Variation
    free: tuple[FreeParameter, ...]
    schedule: Drive
    start: Start | None = None

    def read(self, inner: Array) -> Scene:
        """The scene with these values, with its own drive and start."""
        return self.scenes.at(self.free, [key.value(x) for key, x in zip(self.free, inner.tolist(), strict=True)])

    def scene(self, inner: Array) -> Scene:
        """The scene with these values, without nudge."""
        changed = self.read(inner)
        clock, pace = sizes(changed)
        drive = Drive(tuple(t / clock for t in self.schedule.times), tuple(v / pace for v in self.schedule.velocities))
        own = changed.start if changed.start.kind is StartKind.JUMP else Start(size=0.0)
        return replace(changed, drive=drive, start=self.start or own, record=frozenset({"events"}))

    def neighbours(self, inner: Array) -> list[ShiftedScenes]:
        """The scenes on either side of each parameter."""
        clock, sides = sizes(self.scene(inner))[0], []
        for shift in _STEP * np.eye(len(self.free)):
            scenes = self.scene(inner + shift), self.scene(inner - shift)
            sides.append(ShiftedScenes(scenes, (clock / sizes(scenes[0])[0], clock / sizes(scenes[1])[0]), _STEP))
        return sides


def sizes(scene: Scene) -> tuple[float, float]:
    """One transit in s and V* in m/s; 1 for a scene without units."""
    if scene.units is None:
        return 1.0, 1.0
    return scene.transit * scene.units.time, scene.units.reference_velocity


def schedule_of(scene: Scene) -> Drive:
    """The drive of a scene, in SI if it has units."""
    clock, pace = sizes(scene)
    return Drive(tuple(t * clock for t in scene.drive.times), tuple(v * pace for v in scene.drive.velocities))


def _free_parameters(scenes: Variation, words: Sequence[str]) -> tuple[FreeParameter, ...]:
    """The free keys, and variables with their starts, among `words`, without nuisances. Raises SceneError for a key that the
    scene lacks or that is no number, for a repeated key, and for a variable without a start."""
    _, data = tables_of(scenes.base)
    known, free = validate(data), list[FreeParameter]()
    for name, sign, start in (word.partition("=") for word in words if word not in NUISANCES):
        if name.strip() in scenes.variables:
            free.append(_variable(name.strip(), start))
        elif sign:
            raise SceneError(f"--free {name.strip()}: is no variable that a --set names; a key begins at its value in the scene")
        else:
            free.append(_free(full_key(name.split("."), "", data), known, scenes.base))
    names = [key.name for key in free]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice:
        raise SceneError(f"--free {twice}: is given more than once")
    return tuple(free)


def begun(scenes: Variation, words: Sequence[str]) -> tuple[Variation, tuple[FreeParameter, ...]]:
    """The scenes, with the variables of the base at their starts, and `_free_parameters`. Raises SceneError as these, and for a
    scene that cannot be read at the starts."""
    free = _free_parameters(scenes, words)
    start = {key.name: key.written(key.start) for key in free if key.name in scenes.variables}
    if start:
        scenes.require(start)
        scenes = replace(scenes, base=scenes.scene(start))
    return scenes, free


def _variable(name: str, text: str) -> FreeParameter:
    """A variable that begins at a number, with or without a unit."""
    try:
        start, unit = measured_value(text)
    except ValueError:
        start, unit = math.nan, ""
    if not math.isfinite(start):
        raise SceneError(f"--free {name}{text and '='}{text}: must be a variable with its start, as {name}=1")
    low, high = (start / _REACH, start * _REACH) if start > 0.0 else (-math.inf, math.inf)
    return FreeParameter(name=name, unit=unit, start=start, low=low, high=high, is_positive=start > 0.0, shown_unit=unit)


def _free(key: Sequence[str], known: Any, base: Scene) -> FreeParameter:
    name, table = key_text(key), known
    for part in key[:-1]:
        table = getattr(table, part, None)
    value = getattr(table, key[-1], None)
    if value is None:
        fields = [] if table is None else [field for field, there in table if isinstance(there, int | float | Quantity)]
        guess = nearest(key[-1], fields) if fields else ""
        there = f"; did you mean {guess}?" if guess else f"; there {choices([*fields, *NUISANCES])} can be" if fields else ""
        raise SceneError(f"--free {name}: the scene gives no value to start from{there}")
    if isinstance(value, bool) or not isinstance(value, int | float | Quantity):
        there = f" = {value}" if isinstance(value, str) else ""
        raise SceneError(f"--free {name}{there}: must be a number of the scene, that does not change with time")
    allowed = allowed_numbers(table, key[-1])
    start, written, unit = number_in(table, name, value, base)
    is_positive = allowed.low >= 0.0
    if is_positive and start <= 0.0:
        raise SceneError(f"--free {name} = {start:g}: must start above 0")
    low, high = (
        (max(allowed.low, start / _REACH), min(allowed.high, start * _REACH)) if is_positive else (allowed.low, allowed.high)
    )
    if isinstance(value, Quantity):
        low, high = (start / _REACH, start * _REACH) if is_positive else (-math.inf, math.inf)
    return FreeParameter(name=name, unit=written, start=start, low=low, high=high, is_positive=is_positive, shown_unit=unit)
