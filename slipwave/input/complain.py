"""Turns one fault found by pydantic into one line: dotted key = value: what is allowed there."""

import re
from collections.abc import Iterator
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from slipwave.input import schema
from slipwave.input.number import Range
from slipwave.input.wording import choices, key_text, nearest, shorten


def _tables(hint: Any) -> list[type[BaseModel]]:
    """The tables that a type of the schema names."""
    own = [hint] if isinstance(hint, type) and issubclass(hint, BaseModel) else []
    return own + [table for part in get_args(hint) for table in _tables(part)]


def _held(table: type[BaseModel]) -> dict[str, list[type[BaseModel]]]:
    """Every key at and below `table` that holds tables, with the tables it may hold: one, or several of different kinds."""
    own = {key: tables for key, field in table.model_fields.items() if (tables := _tables(field.annotation))}
    return own | {key: held for tables in own.values() for inner in tables for key, held in _held(inner).items()}


_HELD = {"": [schema.SceneTable]} | _held(schema.SceneTable)
_TABLES = {key: tables[0] for key, tables in _HELD.items() if len(tables) == 1}
_KINDS = {
    key: {get_args(table.model_fields["kind"].annotation)[0]: table for table in tables}
    for key, tables in _HELD.items()
    if len(tables) > 1
}


def complaint(fault: ErrorDetails, above: tuple[str, ...], fields: dict[str, FieldInfo]) -> str:
    """The line for `fault`, found in the table at `above` whose own keys are `fields`."""
    place, tables = _without_tags(above + fault["loc"])
    key, value = key_text(place), shorten(fault["input"])
    own = _fields(place, tables, fields)
    match fault["type"]:
        case "extra_forbidden" | "invalid_key":
            return f"{key} = {value}: unknown key; {_suggestion(place, tables, own)}"
        case "missing":
            return f"{key}: missing; {_wanted(fault, place, own)}"
        case "range" | "ramps":
            return f"{key} = {value}: {fault['msg']}{_logarithm(place, own, fault['input'])}"
        case "union_tag_invalid" | "union_tag_not_found":
            kind = fault["input"].get("kind") if isinstance(fault["input"], dict) else fault["input"]
            return f"{key}.kind = {shorten(kind)}: must be {choices(_KINDS[str(place[-1])], kind)}"
    return f"{key} = {value}: {_wanted(fault, place, own)}"


def _logarithm(place: list[str | int], fields: dict[str, FieldInfo], value: Any) -> str:
    """Names the key of the logarithm if a number that is not positive may be one."""
    name = f"log10_{place[-1]}"
    negative = isinstance(value, int | float) and value <= 0.0
    return f"; its logarithm is {key_text([*place[:-1], name])}" if name in fields and negative else ""


def _without_tags(loc: tuple[str | int, ...]) -> tuple[list[str | int], list[str]]:
    """The key's path as the user wrote it, and the kinds that pydantic inserts (`grip` in slab.face.grip.stiffness)."""
    place: list[str | int] = []
    tables: list[str] = []
    for part in loc:
        if place and part in _KINDS.get(str(place[-1]), ()) and len(tables) == 0:
            tables.append(str(part))
        else:
            place.append(part)
    return place, tables


def _table(place: list[str | int]) -> str:
    """Name of the table that holds the key at `place`; empty at the top."""
    return next((part for part in reversed(place[:-1]) if isinstance(part, str)), "")


def _fields(place: list[str | int], kinds: list[str], fallback: dict[str, FieldInfo]) -> dict[str, FieldInfo]:
    """The known keys of the table that holds the key at `place`."""
    table = _table(place)
    if kinds and table in _KINDS:
        return _KINDS[table][kinds[0]].model_fields
    return _TABLES[table].model_fields if table in _TABLES else fallback


def _suggestion(place: list[str | int], kinds: list[str], fields: dict[str, FieldInfo]) -> str:
    """Names the known key nearest to an unknown one, in another table or in its own; if none is near, lists the table's keys."""
    word, table = str(place[-1]), _table(place)
    elsewhere = {name: key for key in ("slab", "drive", "start", "run") for name in _TABLES[key].model_fields}
    if word in elsewhere and not kinds:
        return f"did you mean {elsewhere[word]}.{word}?"
    guess = nearest(word, fields if table else [*fields, *elsewhere])
    if guess:
        return f"did you mean {guess if guess in fields else f'{elsewhere[guess]}.{guess}'}?"
    owners = [kind for kind, model in _KINDS.get(table, {}).items() if word in model.model_fields]
    if owners:
        return f"it belongs to kind {choices(owners)}, not to kind {choices(kinds[:1])}"
    own = f"kind {choices(kinds[:1])}" if kinds else (f"[{table}]" if table else "a scene")
    return f"{own} takes {', '.join(fields)}"


def _wanted(fault: ErrorDetails, place: list[str | int], fields: dict[str, FieldInfo]) -> str:
    """What is allowed at `place`, for faults whose own message does not say it."""
    name = str(place[-1])
    if fault["type"] == "literal_error":
        expected = str(fault["ctx"]["expected"])
        guess = nearest(fault["input"], re.findall(r"'([^']*)'", expected)) if isinstance(fault["input"], str) else None
        return f"must be {expected}" + (f'; did you mean "{guess}"?' if guess else "")
    allowed = next(_allowed(fields.get(name)), None)
    if allowed:
        return f"must be {allowed}"
    if fault["type"] in ("model_type", "dict_type", "missing"):
        return f"must be a table, [{key_text(place)}]"
    return f"must be valid: {fault['msg'].lower()}"


def _allowed(hint: Any) -> Iterator[Range | str]:
    """What the schema allows for a key, from the metadata of its type or of the type's parts."""
    for item in getattr(hint, "metadata", getattr(hint, "__metadata__", ())):
        stated = getattr(item, "func", item)
        if isinstance(stated, Range | str):
            yield stated
    for part in (hint.annotation,) if isinstance(hint, FieldInfo) else get_args(hint):
        yield from _allowed(part)
