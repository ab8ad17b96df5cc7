"""Results on their way out: tables and JSON on stdout, and whether a file can be written."""

import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.files import reason_of

Row = TypeVar("Row")

FIGURES = (".png", ".pdf", ".svg")
"""Kinds of file that figures are drawn to."""

_EXTRA = dict.fromkeys(FIGURES, "plot") | dict.fromkeys((".nc", ".vtu", ".xdmf"), "files")


def printed(show: Callable[[], None]) -> None:
    """Call `show` and check that its output reached stdout. Raises SceneError if stdout cannot be written (a full disk)."""
    try:
        show()
        sys.stdout.flush()
    except BrokenPipeError:  # the reader has closed the pipe
        return
    except OSError as error:
        raise SceneError(f"the result cannot be written to stdout: {reason_of(error)}") from None


def print_json(result: Mapping[str, Any]) -> None:
    """`result` as JSON on stdout."""
    import json  # imported here to keep start-up fast

    print(json.dumps(result, indent=2, allow_nan=False))


def thinned(rows: Sequence[Row], most: int) -> list[Row]:
    """At most `most` of the rows at equal distances, and the last one."""
    every = max(1, math.ceil(len(rows) / most))
    return [row for n, row in enumerate(rows) if n % every == 0 or n == len(rows) - 1]


def aligned(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Lines of aligned columns: the first to the left, the others to the right."""
    widths = [max(len(row[column]) for row in [heading, *rows]) for column in range(len(heading))]
    for row in [heading, *rows]:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        yield "  ".join(cells).rstrip()


def print_table(heading: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """The same on stdout."""
    print("\n".join(aligned(heading, rows)))


def rounded(value: float | None, digits: int = 9) -> str:
    """A number for a table; a dash where there is none."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}g}"


def require_folder(folder: Path) -> None:
    """Make sure, before anything is computed, that `folder` exists (its last part is made) and can be written."""
    try:
        folder.mkdir(exist_ok=True)
    except (OSError, ValueError) as error:
        raise SceneError(f"--out = {str(folder)!r}: cannot be used: {reason_of(error)}") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise SceneError(f"--out = {str(folder)!r}: this folder cannot be written")


def require_writable(path: Path | None, suffixes: tuple[str, ...], option: str = "--out") -> None:
    """Make sure, before anything is computed, that `path`, if one is given, can become a file of one of these kinds: that it can
    be written, and that the library that writes it is installed."""
    if path is None:
        return
    try:
        problem = _problem(path, suffixes)
    except (OSError, ValueError) as error:
        problem = reason_of(error)
    if problem:
        raise SceneError(f"{option} = {str(path)!r}: {problem}")
    if path.suffix in _EXTRA:
        require(_EXTRA[path.suffix], f"{option} = {str(path)!r}")


def _problem(path: Path, suffixes: tuple[str, ...]) -> str:
    if not str(path).isprintable():
        return "the path has characters that cannot be printed, or is no valid text"
    if path.suffix not in suffixes:
        return f"the name must end in {' or '.join(suffixes)}"
    if path.is_dir():
        return "is a folder; must be a file"
    if path.exists() and not path.is_file():
        return "is no regular file"
    if not path.parent.is_dir():
        return f"the folder {str(path.parent)!r} does not exist"
    if not os.access(path.parent, os.W_OK | os.X_OK):
        return f"the folder {str(path.parent)!r} cannot be written"
    return ""
