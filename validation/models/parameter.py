"""What a command varies: one record of a parameter of a scene for the axes of `sweep`, the ranges of `branch` and `curve` and the
free values of `fit`, and the scenes at its values."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, TypeAlias

import slipwave
from reduced.parameters import LABELS, PARAMETERS, held
from slipwave.errors import SceneError
from slipwave.input.assemble import SceneSource, drive_of, moment
from slipwave.input.overrides import SAME_QUANTITY, full_key, kinds_of, label_of, words_of_scenes
from slipwave.input.quantity import KINDS, Quantity, quantity
from slipwave.input.schema import DriveTable, KeyTable, Numbers, Physical, allowed_in, allowed_numbers
from slipwave.input.wording import shorten
from slipwave.scene import Scene
from slipwave.scene.slab import FACES, face_sizes
from validation.models.expression import FUNCTIONS, Undefined, Value, value_at
from validation.models.points import BranchPoint, CurvePoint

SHORT = {
    "slab.log10_r": "log10_r",
    "slab.r": "r",
    "slab.epsilon": "epsilon",
    "drive.velocity": "V",
    "interface.a": "a",
    "interface.b": "b",
}
"""Key of a scene -> short name."""
_KEYS = {short: key for key, short in SHORT.items()}

_TAKEN = {
    "cycle",
    "drift",
    "level",
    "model",
    "parameter",
    "place",
    "point",
    "reason",
    "scene",
    "special",
    "status",
    "type",
    "verdict",
}
"""Columns and dimensions of results, beside those of points of branches."""

Values: TypeAlias = str | tuple[str, float | str, float | str] | Mapping[str, tuple[float | str, float | str]]
"""A parameter with its range: "log10_r=-2.72:-2.30", ("log10_r", -2.72, -2.30) or {"log10_r": (-2.72, -2.30)}."""
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)")
_WORD = re.compile(r"(?<![\w.])[^\W\d]\w*")
_RANGE = re.compile(r"(?P<name>[^=]+)=(?P<first>[^:]+):(?P<last>[^:]+)")


@dataclass(frozen=True)
class Parameter:
    """What is varied: the `name` of a key of a scene with its dots, a short name of `reduced.parameters`, or a variable of the
    user's own; its values are words, or numbers in `unit` (empty: as the scene takes bare numbers)."""

    name: str
    unit: str = ""

    @property
    def column(self) -> str:
        """Its name in datasets: slab_thickness for slab.thickness."""
        return self.name.replace(".", "_")

    @property
    def quantity(self) -> str:
        """What it states, under whatever name: r for slab.r, slab.thickness, slab.log10_r and log10_r."""
        path, dot, last = self.name.rpartition(".")
        name = f"{path}{dot}r" if last in SAME_QUANTITY and path != "interface" else self.name
        short = SHORT.get(name, name)
        return short.removeprefix("log10_") if short in PARAMETERS else short

    def label_in(self, base: Scene | None) -> str:
        """Its label in figures of scenes like `base`, if that is known: title, symbol and unit."""
        name, power = self.name.removeprefix("log10_"), r"$\log_{10}$"
        if name in LABELS:
            return LABELS[name] if name == self.name else f"{power} of the {LABELS[name]}"
        unit = self.unit or (_unit_of_machine(base, self.name) if base else "")
        kind = _table_at(base, self.name.split(".")[:-1]).get("kind", "") if base else ""
        return label_of(self.name, unit, kind).replace("log₁₀", power)  # the report's font has no small figures

    def written(self, value: float | str) -> float | str:
        """A value, a number or a word, as the scene takes it."""
        return f"{value!r} {self.unit}" if self.unit else value


@dataclass(frozen=True)
class Variation:
    """The scenes that differ from `base` in the values of parameters; `fixed`: those of parameters that are not varied.

    `sets`: what is set at every value, by full key: a number or a word, or, if it names one of the `variables`, an expression
    (`validation.models.expression`). Of these, variables that others define come first."""

    base: Scene
    _: KW_ONLY
    sets: Mapping[str, Any] = field(default_factory=dict)
    variables: frozenset[str] = frozenset()
    fixed: Mapping[str, float | str] = field(default_factory=dict)

    def scene(self, values: Mapping[str, float | str]) -> Scene:
        """The scene with these values of parameters, by name. Keys are read; a short name is set in the scene that was read, of
        both slabs by the same factor, in a hundredth of the time. Raises SceneError for a value out of range, naming its key."""
        given = {**values, **self.fixed, **values}  # in the order of `values`
        if {"slab", "machine"} <= (self.base.tables or {}).keys():  # springs follow from the slabs and the stiffness of all
            given = {_KEYS.get(name, name): value for name, value in given.items()}
        keys = {name: value for name, value in given.items() if name not in PARAMETERS and name not in self.variables}
        if self.sets:
            keys = {key: value for key, value in (keys | self._set(given)).items() if _is_in(key, given)}
        scene = slipwave.read(self.base, keys) if keys else self.base
        read, tables = scene, scene.tables or {}
        for name in [name for name in given if name in PARAMETERS]:
            value = given[name]
            if isinstance(value, str):
                raise SceneError(f"{name} = {value}: must be a number without a unit")
            if name in ("r", "epsilon", "ratio_r", "ratio_epsilon") and not value > 0.0:
                raise SceneError(f"{name} = {value:g}: must be above 0")
            scene = PARAMETERS[name](scene, value)
        scene = held(scene, read)
        return scene if scene.transit == read.transit else _with_times_of(tables, scene)

    def at(self, varied: Iterable[Parameter], values: Iterable[float | str]) -> Scene:
        """The scene with these values of what is `varied`."""
        return self.scene({parameter.name: parameter.written(value) for parameter, value in zip(varied, values, strict=True)})

    def _set(self, given: Mapping[str, float | str]) -> dict[str, Any]:
        """The keys of `sets` with their values. Raises Undefined for an expression without a value."""
        known = {name: _number_of_variable(name, value) for name, value in given.items() if name in self.variables}
        keys = dict[str, Any]()
        for key, text in self.sets.items():
            if key not in self.variables and not is_expression(text, self.variables):
                keys[key] = text
                continue
            try:
                number, unit = value_at(str(text), known)
            except Undefined as error:
                where = ", ".join(f"{name} = {number:g}" for name, (number, _) in known.items())
                raise Undefined(f"{key} = {shorten(text)}: {error} at {where}") from None
            except SceneError as error:
                raise SceneError(f"{key} = {shorten(text)}: {error}") from None
            if key in self.variables:
                known[key] = number, unit
            else:
                keys[key] = Parameter(key, unit).written(number)
        return keys

    def require(self, values: Mapping[str, float | str]) -> None:
        """Raises SceneError for an expression that is none, whatever the values, and for one of an unknown key."""
        with suppress(Undefined):
            self._set({**values, **self.fixed})
        for key in self.sets.keys() - self.variables:
            *table, last = key.split(".")
            if not any(last in kind.model_fields for kind in kinds_of(table).values()):
                slipwave.read(self.base, {key: self.sets[key]})
                raise SceneError(f"--set {key}: is no key of a scene")

    @property
    def facts(self) -> dict[str, Any]:
        """What is set, if anything, for files."""
        return {"set": dict(self.sets)} if self.sets else {}

    @property
    def lines(self) -> list[str]:
        """Lines on what is set."""
        return [f"set {key} = {value}" for key, value in self.sets.items()]

    def key_of(self, name: str) -> str:
        """The full key of the scene that ends in `name`; `name` itself if there is none."""
        if name not in self._keys:
            is_short = name in PARAMETERS and not _has_key(self.base, name, name)
            self._keys[name] = name if is_short else ".".join(full_key(name.split("."), "", self.base.tables or {}))
        return self._keys[name]

    @cached_property
    def _keys(self) -> dict[str, str]:
        """Full keys that were looked up; not shared by equal scenes, whose tables may differ."""
        return {}


@dataclass(frozen=True)
class ParameterRange(Parameter):
    """A parameter between `first` and `last`."""

    first: float = field(kw_only=True)
    last: float = field(kw_only=True)
    scenes: Variation = field(kw_only=True)

    @property
    def text(self) -> str:
        """As the text of `--over`."""
        return f"{self.name}={self.written(self.first)}:{self.written(self.last)}"

    @property
    def base(self) -> Scene:
        """The scene in which it is varied."""
        return self.scenes.base

    @property
    def label(self) -> str:
        """Its label in figures."""
        return self.label_in(self.base)

    @property
    def si_unit(self) -> str:
        """The unit of its values; empty for a pure number."""
        if self.unit or self.name in PARAMETERS:
            return self.unit
        *path, last = self.name.split(".")
        fields = (table.model_fields.get(last) for table in kinds_of(path).values())
        physical = (kind.units[0] for field in fields if field for kind in allowed_in(field) if isinstance(kind, Physical))
        return next(physical, "") or (_unit_of_machine(self.base, self.name) if self.base.units else "")

    def scene_at(self, value: float) -> Scene:
        """The scene with this value of the parameter."""
        return self.scenes.at([self], [value])

    def written_at(self, value: float) -> Scene:
        """As `scene_at`, with tables if the parameter is one of the scene's keys."""
        with suppress(SceneError):
            return self.scenes.scene({_KEYS.get(self.name, self.name): value})
        return self.scene_at(value)

    def beside(self, other: "ParameterRange", value: float) -> "ParameterRange":
        """The same in scenes with this `value` of another parameter."""
        if not self.scenes.sets and (base := other.written_at(value)).tables is not None:  # a file can hold it
            return replace(self, scenes=replace(self.scenes, base=base))
        fixed = {**self.scenes.fixed, other.name: other.written(value)}
        return replace(self, scenes=replace(self.scenes, fixed=fixed))

    @property
    def ends(self) -> tuple[float, float]:
        """The smaller and the larger end."""
        return min(self.first, self.last), max(self.first, self.last)

    @property
    def sign(self) -> float:
        """That of the direction from `first` to `last`."""
        return math.copysign(1.0, self.last - self.first)

    def nearest_end(self, value: float) -> float:
        """The end nearest to `value`."""
        return min(self.ends, key=lambda end: abs(end - value))

    def holds(self, value: float) -> bool:
        """Whether `value` lies in the range."""
        return self.beyond(value) <= 0.0

    def beyond(self, value: float) -> float:
        """How far `value` lies outside the range, in its length; inside, minus the distance from the nearer end."""
        low, high = self.ends
        return max(low - value, value - high) / (high - low)


def is_expression(text: object, variables: Iterable[str]) -> bool:
    """Whether the value of a `--set` names one of the `variables`, and is no text, list or table."""
    return isinstance(text, str) and text.strip()[:1] not in ("[", "{", '"', "'") and not _words(text).isdisjoint(variables)


@lru_cache(maxsize=256)
def _words(text: str) -> frozenset[str]:
    """The words of a text."""
    return frozenset(_WORD.findall(text))


def variables_of(varied: Sequence[str], pairs: Sequence[tuple[str, Any]]) -> frozenset[str]:
    """The user's own variables in a command: what is `varied`, and what is set though it is no key, of `pairs` of key and value,
    if a value names it. Raises SceneError for one with another meaning, and for one that is set though varied."""
    names, keys = {name for name in varied if name.isidentifier()}, {key for key, _ in pairs}
    taken = words_of_scenes() | PARAMETERS.keys() | FUNCTIONS.keys() | _TAKEN | {*BranchPoint._fields, *CurvePoint._fields}
    variables = {
        name
        for name in names | {key for key in keys - taken if varied and key.isidentifier()}
        if any(is_expression(text, [name]) for key, text in pairs if key.rpartition(".")[2] not in ("kind", "law"))
    }
    for name in variables & taken:
        must = "must have a name that no key, parameter, law or kind of a scene, function or figure of a result has"
        raise SceneError(f"{name}: a variable {must}")
    for name in variables & names & keys:
        raise SceneError(f"--set {name}: is varied, and must not be set too")
    return frozenset(variables)


def scenes_with(base: Scene, varied: Sequence[str], sets: Mapping[str, Any]) -> Variation:
    """The scenes over what is `varied` with these `sets`, by full key or variable. Raises SceneError as `variables_of`, and if
    variables define each other."""
    variables = variables_of(varied, [*sets.items()])
    return Variation(base, sets=_in_order(sets, variables), variables=variables)


def _in_order(sets: Mapping[str, Any], variables: frozenset[str]) -> dict[str, Any]:
    """`sets` with the variables among them first, each after those that define it."""
    left, ordered = {key: text for key, text in sets.items() if key in variables}, dict[str, Any]()
    while left:
        ready = {key: text for key, text in left.items() if not is_expression(text, left)}
        if not ready:
            raise SceneError(f"--set {', '.join(left)}: defined by themselves, in a circle")
        ordered |= ready
        left = {key: text for key, text in left.items() if key not in ready}
    return {**ordered, **sets}


def _is_in(key: str, given: Mapping[str, float | str]) -> bool:
    """Whether a table of the given kind or law has the key."""
    table, _, last = key.rpartition(".")
    word = given.get(f"{table}.kind", given.get(f"{table}.law"))
    kind = kinds_of(table.split(".")).get(str(word)) if word is not None else None
    return kind is None or last in kind.model_fields


def _number_of_variable(name: str, given: float | str) -> Value:
    try:
        return measured_value(given)
    except ValueError:
        raise SceneError(f"{name} = {shorten(given)}: must be a number, with a unit of a scene or none") from None


def measured_value(given: float | str) -> Value:
    """A number, or a number with a unit, in SI. Raises ValueError for another text."""
    number, unit = number_of(given) if isinstance(given, str) else (float(given), "")
    if math.isnan(number):
        raise ValueError
    if not unit:
        return number, ""
    measured = quantity(str(given), *KINDS)
    return measured.value, measured.unit


def number_in(table: KeyTable, key: str, value: float | Quantity, base: Scene) -> tuple[float, str, str]:
    """The number of a `key` of the scene with this `value` in a checked table, the unit that it is written with (none for a bare
    number), and the unit that it is in, if that is one of SI."""
    if isinstance(value, Quantity):
        return value.value, value.unit, value.unit
    allowed = allowed_numbers(table, key.rpartition(".")[2])
    machine = _unit_of_machine(base, key) if base.units else ""
    return float(value), "", allowed.units[0] if isinstance(allowed, Physical) else machine


def range_text(values: Values | None) -> str | None:
    """The parameter and its range as the text of `--over`."""
    if values is None or isinstance(values, str):
        return values
    ranges = [(name, *ends) for name, ends in values.items()] if isinstance(values, Mapping) else [values]
    return ",".join(f"{name}={first}:{last}" for name, first, last in ranges)


def names_of(*ranges: Values | None) -> tuple[str, ...]:
    """The names of parameters with ranges."""
    return tuple(text.partition("=")[0].strip() for text in map(range_text, ranges) if text)


def over_range(text: str, source: "SceneSource | Variation", option: str = "--over") -> ParameterRange:
    """The parameter of `--over KEY=FROM:TO`, or of another `option`, for a scene, or for scenes with variables.

    Raises SceneError if the text has another form, and if the scene cannot be read at one of the ends.
    """
    return over_ranges({option: text}, source)[0]


def over_ranges(texts: Mapping[str, str], source: "SceneSource | Variation") -> list[ParameterRange]:
    """As `over_range` for several options: each varies with the variables among the others at their first ends."""
    scenes = source if isinstance(source, Variation) else Variation(slipwave.read(source))
    if not scenes.base.drive.is_constant:
        raise SceneError(f"scene {scenes.base.name!r}: a branch of periodic orbits needs a constant drive.velocity")
    ranges = [_range(text, scenes, option) for option, text in texts.items()]
    first = {over.name: over.written(over.first) for over in ranges if over.name in scenes.variables}
    checked = []
    for given in ranges:
        fixed = {**scenes.fixed, **{name: value for name, value in first.items() if name != given.name}}
        over = replace(given, scenes=replace(scenes, fixed=fixed))
        over.scenes.require({given.name: given.written(given.first)})
        key = _KEYS.get(given.name, "")
        for value in over.ends:
            if key and _has_key(over.base, key, over.name):  # so that an error names the key
                slipwave.read(over.base, {key: value})
            over.scene_at(value)
        checked.append(over)
    return checked


def _range(text: str, scenes: Variation, option: str) -> ParameterRange:
    """The range, whose ends may be no values of the scene."""

    def require(holds: object, reason: str) -> None:
        """Raises SceneError with the `reason` unless it holds."""
        if not holds:
            raise SceneError(f"{option} {shorten(text)}: {reason}")

    match = _RANGE.fullmatch(text)
    require(match, "must be KEY=FROM:TO, as in log10_r=-2.72:-2.30")
    assert match is not None
    key, words = match["name"].strip(), (match["first"], match["last"])
    name = SHORT.get(key, key)
    ends = [number_of(word) for word in words]
    wrong = next((word for word, (value, _) in zip(words, ends, strict=True) if not math.isfinite(value)), None)
    require(wrong is None, f"{shorten(wrong)} must be a number")
    require(bool(ends[0][1]) is bool(ends[1][1]), "FROM and TO must both have a unit, or none")
    if ends[0][1]:
        ends = [_measured(name, key, scenes, word.strip()) for word in words]
        require(ends[0][1] == ends[1][1], "FROM and TO must have units of one kind")
    (first, unit), (last, _) = ends
    require(first != last, "FROM and TO must differ")
    require(name.partition(".")[0] not in ("start", "run"), "changes a run, and no orbit of its scene")
    require(
        name in PARAMETERS or name in scenes.variables or "." in name,
        f"{shorten(name)} is no parameter; must be one of {', '.join(PARAMETERS)}, a key of the scene with its dots, as "
        "upper.epsilon or slab.face.stiffness, or a variable that a --set names",
    )
    return ParameterRange(name, unit, first=first, last=last, scenes=scenes)


def number_of(text: str) -> tuple[float, str]:
    """A number and what follows it, its unit; NaN for another text."""
    match = _NUMBER.fullmatch(text)
    return (float(match[1]), match[2].strip()) if match else (math.nan, "")


def _measured(name: str, key: str, scenes: Variation, text: str) -> tuple[float, str]:
    """Value and SI unit of a parameter given with a unit; for a short name the number in the scene's own units."""
    if name in PARAMETERS:
        return _present(name, slipwave.read(scenes.base, {key: text})), ""
    if name not in scenes.variables:
        slipwave.read(scenes.base, {key: text})
    return _number_of_variable(name, text)


def _with_times_of(tables: Mapping[str, Any], scene: Scene) -> Scene:
    """The scene with the times of its tables, read again: other transits are as many seconds as before."""
    until, drive = tables.get("run", {}).get("until"), tables.get("drive")
    if until is not None:
        scene = replace(scene, until=moment("run.until", until, scene))
    if drive is None or scene.drive.is_constant:
        return scene
    return replace(scene, drive=drive_of(DriveTable.model_validate(drive), scene.units, scene.transit))


def _unit_of_machine(base: Scene, key: str) -> str:
    """The unit of bare numbers at the `key` of a machine, in SI, of the whole one if it has an area, or of a user's own kind of
    face with numbers of its own (`Face.is_own`); empty for any other key."""
    if key == "machine.k":
        return "1/m" if base.units else "1/L"
    *path, last = key.split(".")
    table = _table_at(base, path)
    kind = FACES.get(table.get("kind", ""))
    if base.units is None or kind is None or not kind.is_own or last not in face_sizes(1.0, 1.0):
        return ""
    field = kinds_of(path)[table["kind"]].model_fields.get(last)
    allowed = next((kind for kind in allowed_in(field) if isinstance(kind, Numbers)), None) if field else None
    return allowed.units[-1 if "area" in table else 0] if allowed and allowed.units else ""


def _table_at(base: Scene, path: Iterable[str]) -> Mapping[str, Any]:
    """The table of the scene at a `path`; empty if none stands there, or in a list."""
    table: Any = base.tables or {}
    for part in path:
        table = table.get(part, {}) if isinstance(table, Mapping) else {}
    return table if isinstance(table, Mapping) else {}


def _has_key(base: Scene, key: str, name: str) -> bool:
    """Whether the scene has the key of a parameter: whether it can be read again with its present value."""
    with suppress(SceneError):
        slipwave.read(base, {key: _present(name, base)})
        return True
    return False


def _present(name: str, base: Scene) -> float:
    """The value of a parameter in a scene; 1 for ratios and values relative to a slab."""
    values = {"r": base.transit, "log10_r": math.log10(base.transit), "epsilon": base.upper.epsilon, "V": base.velocity}
    return values[name] if name in values else float(base.law._asdict().get(name, 1.0))
