"""A scene as the tables that it was read from: written as TOML, or read again with changes."""

import copy
import numbers
from collections.abc import Mapping
from typing import Any

from slipwave.errors import SceneError
from slipwave.scene import Scene


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
