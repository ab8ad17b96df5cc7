"""The plan of a sweep: its axes (parameters of the scene and their values, numbers or words), their points, the scenes there, and
their order."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import chain
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from reduced.parameters import PARAMETERS
from slipwave.errors import SceneError
from slipwave.friction.law import name_of
from slipwave.input.assemble import tables_of
from slipwave.input.overrides import apply_overrides
from slipwave.input.schema import UNIT_KEYS
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from validation.models.parameter import SHORT, Parameter, Variation, measured_value, number_of
from validation.sweep.measures import measure_of

MOST = 10**8
"""Most points of a sweep."""

Alone: TypeAlias = tuple[dict[str, Any], Scene]
"""The fields of a scene that a changed key affects, and whether that scene was read."""

Indices = npt.NDArray[np.int64]

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


def _touched(axis: Axis) -> set[str]:
    """The fields of a scene that the key changes at some value, though not at that of the scene, or by which its values are
    converted: of a unit of the scene all, since others may be converted by it."""
    table, last = axis.name.partition(".")[0], axis.name.rpartition(".")[2]
    if last in UNIT_KEYS:
        return {field.name for field in fields(Scene) if field.init}
    if table == "run":
        return {"until", "record"} | ({"upper"} if axis.unit else set())
    return {"drive": {"drive"}, "start": {"start"}, "interface": {"law"}}.get(table, {"upper", "lower"})


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
    texts = [str(value).strip() for value in given]
    if all(_WORD.fullmatch(text) for text in texts):
        return texts, ""
    read = [number_of(text) for text in texts]
    wrong = next((text for text, (value, _) in zip(texts, read, strict=True) if not math.isfinite(value)), None)
    if wrong is not None:
        raise SceneError(f"{where}: {shorten(wrong)} must be a number, with or without a unit, or all values must be words")
    units = sorted({unit for _, unit in read})
    if len(units) > 1:
        try:
            read = [measured_value(text) for text in texts]
        except ValueError as error:
            raise SceneError(f"{where}: {error}") from None
    if len({unit for _, unit in read}) > 1:
        raise SceneError(f"{where}: all values must have units of one kind, or none; found {' and '.join(map(repr, units))}")
    return [value for value, _ in read], read[0][1] if read else ""


def _checked(key: str, values: list[float] | list[str], unit: str, where: str) -> Axis:
    if not 1 <= len(values) <= LONGEST or len(set(values)) < len(values):
        raise SceneError(f"{where}: must be 1 to {LONGEST} different values")
    checked: Any = tuple(values)
    return Axis(key, unit, values=checked)


@dataclass(frozen=True)
class Plan:
    """`measure` of every model at every point of the `axes` over `scenes`. A point's number is its index in a flat array
    of shape (models, *axes). `rows`: the changes of listed scenes, instead of axes."""

    scenes: Variation
    axes: tuple[Axis, ...]
    models: tuple[str, ...]
    measure: str
    options: Mapping[str, Any] = field(default_factory=dict)
    rows: tuple[Mapping[str, float | str], ...] = ()
    _known: dict[tuple[str, float | str], Alone] = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def base(self) -> Scene:
        """The scene that the axes change."""
        return self.scenes.base

    @property
    def lattice(self) -> tuple[int, ...]:
        """Points along each axis."""
        return (len(self.rows),) if self.rows else tuple(len(axis.values) for axis in self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Models and the points along each axis."""
        return (len(self.models), *self.lattice)

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def order(self) -> Indices:
        """All points in the order in which they are computed: all models at each point of the lattice."""
        return np.arange(self.size).reshape(len(self.models), -1).T.reshape(-1)

    def model(self, point: int) -> str:
        """The model of a point."""
        return self.models[point // math.prod(self.lattice)]

    def changes(self, point: int) -> dict[str, float | str]:
        """The keys of the scene that a point sets."""
        index = np.unravel_index(point % math.prod(self.lattice), self.lattice)
        if self.rows:
            return {self.scenes.key_of(key): value for key, value in self.rows[int(index[0])].items()}
        return {axis.name: axis.written(axis.values[int(number)]) for axis, number in zip(self.axes, index, strict=True)}

    def scene(self, point: int) -> Scene:
        """The scene of a point. Raises SceneError if its values are out of range.

        Where no two keys touch the same field of a scene, scenes with one changed key are put together field by field: each is
        read and checked once, not once a point."""
        changes = self.changes(point)
        alone = [] if self.rows or self.scenes.sets else [self._alone(key, value) for key, value in changes.items()]
        if len(alone) == 1:
            return alone[0][1]
        merged = {name: value for differing, _ in alone for name, value in differing.items()}
        touched = [_touched(axis) | differing.keys() for axis, (differing, _) in zip(self.axes, alone, strict=bool(alone))]
        if not alone or len(set().union(*touched)) < sum(map(len, touched)):
            return self.scenes.scene(changes)
        written = (
            apply_overrides(tables_of(self.base)[1], changes) if all(scene.tables is not None for _, scene in alone) else None
        )
        return replace(self.base, **merged, written=written)

    def _alone(self, key: str, value: float | str) -> Alone:
        if (key, value) not in self._known:
            scene = self.scenes.scene({key: value})
            now, before = vars(scene), vars(self.base)
            differ = {
                field.name: now[field.name] for field in fields(Scene) if field.init and now[field.name] != before[field.name]
            }
            self._known[key, value] = differ, scene
        return self._known[key, value]

    @property
    def laws(self) -> set[str]:
        """Names of its laws, and other words that it gives."""
        given = chain(*(axis.values for axis in self.axes), *(row.values() for row in self.rows), self.scenes.sets.values())
        return {name_of(self.base.law), *(value for value in given if isinstance(value, str))}

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """All that determines the result except the program, for `manifest.json`."""
        return {
            "scene": self.base.name,
            "scene_digest": self.base.digest,
            "axes": [{"key": axis.name, "unit": axis.unit, "values": list(axis.values)} for axis in self.axes],
            "set": dict(self.scenes.sets),
            "rows": [dict(row) for row in self.rows],
            "models": list(self.models),
            "measure": self.measure,
            "options": dict(self.options),
        }


def require_plan(plan: Plan) -> None:
    """Raises SceneError for a plan without points or with too many, with a key twice, for an expression that is none, for words
    and ends of axes over keys that the scene refuses, and for axes that cannot be halved as often as it is to be refined."""
    if not plan.models or bool(plan.axes) == bool(plan.rows):
        raise SceneError("--vary: missing; must be KEY=FROM:TO:COUNT, as in log10_r=-2.75:-2.2:200")
    if plan.size > MOST:
        raise SceneError(f"--vary: {plan.size} points; must be at most 1e8; divide the sweep, or --refine")
    stated = [axis.quantity for axis in plan.axes]
    if twice := [axis.name for axis in plan.axes if stated.count(axis.quantity) > 1]:
        raise SceneError(f"--vary: {twice[0]} is given twice" + ("" if len({*twice}) == 1 else f", also as {twice[-1]}"))
    for name in (axis.name for axis in plan.axes if "." not in axis.name):
        if name not in plan.scenes.variables and name not in PARAMETERS:
            raise SceneError(f"--vary {name}: is neither a key of the scene nor a variable that a --set names")
        if name in measure_of(plan.measure).columns:
            raise SceneError(f"--vary {name}: a variable must have a name that no figure of --measure {plan.measure} has")
    plan.scenes.require(plan.changes(0))
    scenes = Variation(plan.base) if plan.scenes.variables else plan.scenes
    words = {axis.name: axis.values[0] for axis in plan.axes if axis.is_of_words and scenes is plan.scenes}
    for axis in plan.axes:
        if axis.name in plan.scenes.variables or (axis.is_of_words and axis.name not in words):
            continue
        for value in axis.values if axis.is_of_words else (axis.values[0], axis.values[-1]):
            scenes.scene({**words, axis.name: axis.written(value)})
    if plan.options.get("refine"):
        _require_refinable(plan, int(plan.options["refine"]))


def _require_refinable(plan: Plan, levels: int) -> None:
    if not 1 <= levels <= 20:
        raise SceneError(f"--refine = {levels}: must be a whole number from 1 to 20")
    for axis in plan.axes:
        if axis.is_of_words:
            raise SceneError(f"--refine: {axis.name} has words, between which there is nothing")
        count, step = len(axis.values), 2**levels
        if count < step + 1 or (count - 1) % step:
            near = max(round((count - 1) / step), 1) * step + 1
            raise SceneError(f"--refine = {levels}: {axis.name} must have a multiple of {step} plus 1 values, as {near}")
    if plan.rows:
        raise SceneError("--refine: needs axes, not a list of scenes")
