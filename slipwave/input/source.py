"""The source of a scene: the gallery, a TOML file, a dictionary, or a netCDF file of results, which holds its scene and its call
so that it can be computed again. Data only; nothing is executed.

A scene is also given by the tables that it was read from: written as TOML, or read again with changes.
"""

import copy
import json
import numbers
import re
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import reason_of
from slipwave.friction.own import own_law
from slipwave.input.wording import nearest, one_line, sentence, shorten
from slipwave.scene import Scene

LARGEST_FILE = 1_000_000
"""Bytes; a longer file is not a scene."""

_KEY_PART = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*"""
_DEEP_KEY = re.compile(rf"(?<![\w-]){_KEY_PART}(?:\.[ \t]*{_KEY_PART}){{20}}")
"""A dotted key of more than 20 parts: tomllib needs a time that grows with their square. Keys of a scene have at most four."""

_GALLERY = Path(__file__).resolve().parent.parent / "gallery"


@cache
def gallery_names() -> tuple[str, ...]:
    """Names of the gallery's scenes, sorted."""
    return tuple(sorted(path.stem for path in _GALLERY.glob("*.toml")))


@cache
def _of_gallery(name: str) -> dict[str, Any]:
    """The tables of a scene of the gallery, cached; not to be changed."""
    return _parse(_GALLERY / f"{name}.toml")


def gallery_titles() -> dict[str, str]:
    """Name and one-line title of every scene of the gallery."""
    return {name: str(_of_gallery(name).get("title", "")) for name in gallery_names()}


def is_stored(source: object) -> bool:
    """Whether `source` is the path of a file of results."""
    return isinstance(source, str | Path) and Path(source).suffix == ".nc"


def load_tables(source: str | Path | Mapping[str, Any] | Scene) -> tuple[str, dict[str, Any]]:
    """(default name, raw tables) of a gallery name, the path of a file, a dictionary or a scene (copied).

    Raises SceneError when there is no such scene or the file is not a TOML text under 1 MB with keys of 20 parts at most.
    """
    if isinstance(source, Scene):
        return tables_of(source)
    if isinstance(source, Mapping):
        return "scene", copy.deepcopy(dict(source))
    if not isinstance(source, str | Path):
        raise SceneError(f"SCENE = {shorten(source)}: must be a gallery name, the path of a TOML file, or a dictionary")
    if isinstance(source, str) and source in gallery_names():
        return source, copy.deepcopy(_of_gallery(source))
    return one_line(Path(source).stem), read_stored(source).tables if is_stored(source) else _parse(Path(source))


def parse_toml(text: str) -> dict[str, Any]:
    """Tables of a TOML text. Raises ValueError if the text is not TOML, RecursionError if it is nested too deeply for a scene."""
    if _DEEP_KEY.search(text):
        raise RecursionError
    return tomllib.loads(text)


def _parse(path: Path) -> dict[str, Any]:
    """The tables of a TOML file. Raises SceneError if it cannot be read, whatever the reason."""
    try:
        return parse_toml(_content(path).decode("utf-8-sig").replace("\r\n", "\n"))
    except SceneError:
        raise
    except UnicodeDecodeError as error:
        reason = f"must be a TOML file in UTF-8; byte {error.start} is not"
    except RecursionError:
        reason = "nested too deeply to be a scene file"
    except OSError as error:
        reason = f"cannot be read: {error.strerror or error}"
    except ValueError as error:  # TOMLDecodeError, and integers with too many digits
        reason = f"must be a TOML file; {sentence(str(error))}"
    raise SceneError(f"SCENE = {shorten(str(path))}: {reason}")


def _content(path: Path) -> bytes:
    """The bytes of a file. Raises SceneError if there is no such file or it is too long, OSError if it cannot be read."""
    try:
        if not path.is_file():
            raise SceneError(f"SCENE = {shorten(str(path))}: {_why_not_a_file(path)}")
    except ValueError as error:
        if isinstance(error, SceneError):
            raise
        # the path holds a character that none may have
        raise SceneError(f"SCENE = {shorten(str(path))}: cannot be read: {error}") from None
    with path.open("rb") as stream:
        content = stream.read(LARGEST_FILE + 1)
    if len(content) > LARGEST_FILE:
        problem = f"longer than {LARGEST_FILE // 1_000_000} MB; a scene file is a short TOML text"
        raise SceneError(f"SCENE = {shorten(str(path))}: {problem}")
    return content


def _why_not_a_file(path: Path) -> str:
    if path.exists():
        return f"must be a TOML file or a gallery name; this is {'a folder' if path.is_dir() else 'not a regular file'}"
    what, known = f"neither a file nor one of the gallery: {', '.join(gallery_names())}", list(gallery_names())
    if path.suffix or len(path.parts) > 1:
        what, known = "no such file", [str(other) for other in path.parent.glob("*.toml")]
    guess = path.stem if path.stem in gallery_names() else nearest(str(path), known)
    return f'{what}; did you mean "{guess}"?' if guess else what


def tables_of(scene: Scene) -> tuple[str, dict[str, Any]]:
    """(name, tables) of a scene. Raises SceneError if it was not read: `dataclasses.replace` drops the tables."""
    if scene.tables is None:
        raise SceneError(f"scene {scene.name!r}: was made in Python, not read, so its keys cannot be changed or written")
    return scene.name, copy.deepcopy(dict(scene.tables))


def to_toml(scene: Scene) -> str:
    """The scene as TOML: reading it gives the same scene. Raises SceneError for a scene that was not read, and for values that
    TOML does not have."""
    import tomli_w

    name, tables = tables_of(scene)
    try:
        return tomli_w.dumps(_plain(tables))
    except TypeError as error:
        raise SceneError(f"scene {name!r}: cannot be written as TOML: {error}") from None


def _plain(value: Any) -> Any:
    """`value` with numbers and lists of other libraries replaced by those of Python."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, bool | int | str):
        return value
    return float(value) if isinstance(value, numbers.Real) else value


GRID_OPTIONS = ("cells", "cfl", "time")
"""Options of a call that belong to the grid of one model."""


class StoredScene(NamedTuple):
    """Origin of a file of results: the `command` that wrote it, the scene's `tables`, the model and the options of the call, and
    all its global attributes."""

    command: str
    tables: dict[str, Any]
    model: str
    options: dict[str, Any]
    facts: dict[str, Any]


def read_stored(path: str | Path, option: str = "SCENE =") -> StoredScene:
    """Read the origin of a file of results. Raises SceneError, naming the `option`, if it is none of this program, and if its
    friction law is a user's own that is not loaded or has changed."""
    label = f"{option} {shorten(str(path))}"
    require("files", label)
    from netCDF4 import Dataset

    if not Path(path).is_file():
        raise SceneError(f"{label}: no such file")
    try:
        with Dataset(path) as file:
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
    return StoredScene(facts["command"], tables, facts["model"], options, facts)


def recall(source: object, command: str, model: str, given: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """(model, options) of a call on a file of results of the same `command`: those `given`, else (model "auto", option None)
    those in the file. Grid options apply to the file's own model only. Raises SceneError for a file of another command."""
    stored = read_stored(Path(str(source)))
    if stored.command != command:
        raise SceneError(f"SCENE = {shorten(str(source))}: is a result of slipwave {stored.command}, not of slipwave {command}")
    known = {name: value for name, value in stored.options.items() if model in ("auto", stored.model) or name not in GRID_OPTIONS}
    options = {name: known.get(name) if value is None else value for name, value in given.items()}
    return (stored.model if model == "auto" else model), options


def _require_law(label: str, facts: Mapping[str, Any], law: str) -> None:
    own, digest = own_law(law), facts["law_digest"]
    if own is None:
        file = facts.get("law_file", "")
        raise SceneError(f"{label}: needs the friction law {law!r} of the file {file} (digest {digest}): give --law FILE.py")
    if own.digest != digest:
        raise SceneError(
            f"{label}: was computed with another friction law {law!r}: digest {digest}; that of {str(own.path)!r} is {own.digest}"
        )
