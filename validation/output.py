"""Results on their way out: tables and JSON on stdout, and whether a file can be written."""

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scene.errors import SceneError


def print_json(result: Any) -> None:
    """`result` as JSON on stdout; NaN and infinity, which JSON does not know, become null."""
    print(json.dumps(_finite(result), indent=2, allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def print_table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Aligned columns: the first to the left, the others to the right."""
    widths = [max(len(row[column]) for row in [heading, *rows]) for column in range(len(heading))]
    for row in [heading, *rows]:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        print("  ".join(cells).rstrip())


def figures(value: float | None, digits: int = 9) -> str:
    """A number for a table; a dash where there is none."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}g}"


def require_folder(folder: Path, option: str = "--out") -> None:
    """Make sure, before anything is computed, that `folder` exists (its last part is made) and can be written."""
    try:
        folder.mkdir(exist_ok=True)
    except (OSError, ValueError) as error:
        raise SceneError(f"{option} = {str(folder)!r}: cannot be used: {_reason(error)}") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise SceneError(f"{option} = {str(folder)!r}: this folder cannot be written")


def require_writable(path: Path, suffixes: tuple[str, ...], option: str = "--out") -> None:
    """Make sure, before anything is computed, that `path` can become a file of one of these kinds."""
    try:
        problem = _problem(path, suffixes)
    except (OSError, ValueError) as error:
        problem = _reason(error)
    if problem:
        raise SceneError(f"{option} = {str(path)!r}: {problem}")


def _problem(path: Path, suffixes: tuple[str, ...]) -> str:
    if path.suffix not in suffixes:
        return f"the name must end in {' or '.join(suffixes)}"
    if path.is_dir():
        return "is a folder; must be a file"
    if not path.parent.is_dir():
        return f"the folder {str(path.parent)!r} does not exist"
    if not os.access(path.parent, os.W_OK | os.X_OK):
        return f"the folder {str(path.parent)!r} cannot be written"
    return ""


def _reason(error: Exception) -> str:
    return str(getattr(error, "strerror", None) or error).lower()
