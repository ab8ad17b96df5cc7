"""Files that are whole or absent."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from slipwave.errors import SceneError

_LONGEST_STEM = 40
_PROBE = 1 << 20  # bytes: a disk without so much room is full


def part_of(path: Path, suffix: str) -> Path:
    """A hidden name of the kind `suffix` beside `path` that no other process takes."""
    return path.with_name(f".{path.stem[:_LONGEST_STEM]}-{os.getpid()}{suffix}")


@contextmanager
def whole_or_absent(path: Path) -> Iterator[Path]:
    """A name beside `path`, of the same kind, to write to: takes its place, safely on the disk, when the block ends well,
    vanishes when not.

    Raises SceneError naming the file if it cannot be written, whatever a library makes of a full disk. A process killed inside
    the block leaves `path` as it was and the hidden part beside it; its process number is in the name, so that two runs never
    write to the same part.
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
        raise SceneError(f"{str(path)!r} cannot be written: {(reason.strerror or str(reason)).lower()}") from None
    finally:
        temporary.unlink(missing_ok=True)


def _refusal(path: Path) -> OSError | None:
    """Why `path` takes no further bytes, if it does not: libraries fail in their own words where the disk is full."""
    try:
        with path.open("ab") as file:
            file.write(bytes(_PROBE))
    except OSError as error:
        return error
    return None
