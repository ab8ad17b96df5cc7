"""Files that are written whole or not at all, and what all netCDF files have in common."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from slipwave.errors import SceneError

CONVENTIONS = "CF-1.11"
"""The conventions that netCDF files follow; `make cf` checks them."""

TIME = "time"
"""The time coordinate of netCDF files: from the start, in transits. It has no date, so no `standard_name` of CF."""

_LONGEST_STEM = 40
_PROBE = 1 << 20  # bytes; a disk with less room counts as full


def part_of(path: Path, suffix: str) -> Path:
    """A hidden name beside `path`, ending in `suffix`, that no other process uses."""
    return path.with_name(f".{path.stem[:_LONGEST_STEM]}-{os.getpid()}{suffix}")


def reason_of(error: Exception) -> str:
    """What the system says against a file, without the file's name."""
    return str(getattr(error, "strerror", None) or error).lower()


@contextmanager
def whole_or_absent(path: Path) -> Iterator[Path]:
    """Context with a temporary file beside `path` to write to. If the block succeeds, the file is flushed to disk and replaces
    `path`; if not, it is deleted.

    Raises SceneError naming the file if it cannot be written, whatever error a library raises on a full disk. A process killed
    inside the block leaves `path` as it was, and the temporary file beside it. The name of that file holds the process number, so
    two runs never write to the same one.
    """
    temporary = part_of(path, path.suffix)
    try:
        yield temporary
        with temporary.open("rb") as written:
            os.fsync(written.fileno())
        os.replace(temporary, path)
    except Exception as error:
        reason = error if isinstance(error, OSError) else _refusal(temporary)
        if reason is None:
            raise
        raise SceneError(f"{str(path)!r} cannot be written: {reason_of(reason)}") from None
    finally:
        temporary.unlink(missing_ok=True)


def _refusal(path: Path) -> OSError | None:
    """Why no more bytes can be written to `path`; None if they can. On a full disk libraries raise errors of their own kinds."""
    try:
        with path.open("ab") as file:
            file.write(bytes(_PROBE))
    except OSError as error:
        return error
    return None
