"""One fault found by pydantic -> one line: dotted key = value: what is allowed there."""

from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from slipwave.input import schema
from slipwave.input.number import Range
from slipwave.input.wording import choices, key_text, nearest, shorten

_KINDS: dict[str, dict[str, type[BaseModel]]] = {
    "face": {"rigid": schema.RigidTable, "grip": schema.GripTable, "reflection": schema.ReflectionTable},
    "viscosity": {"kelvin-voigt": schema.KelvinVoigtTable, "standard-linear": schema.StandardLinearTable},
}
_TABLES: dict[str, type[BaseModel]] = {
    "": schema.SceneTable,
    "slab": schema.SlabTable,
    "upper": schema.SlabTable,
    "lower": schema.SlabTable,
    "layers": schema.LayerTable,
    "drive": schema.DriveTable,
    "start": schema.StartTable,
    "run": schema.RunTable,
}
_TEXTS = {
    "layers": f"a list of 2 to {schema.MAX_LAYERS} tables {{fraction, impedance}}, from the interface outwards",
    "velocity": "a velocity or a list of [time, velocity]",
    "record": 'a list of "events", "interface", "fields"',
    "name": "a text of 1 to 200 printable characters",
    "title": "a text of 1 to 200 printable characters",
    "law": "the name of a friction law",
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
            return f"{key} = {value}: {fault['msg']}"
        case "union_tag_invalid" | "union_tag_not_found":
            kind = fault["input"].get("kind") if isinstance(fault["input"], dict) else fault["input"]
            return f"{key}.kind = {shorten(kind)}: must be {choices(_KINDS[str(place[-1])])}"
    return f"{key} = {value}: {_wanted(fault, place, own)}"


def _without_tags(loc: tuple[str | int, ...]) -> tuple[list[str | int], list[str]]:
    """The key's path as the user wrote it, and the kinds pydantic added (`slab.face.grip.stiffness` is slab.face.stiffness)."""
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
    """Names the known key nearest to an unknown one: in its own table, else anywhere, else lists the table's keys."""
    word, table = str(place[-1]), _table(place)
    elsewhere = {name: key for key in ("slab", "drive", "start", "run") for name in _TABLES[key].model_fields}
    if word in elsewhere and not kinds:
        return f"did you mean {elsewhere[word]}.{word}?"
    guess = nearest(word, fields)
    if guess:
        return f"did you mean {guess}?"
    owners = [kind for kind, model in _KINDS.get(table, {}).items() if word in model.model_fields]
    if owners:
        return f"it belongs to kind {choices(owners)}, not to kind {choices(kinds[:1])}"
    own = f"kind {choices(kinds[:1])}" if kinds else (f"[{table}]" if table else "a scene")
    return f"{own} takes {', '.join(fields)}"


def _wanted(fault: ErrorDetails, place: list[str | int], fields: dict[str, FieldInfo]) -> str:
    """What is allowed at a place, for faults that do not say so themselves."""
    name = str(place[-1])
    if fault["type"] == "literal_error":
        return f"must be {fault['ctx']['expected']}"
    if name in _TEXTS:
        return f"must be {_TEXTS[name]}"
    allowed = _range(fields.get(name))
    if allowed:
        return f"must be {allowed}"
    if fault["type"] in ("model_type", "dict_type", "missing"):
        return f"must be a table, [{key_text(place)}]"
    return f"must be valid: {fault['msg'].lower()}"


def _range(field: FieldInfo | None) -> str:
    """The range that a numeric field states, or nothing."""
    ranges: list[Any] = [getattr(item, "func", None) for item in (field.metadata if field else ())]
    return next((str(found) for found in ranges if isinstance(found, Range)), "")
