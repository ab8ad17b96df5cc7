"""`key=value` overrides of a scene's raw tables, before validation.

A key may be told by its last words alone (`keys`). `slab.log10_r` also removes `r` and `thickness`, which state the same
quantity. `upper.x` on a scene with one [slab] first gives each slab a table of its own. A new `kind` of face or viscosity first
empties its table.
"""

import copy
import re
from collections.abc import Iterable, Mapping
from typing import Any, cast

from slipwave.errors import SceneError
from slipwave.input.keys import full_key
from slipwave.input.quantity import looks_measured
from slipwave.input.source import parse_toml
from slipwave.input.wording import key_text, shorten

_SIBLINGS = ({"r", "log10_r", "thickness"},)
_BARE_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
_KEY = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+){0,19}")
_FRESH_TABLES = {"face", "viscosity"}


def apply_overrides(data: dict[str, Any], overrides: Iterable[str] | Mapping[str, Any]) -> dict[str, Any]:
    """`data` with every override set, in order, but every `kind` first. Raises SceneError on text that is not `key=value`."""
    if isinstance(overrides, Mapping):
        pairs = [(_key(str(key)), copy.deepcopy(value)) for key, value in overrides.items()]
    else:
        texts = [overrides] if isinstance(overrides, str) or not isinstance(overrides, Iterable) else list(overrides)
        pairs = [_parse(text) for text in texts]
    for key, value in sorted(pairs, key=lambda pair: pair[0][-1] != "kind"):
        _set(data, full_key(key, value, data), value)
    return data


def _key(text: str) -> list[str]:
    key = text.strip()
    if not _KEY.fullmatch(key):
        raise SceneError(f"--set {shorten(text)}: the key must be dotted words, as in slab.log10_r=-2.3")
    return key.split(".")


def _parse(text: str) -> tuple[list[str], Any]:
    key, sign, value = text.partition("=") if isinstance(cast(object, text), str) else ("", "", "")
    if not sign:
        raise SceneError(f"--set {shorten(text)}: must be KEY=VALUE, as in slab.log10_r=-2.3")
    return _key(key), _value(key.strip(), value.strip())


def _value(key: str, text: str) -> Any:
    """A TOML value; a bare word (slip, kelvin-voigt) and a number with a unit (5 MPa) are taken as strings."""
    try:
        parsed = parse_toml(f"value = {text}")
        if set(parsed) == {"value"}:
            return parsed["value"]
    except (ValueError, RecursionError):
        if _BARE_WORD.fullmatch(text) or looks_measured(text):
            return text
    raise SceneError(
        f"{key_text([key])} = {shorten(text)}: must be a TOML value: a number (with a unit or none), a word, or a list"
    )


def _set(data: dict[str, Any], key: list[str], value: Any) -> None:
    _fit_tables(data, key)
    table = data
    for depth, part in enumerate(key[:-1], start=1):
        table = table.setdefault(part, {})
        if not isinstance(table, dict):
            raise SceneError(f"{key_text(key)} = {shorten(value)}: {key_text(key[:depth])} is not a table")
    last = key[-1]
    if last == "kind" and key[-2:-1] and key[-2] in _FRESH_TABLES and table.get("kind") != value:
        table.clear()
    for siblings in _SIBLINGS:
        if last in siblings and len(key) == 2:
            for other in siblings - {last}:
                table.pop(other, None)
    table[last] = value


def _fit_tables(data: dict[str, Any], key: list[str]) -> None:
    """Give a scene with one [slab] an [upper] and a [lower] when one of them is to be changed."""
    if len(key) < 2:
        return
    if key[0] in ("upper", "lower") and "slab" in data and not {"upper", "lower"} & set(data):
        slab = data.pop("slab")
        data["upper"], data["lower"] = slab, copy.deepcopy(slab)
    elif key[0] == "slab" and "slab" not in data and {"upper", "lower"} & set(data):
        rest = ".".join(key[1:])
        raise SceneError(f"{key_text(key)}: this scene's slabs differ; set upper.{rest} or lower.{rest} instead")
