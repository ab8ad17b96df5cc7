"""What is simulated: friction laws, slabs, drive, start and observers. Knows no solver and imports none of the other rooms."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scene.scene import Scene


def read(source: "str | Path | Mapping[str, Any]", overrides: "Iterable[str] | Mapping[str, Any]" = ()) -> "Scene":
    """The `Scene` named by a gallery name, a TOML file or a dictionary of the same shape, with single keys overridden.

    `overrides` is a list of "key=value" (dotted key, TOML value) or a dictionary {"slab.log10_r": -2.3}. Reading runs no code.
    Raises SceneError: one line naming key, value and allowed range. See `scene.input` for how keys combine.
    """
    from scene.input import read as read_scene  # numba and pydantic load only now: `import scene` stays light

    return read_scene(source, overrides)


__all__ = ["read"]
