"""Reads a scene file into a frozen `Scene`: finds the text, applies overrides, validates every key, converts SI, assembles."""

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from slipwave.scene import Scene

SceneSource: TypeAlias = "str | Path | Mapping[str, Any] | Scene"
"""A gallery name, the path of a TOML file, a dictionary of the same shape, or a scene that was read before."""


def read(source: SceneSource, overrides: Iterable[str] | Mapping[str, Any] = ()) -> "Scene":
    """The `Scene` of a gallery name, a TOML file or a dictionary of the same shape, with single keys overridden.

    `overrides` is a list of "key=value" (dotted key, TOML value) or a dictionary {"slab.log10_r": -2.3}; see
    `slipwave.input.overrides`. A scene that was read before is read again from its tables. Reading runs no code. Raises
    SceneError: one line that names the key, the value and what is allowed.
    """
    # numba and pydantic are imported only here, so that `import slipwave` stays light
    from slipwave.input.assemble import assemble_scene, validate
    from slipwave.input.overrides import apply_overrides
    from slipwave.input.source import load_tables
    from slipwave.scene import Scene

    if isinstance(source, Scene) and not overrides:
        return source
    name, data = load_tables(source)
    data = apply_overrides(data, overrides) if overrides else data
    return assemble_scene(data, validate(data), name)


def read_scene(source: SceneSource, **changes: Any) -> "Scene":
    """`read` with changes as keywords: tables, as slab={"log10_r": -2.6}, or dotted keys, as **{"slab.log10_r": -2.6}."""
    return read(source, dict(_dotted(changes)))


def _dotted(changes: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Every value with its dotted key."""
    for key, value in changes.items():
        if isinstance(value, Mapping):
            yield from _dotted(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


__all__ = ["SceneSource", "read", "read_scene"]
