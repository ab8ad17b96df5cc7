"""`key=value` overrides of a scene's raw tables, before validation.

A key may be shortened to its last words: `log10_r` is slab.log10_r, `face.stiffness` is slab.face.stiffness. The tables of a list
have numbers: `slab.layers.0.impedance` is that of the layer at the interface. `slab.log10_r` also
removes `r` and `thickness`, which state the same quantity. `upper.x` on a scene with one [slab] first gives each slab a table of
its own. A new `kind` of face or viscosity first empties its table.
"""

import copy
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, cast, get_args

from pydantic import BaseModel

from slipwave.errors import SceneError
from slipwave.input.quantity import looks_measured
from slipwave.input.schema import InterfaceTable, Physical, SceneTable, allowed_in, scene_keys, tables_in
from slipwave.input.wording import key_text, listed, shorten

_SYMBOLS = {"V": "velocity"}
"""Symbol that commands print -> key."""

SAME_QUANTITY = {"r", "log10_r", "thickness"}
"""Keys of a slab that state the same; parameters of a law may have these names too."""

_BARE_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+){0,19}")
_FRESH_TABLES = ("face", "viscosity")


_KEY_PART = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*"""
_DEEP_KEY = re.compile(rf"(?<![\w-]){_KEY_PART}(?:\.[ \t]*{_KEY_PART}){{20}}")
"""A dotted key of more than 20 parts: tomllib needs a time that grows with their square. Keys of a scene have at most four."""


def parse_toml(text: str) -> dict[str, Any]:
    """Tables of a TOML text. Raises ValueError if the text is not TOML, RecursionError if it is nested too deeply for a scene."""
    if _DEEP_KEY.search(text):
        raise RecursionError
    return tomllib.loads(text)


def apply_overrides(data: Mapping[str, Any], overrides: Iterable[str] | Mapping[str, Any]) -> dict[str, Any]:
    """A copy of `data` with every override set, in order, but every `kind` and `law`, on which other keys depend, first; it
    shares the tables that do not change. Raises SceneError on text that is not `key=value`."""
    if isinstance(overrides, Mapping):
        pairs = [(_key(str(key)), copy.deepcopy(value)) for key, value in overrides.items()]
    else:
        texts = [overrides] if isinstance(overrides, str) or not isinstance(overrides, Iterable) else list(overrides)
        pairs = []
        for text in texts:
            name, sign, value = text.partition("=") if isinstance(cast(object, text), str) else ("", "", "")
            if not sign:
                raise SceneError(f"--set {shorten(text)}: must be KEY=VALUE, as in slab.log10_r=-2.3")
            pairs.append((_key(name), toml_value(name.strip(), value.strip())))
    data = dict(data)
    for key, value in sorted(pairs, key=lambda pair: pair[0][-1] not in ("kind", "law")):
        _set(data, full_key(key, value, data), value)
    return data


def full_key(key: Sequence[str], value: Any, data: Mapping[str, Any]) -> list[str]:
    """`key`, or, if its first word is no table of a scene, the only full key of the scene `data` that ends in its words. A key
    without match is returned unchanged. Raises SceneError, with the `value` unless it is empty, if several match.
    """
    keys = endings(key, data)
    if len(keys) > 1:
        given = "" if value == "" else f" = {shorten(value)}"
        raise SceneError(f"{key_text(key)}{given}: give the whole key, {listed(map(key_text, keys))}")
    return list(keys[0] if keys else key)


def endings(key: Sequence[str], data: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """The full keys of the scene `data` that end in the words of `key`, or `key` itself if it begins with a table's name. Keys of
    slabs are of [slab], or of [upper] and [lower]; those of [interface] are of the scene's law."""
    if key[0] in SceneTable.model_fields:
        return [tuple(key)]
    words = (*key[:-1], _SYMBOLS.get(key[-1], key[-1]))
    absent = ("upper", "lower") if "slab" in data or not {"upper", "lower"} & set(data) else ("slab",)
    interface = data.get("interface")
    law = interface.get("law") if isinstance(interface, Mapping) else None
    known = (full for full in _keys(scene_keys(), law) if full[0] not in absent)
    return [full for full in known if full[-len(words) :] in (words, tuple(key))]


def label_of(key: str, unit: str = "", kind: str = "") -> str:
    """Axis label of a `key` with values in `unit` (empty: that of its bare numbers): the title in the table of keys, of the
    `kind`, with symbol and unit; the key itself if it has no title."""
    *path, last = key.split(".")
    first, kinds = (path or [last])[0], kinds_of(path) if path else {}
    tables = [kinds[kind]] if kind in kinds else kinds.values() if path else _below(scene_keys())
    fields = (table.model_fields.get(_SYMBOLS.get(last, last)) for table in tables)
    titled = next((field for field in fields if field and field.title), None)
    words, slash, own = str(titled.title if titled else key).partition(" / ")
    unit = unit or next((kind.units[0] for kind in allowed_in(titled) if isinstance(kind, Physical)) if titled else iter(()), "")
    of_slab = f" of the {first} slab" if first in ("upper", "lower") else ""
    unit = f"1{unit}" if unit.startswith("/") else unit
    shown = (f"({unit})" if {"/", " "} & set(unit) else unit) or own
    return words.replace(" of a slab", "") + of_slab + (f" / {shown}" if slash or unit else "")


def kinds_of(key: Iterable[str]) -> dict[str, type[BaseModel]]:
    """Kind or law -> table, of the tables that a scene may have at `key`, as slab.face; none for a key that is no table."""
    tables: dict[str, type[BaseModel]] = {"": scene_keys()}
    for part in key:
        fields = [table.model_fields[part] for table in tables.values() if part in table.model_fields]
        tables = {kind: table for field in fields for kind, table in tables_in(field.annotation, lists=False).items()}
    return tables


def words_of_scenes() -> frozenset[str]:
    """Every last word of a key, and every word that is a value of one."""
    tables = {*_below(scene_keys())}
    fields = [(name, field) for table in tables for name, field in table.model_fields.items()]
    return frozenset(
        [
            *(name for name, _ in fields),
            *(word for _, field in fields for word in get_args(field.annotation) if isinstance(word, str)),
        ]
    )


def _below(table: type[BaseModel]) -> Iterator[type[BaseModel]]:
    """`table` and all tables in it."""
    yield table
    for field in table.model_fields.values():
        for below in tables_in(field.annotation).values():
            yield from _below(below)


def _keys(table: type[BaseModel], law: Any) -> Iterator[tuple[str, ...]]:
    """The keys of `table` and of the tables in it; several kinds of table may have the same key. Tables in lists are
    left out: they have no keys of their own."""
    for name, field in table.model_fields.items():
        yield (name,)
        tables = [*tables_in(field.annotation, lists=False).items()]
        if name == "interface":
            tables = [named for named in tables if named[0] == law] or [("", InterfaceTable)]
        yield from ((name, *key) for key in dict.fromkeys(key for _, table in tables for key in _keys(table, law)))


def _key(text: str) -> list[str]:
    key = text.strip()
    if not _KEY.fullmatch(key):
        raise SceneError(f"--set {shorten(text)}: the key must be dotted words, as in slab.log10_r=-2.3")
    return key.split(".")


def toml_value(key: str, text: str) -> Any:
    """A TOML value; a bare word (slip, kelvin-voigt) and a number with a unit (5 MPa) are taken as strings."""
    try:
        parsed = parse_toml(f"value = {text}")
        if set(parsed) == {"value"}:
            return parsed["value"]
    except (ValueError, RecursionError):
        if _BARE_WORD.fullmatch(text) or looks_measured(text):
            return text
    raise SceneError(
        f"{key_text([key])} = {shorten(text)}: must be a TOML value: a number (with a unit or none), a word, or a list"
    )


def _set(data: dict[str, Any], key: list[str], value: Any) -> None:
    _fit_tables(data, key)
    table: Any = data
    for depth, part in enumerate(key[:-1], start=1):
        table = _opened(table, part)
        if not isinstance(table, dict if depth == len(key) - 1 else (dict, list)):
            raise SceneError(f"{key_text(key)} = {shorten(value)}: {key_text(key[:depth])} is not a table")
    last = key[-1]
    if last == "kind" and key[-2:-1] and key[-2] in _FRESH_TABLES and table.get("kind") != value:
        table.clear()
    if last in SAME_QUANTITY and len(key) == 2 and key[0] != "interface":
        for other in SAME_QUANTITY - {last}:
            table.pop(other, None)
    table[last] = value


def _opened(table: Any, part: str) -> Any:
    """A copy, put in its place, of what stands at the `part` of a table, or at this number of a list; None if that has none."""
    if isinstance(table, dict):
        table[part] = copy.copy(table.get(part, {}))
        return table[part]
    if part not in map(str, range(len(table))):
        return None
    table[int(part)] = copy.copy(table[int(part)])
    return table[int(part)]


def _fit_tables(data: dict[str, Any], key: list[str]) -> None:
    """Give a scene with one [slab] an [upper] and a [lower] when one of them is to be changed."""
    if len(key) < 2:
        return
    if key[0] in ("upper", "lower") and "slab" in data and not {"upper", "lower"} & set(data):
        data["upper"] = data["lower"] = data.pop("slab")
    elif key[0] == "slab" and "slab" not in data and {"upper", "lower"} & set(data):
        rest = ".".join(key[1:])
        raise SceneError(f"{key_text(key)}: this scene's slabs differ; set upper.{rest} or lower.{rest} instead")
