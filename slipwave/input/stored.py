"""The scene and the call that a netCDF file of results holds, so that it can be computed again."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import reason_of
from slipwave.input.source import parse_toml
from slipwave.input.wording import one_line, shorten

SUFFIX = ".nc"

GRID_OPTIONS = ("cells", "cfl", "time")
"""Options of a call that belong to the grid of one model."""


class Stored(NamedTuple):
    """What a file says of its origin: the `command` that wrote it, the scene's `tables`, the model and the options of the call,
    and all its global attributes."""

    command: str
    tables: dict[str, Any]
    model: str
    options: dict[str, Any]
    facts: dict[str, Any]


def is_stored(source: object) -> bool:
    """Whether `source` is the path of a file of results."""
    return isinstance(source, str | Path) and Path(source).suffix == SUFFIX


def read_stored(path: str | Path) -> Stored:
    """What the file holds. Raises SceneError if it is no file of this program's results, and if its friction law is one of the
    user's own that is not loaded, or that has changed since."""
    label = f"SCENE = {shorten(str(path))}"
    require("files", label)
    from netCDF4 import Dataset

    if not Path(path).is_file():
        raise SceneError(f"{label}: no such file")
    try:
        with Dataset(path) as file:
            facts = {name: file.getncattr(name) for name in file.ncattrs()}
        texts = {name: _text(facts, name) for name in ("command", "model", "scene_toml", "options")}
        tables, options = parse_toml(texts["scene_toml"]), json.loads(texts["options"])
        if not isinstance(options, dict):
            raise ValueError(f"its attribute options is {shorten(texts['options'])}, no table")
    except (OSError, LookupError, ValueError, TypeError, RuntimeError, AttributeError) as error:  # RuntimeError: of the library
        raise SceneError(f"{label}: holds no scene that can be computed again: {one_line(reason_of(error))}") from None
    _require_law(label, str(facts.get("law_digest", "")), str(facts.get("law_file", "")), tables)
    return Stored(texts["command"], tables, texts["model"], options, facts)


def _text(facts: Mapping[str, Any], name: str) -> str:
    """An attribute that is a text. Raises ValueError if it is missing or no text."""
    if not isinstance(facts.get(name), str):
        raise ValueError(f"its attribute {name} is {'no text' if name in facts else 'missing'}")
    return str(facts[name])


def recall(source: object, command: str, model: str, given: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """(model, options) of a call: what is `given`, and for a file of results of the same `command` what it holds where the model
    is "auto" and an option None. Options of a grid hold for the file's own model only. Raises SceneError for a file of another
    command."""
    if not is_stored(source):
        return model, dict(given)
    stored = read_stored(Path(str(source)))
    if stored.command != command:
        raise SceneError(f"SCENE = {shorten(str(source))}: is a result of slipwave {stored.command}, not of slipwave {command}")
    known = {name: value for name, value in stored.options.items() if model in ("auto", stored.model) or name not in GRID_OPTIONS}
    options = {name: known.get(name) if value is None else value for name, value in given.items()}
    return (stored.model if model == "auto" else model), options


def _require_law(label: str, digest: str, file: str, tables: dict[str, Any]) -> None:
    from slipwave.friction.own import own_law

    if not digest:
        return
    law = str(tables.get("interface", {}).get("law"))
    own = own_law(law)
    if own is None:
        raise SceneError(f"{label}: needs the friction law {law!r} of the file {file} (digest {digest}): give --law FILE.py")
    if own.digest != digest:
        raise SceneError(
            f"{label}: was computed with another friction law {law!r}: digest {digest}; that of {str(own.path)!r} is {own.digest}"
        )
