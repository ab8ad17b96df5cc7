"""Scene files in, frozen `Scene` out: find the text, apply overrides, validate every key, convert SI, assemble."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from scene.input.assemble import assemble
from scene.input.overrides import apply_overrides
from scene.input.source import load
from scene.input.validate import validate
from scene.scene import Scene


def read(source: str | Path | Mapping[str, Any], overrides: Iterable[str] | Mapping[str, Any] = ()) -> Scene:
    """The `Scene` of a gallery name, a TOML file or a dictionary, with overrides; see `scene.read`.

    Raises SceneError with one line that names the key, the value and the allowed range.
    """
    name, data = load(source)
    return assemble(validate(apply_overrides(data, overrides)), name)


__all__ = ["read"]
