"""The source of a scene: the gallery, a TOML file, or a dictionary. Data only; nothing is executed."""

import copy
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slipwave.errors import SceneError
from slipwave.input.wording import nearest, one_line, sentence, shorten

LARGEST_FILE = 1_000_000
"""Bytes; a longer file is not a scene."""

_KEY_PART = r"""(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*"""
_DEEP_KEY = re.compile(rf"(?<![\w-]){_KEY_PART}(?:\.[ \t]*{_KEY_PART}){{20}}")
"""A dotted key of more than 20 parts: tomllib needs a time that grows with their square. Keys of a scene have at most four."""

_GALLERY = Path(__file__).resolve().parent.parent / "gallery"


def gallery_names() -> list[str]:
    """Names of the gallery's scenes, sorted."""
    return sorted(path.stem for path in _GALLERY.glob("*.toml"))


def gallery_titles() -> dict[str, str]:
    """Name and one-line title of every scene of the gallery."""
    return {name: str(_parse(_GALLERY / f"{name}.toml").get("title", "")) for name in gallery_names()}


def load(source: str | Path | Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """(default name, raw tables) of a gallery name, a TOML file's path, or a dictionary (copied).

    Raises SceneError when there is no such scene or the file is not a TOML text under 1 MB with keys of 20 parts at most.
    """
    if isinstance(source, Mapping):
        return "scene", copy.deepcopy(dict(source))
    if not isinstance(source, str | Path):
        raise SceneError(f"SCENE = {shorten(source)}: must be a gallery name, the path of a TOML file, or a dictionary")
    if isinstance(source, str) and source in gallery_names():
        return source, _parse(_GALLERY / f"{source}.toml")
    path = Path(source)
    return one_line(path.stem), _parse(path)


def parse_toml(text: str) -> dict[str, Any]:
    """Tables of a TOML text. Raises ValueError if the text is not TOML, RecursionError if it is nested too deeply for a scene."""
    if _DEEP_KEY.search(text):
        raise RecursionError
    return tomllib.loads(text)


def _parse(path: Path) -> dict[str, Any]:
    """The tables of a TOML file. Raises SceneError if it cannot be read, whatever the reason."""
    text = _read_text(path)
    try:
        return parse_toml(text)
    except RecursionError:
        raise SceneError(f"SCENE = {shorten(str(path))}: nested too deeply to be a scene file") from None
    except ValueError as error:  # TOMLDecodeError, and integers with too many digits
        raise SceneError(f"SCENE = {shorten(str(path))}: must be a TOML file; {sentence(str(error))}") from None


def _read_text(path: Path) -> str:
    label = shorten(str(path))
    try:
        if not path.is_file():
            raise SceneError(_why_not_a_file(path, label))
        with path.open("rb") as stream:
            content = stream.read(LARGEST_FILE + 1)
    except SceneError:
        raise
    except (OSError, ValueError) as error:  # ValueError: the path holds a character that paths must not have
        reason = getattr(error, "strerror", None) or error
        raise SceneError(f"SCENE = {label}: cannot be read: {reason}") from None
    if len(content) > LARGEST_FILE:
        raise SceneError(f"SCENE = {label}: longer than {LARGEST_FILE // 1_000_000} MB; a scene file is a short TOML text")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise SceneError(f"SCENE = {label}: must be a TOML file in UTF-8; byte {error.start} is not") from None


def _why_not_a_file(path: Path, label: str) -> str:
    if path.exists():
        kind = "a folder" if path.is_dir() else "not a regular file"
        return f"SCENE = {label}: must be a TOML file or a gallery name; this is {kind}"
    what, known = f"neither a file nor one of the gallery: {', '.join(gallery_names())}", gallery_names()
    if path.suffix or len(path.parts) > 1:
        what, known = "no such file", [str(other) for other in path.parent.glob("*.toml")]
    guess = path.stem if path.stem in gallery_names() else nearest(str(path), known)
    hint = f'; did you mean "{guess}"?' if guess else ""
    return f"SCENE = {label}: {what}{hint}"
