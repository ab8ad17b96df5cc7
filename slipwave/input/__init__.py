"""Reads a scene file into a frozen `Scene`: finds the text, applies overrides, validates every key, converts SI, assembles."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from slipwave.scene import Scene


def read(source: str | Path | Mapping[str, Any], overrides: Iterable[str] | Mapping[str, Any] = ()) -> "Scene":
    """The `Scene` of a gallery name, a TOML file or a dictionary of the same shape, with single keys overridden.

    `overrides` is a list of "key=value" (dotted key, TOML value) or a dictionary {"slab.log10_r": -2.3}; see
    `slipwave.input.overrides`. Reading runs no code. Raises SceneError: one line that names the key, the value and what is
    allowed.
    """
    # numba and pydantic are imported only here, so that `import slipwave` stays light
    from slipwave.input.assemble import assemble
    from slipwave.input.overrides import apply_overrides
    from slipwave.input.source import load
    from slipwave.input.validate import validate

    name, data = load(source)
    return assemble(validate(apply_overrides(data, overrides)), name)


__all__ = ["read"]
