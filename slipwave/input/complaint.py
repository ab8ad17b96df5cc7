"""One line about the first fault that pydantic finds in a scene's tables."""

import re
from typing import NamedTuple

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from slipwave.input.schema import KeyTable, SceneTable, allowed_in, scene_keys, tables_in
from slipwave.input.wording import choices, key_text, nearest, shorten

_UNKNOWN = ("extra_forbidden", "invalid_key")


def complaint(failure: ValidationError) -> str:
    """The line for the first faulty key: its dotted name, its value and what is allowed there."""
    # a misspelt key makes one key unknown and another missing: the unknown key comes first, because it explains both; parameters
    # of a law come last
    faults = failure.errors(include_url=False)
    fault = min(faults, key=lambda fault: ("interface" in fault["loc"][:-1], fault["type"] not in _UNKNOWN))
    at = _located(fault["loc"])
    key, value = key_text(at.path), shorten(fault["input"])
    match fault["type"]:
        case "extra_forbidden" | "invalid_key":
            return f"{key} = {value}: unknown key; {_suggestion(at)}"
        case "missing":
            return f"{key}: missing; {_wanted(fault, at)}"
        case "range":
            name, number = f"log10_{at.path[-1]}", fault["input"]
            negative = isinstance(number, int | float) and number <= 0.0
            told = f"; its logarithm is {key_text([*at.path[:-1], name])}" if name in at.table.model_fields and negative else ""
            return f"{key} = {value}: {fault['msg']}{told}"
        case "union_tag_invalid" | "union_tag_not_found":
            word = next(iter(next(iter(at.below.values())).model_fields))
            given = fault["input"].get(word) if isinstance(fault["input"], dict) else fault["input"]
            told = ": missing;" if given is None else f" = {shorten(given)}:"
            return f"{key}.{word}{told} must be {choices(at.below, given)}"
    return f"{key} = {value}: {_wanted(fault, at)}"


class _Located(NamedTuple):
    """The `path` of the key at fault as the user wrote it, the `table` that it belongs to, the `kind` of that table if there are
    several `kinds`, and the tables that the key itself may hold, by kind."""

    path: list[str | int]
    table: type[BaseModel]
    kind: str
    kinds: dict[str, type[KeyTable]]
    below: dict[str, type[KeyTable]]


def _located(loc: tuple[str | int, ...]) -> _Located:
    """Locate a fault; pydantic's path has the kind of a table between its keys (slab.face.grip.stiffness)."""
    at = _Located([], KeyTable, "", {}, {"": scene_keys()})
    for part in loc:
        if len(at.below) > 1 and part in at.below:
            kind = str(part)
            at = _Located(at.path, at.below[kind], kind, at.below, {})
            continue
        if isinstance(part, str) and len(at.below) == 1:
            (table,) = at.below.values()
            at = _Located(at.path, table, "", {}, {})
        field = at.table.model_fields.get(str(part))
        below = at.below if isinstance(part, int) else tables_in(field.annotation) if field else {}
        at = at._replace(path=[*at.path, part], below=below)
    return at


def _suggestion(at: _Located) -> str:
    """Names the known key nearest to an unknown one, in another table or in its own; if none is near, lists the table's keys."""
    word, known = str(at.path[-1]), at.table.model_fields
    owner = next((part for part in reversed(at.path[:-1]) if isinstance(part, str)), "")
    others = {
        key: next(iter(tables_in(SceneTable.model_fields[key].annotation).values())) for key in ("slab", "drive", "start", "run")
    }
    elsewhere = {name: key for key, table in others.items() for name in table.model_fields}
    if word in elsewhere and (not at.kind or owner == "interface"):
        return f"did you mean {elsewhere[word]}.{word}?"
    of = next(iter(known))
    owners = [kind for kind, table in at.kinds.items() if word in table.model_fields]
    if owners:
        return f"it belongs to {of} {choices(owners)}, not to {of} {choices([at.kind])}"
    guess = nearest(word, known if owner else [*known, *elsewhere])
    if guess:
        return f"did you mean {guess if guess in known else f'{elsewhere[guess]}.{guess}'}?"
    own = f"{of} {choices([at.kind])}" if at.kind and of == "kind" else (f"[{owner}]" if owner else "a scene")
    return f"{own} takes {', '.join(known)}"


def _wanted(fault: ErrorDetails, at: _Located) -> str:
    """What is allowed at a key, for faults whose own message does not say it."""
    if fault["type"] == "literal_error":
        expected = str(fault["ctx"]["expected"])
        guess = nearest(fault["input"], re.findall(r"'([^']*)'", expected)) if isinstance(fault["input"], str) else None
        return f"must be {expected}" + (f'; did you mean "{guess}"?' if guess else "")
    allowed = next(allowed_in(at.table.model_fields.get(str(at.path[-1]))), None)
    if allowed:
        return f"must be {allowed}"
    if fault["type"] in ("model_type", "dict_type", "model_attributes_type", "missing"):
        return f"must be a table, [{key_text(at.path)}]"
    return f"must be valid: {fault['msg'].lower()}"
