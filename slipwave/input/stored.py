"""The origin of a netCDF file of results, which holds its scene and its call so that it can be computed again."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import ONE_THREAD, reason_of
from slipwave.friction.own import own_law
from slipwave.input.overrides import parse_toml
from slipwave.input.wording import one_line, shorten


class StoredScene(NamedTuple):
    """Origin of a file of results: the `command` that wrote it, the scene's `tables`, the model and the options of the call, and
    all its global attributes."""

    command: str
    tables: dict[str, Any]
    model: str
    options: dict[str, Any]
    facts: dict[str, Any]


def read_stored(path: str | Path, option: str = "SCENE =", command: str = "") -> StoredScene:
    """Read the origin of a file of results. Raises SceneError, naming the `option`, if it is none of this program, none of the
    `command`, if given, and if its friction law is a user's own that is not loaded or has changed."""
    label = f"{option} {shorten(str(path))}"
    require("files", label)
    from netCDF4 import Dataset

    if not Path(path).is_file():
        raise SceneError(f"{label}: no such file")
    try:
        with ONE_THREAD, Dataset(path) as file:
            facts = {name: file.getncattr(name) for name in file.ncattrs()}
        texts = {name: facts.get(name) for name in ("command", "model", "scene_toml", "options")}
        for name, text in texts.items():
            if not isinstance(text, str):
                raise ValueError(f"its attribute {name} is {'no text' if name in facts else 'missing'}")
        tables, options = parse_toml(facts["scene_toml"]), json.loads(facts["options"])
        if not isinstance(options, dict):
            raise ValueError(f"its attribute options is {shorten(facts['options'])}, no table")
    except (OSError, LookupError, ValueError, TypeError, RuntimeError, AttributeError) as error:  # RuntimeError: of the library
        raise SceneError(f"{label}: holds no scene that can be computed again: {one_line(reason_of(error))}") from None
    if facts.get("law_digest"):
        _require_law(label, facts, str(tables.get("interface", {}).get("law")))
    if command not in ("", facts["command"]):
        raise SceneError(f"{label}: is a result of slipwave {facts['command']}, not of slipwave {command}")
    return StoredScene(facts["command"], tables, facts["model"], options, facts)


def _require_law(label: str, facts: Mapping[str, Any], law: str) -> None:
    own, digest = own_law(law), facts["law_digest"]
    if own is None:
        file = facts.get("law_file", "")
        raise SceneError(f"{label}: needs the friction law {law!r} of the file {file} (digest {digest}): give --law FILE.py")
    if own.digest != digest:
        raise SceneError(
            f"{label}: was computed with another friction law {law!r}: digest {digest}; that of {str(own.path)!r} is {own.digest}"
        )
