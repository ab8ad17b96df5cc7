"""The tables that a scene was read from, kept with it so that it can be written as TOML and read again with changes."""

import copy
import numbers
from collections.abc import Mapping
from typing import Any

from slipwave.errors import SceneError
from slipwave.input.validate import Validated
from slipwave.scene import Scene


def keep(scene: Scene, data: dict[str, Any], checked: Validated) -> Scene:
    """`scene` with the tables `data` that it was read from, where the defaults of name, start and run are filled in."""
    written = copy.deepcopy(data)
    tables = {"start": checked.tables.start, "run": checked.tables.run}
    defaults = {key: {name: value for name, value in table if value is not None} for key, table in tables.items()}
    filled = {key: table | written.get(key, {}) for key, table in defaults.items()}
    object.__setattr__(scene, "tables", {"name": scene.name} | written | filled)
    return scene


def tables_of(scene: Scene) -> tuple[str, dict[str, Any]]:
    """(name, tables) of a scene. Raises SceneError for one that was not read: `dataclasses.replace` drops its tables."""
    if scene.tables is None:
        raise SceneError(f"scene {scene.name!r}: was made in Python, not read, so its keys cannot be changed or written")
    return scene.name, copy.deepcopy(dict(scene.tables))


def to_toml(scene: Scene) -> str:
    """The scene as TOML: reading it gives the same scene. Raises SceneError for a scene that was not read, and for values of a
    Python program that TOML does not know."""
    import tomli_w

    name, tables = tables_of(scene)
    try:
        return tomli_w.dumps(_plain(tables))
    except TypeError as error:
        raise SceneError(f"scene {name!r}: cannot be written as TOML: {error}") from None


def _plain(value: Any) -> Any:
    """`value` with the numbers and lists of Python in place of those of other libraries."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, bool | int | str):
        return value
    return float(value) if isinstance(value, numbers.Real) else value
