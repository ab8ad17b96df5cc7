"""The tables that a scene was read from, kept with it so that it can be written down and read again with changes."""

import copy
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
