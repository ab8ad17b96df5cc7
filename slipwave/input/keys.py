"""The full key that is meant by its last words alone: `log10_r` is slab.log10_r, `face.stiffness` is slab.face.stiffness."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, get_args, get_origin

from pydantic import BaseModel

from slipwave.errors import SceneError
from slipwave.friction import LAWS
from slipwave.input.relate import UNIT_KEYS
from slipwave.input.schema import SceneTable
from slipwave.input.wording import key_text, listed, shorten

_SYMBOLS = {"V": "velocity"}
"""Keys by the symbol that commands print."""


def full_key(key: Sequence[str], value: Any, data: Mapping[str, Any]) -> list[str]:
    """`key`, or, if its first word is no table of a scene, the only full key of the scene `data` that ends in its words.

    A key without any is returned as it is. Raises SceneError for one that several end in: `kind = ...: which of ...?`.
    """
    found = endings(key, data)
    if len(found) > 1:
        raise SceneError(f"{key_text(key)} = {shorten(value)}: give the whole key, {listed(map(key_text, found))}")
    return list(found[0] if found else key)


def endings(key: Sequence[str], data: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """The full keys of the scene `data` that end in the words of `key`; it is one itself if it begins with a table's name."""
    if key[0] in SceneTable.model_fields:
        return [tuple(key)]
    words = (*key[:-1], _SYMBOLS.get(key[-1], key[-1]))
    return [full for full in _keys(data) if full[-len(words) :] in (words, tuple(key))]


def _keys(data: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Every key of the scene with its tables; those of slabs are of [slab], or of [upper] and [lower]."""
    absent = ("upper", "lower") if "slab" in data or not {"upper", "lower"} & set(data) else ("slab",)
    yield from (full for full in _below(SceneTable) if full[0] not in absent)
    interface = data.get("interface")
    law = LAWS.get(interface.get("law")) if isinstance(interface, Mapping) else None  # type: ignore[arg-type]
    yield from (("interface", key) for key in ("law", *(law.parameters._fields if law else ()), *UNIT_KEYS))


def _below(table: type[BaseModel]) -> Iterator[tuple[str, ...]]:
    """The keys of `table` and of the tables in it; several kinds of table may have the same key."""
    for name, field in table.model_fields.items():
        yield (name,)
        inner = dict.fromkeys(key for one in _tables(field.annotation) for key in _below(one))
        yield from ((name, *key) for key in inner)


def _tables(hint: Any) -> list[type[BaseModel]]:
    """The tables that a type of the schema names, those in lists left out: they have no keys of their own."""
    if isinstance(hint, type) and issubclass(hint, BaseModel):
        return [hint]
    return [] if get_origin(hint) is list else [table for part in get_args(hint) for table in _tables(part)]
