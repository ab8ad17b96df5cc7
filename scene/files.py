"""Files that are whole or absent."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scene.errors import SceneError

_LONGEST_STEM = 40


@contextmanager
def whole_or_absent(path: Path) -> Iterator[Path]:
    """A name beside `path`, of the same kind, to write to: takes its place, safely on the disk, when the block ends well,
    vanishes when not.

    Raises SceneError naming the file if it cannot be written. A process killed inside the block leaves `path` as it was and the
    hidden part beside it; its process number is in the name, so that two runs never write to the same part.
    """
    temporary = path.with_name(f".{path.stem[:_LONGEST_STEM]}-{os.getpid()}{path.suffix}")
    try:
        yield temporary
        with temporary.open("rb") as written:
            os.fsync(written.fileno())
        os.replace(temporary, path)
    except OSError as error:
        raise SceneError(f"{str(path)!r} cannot be written: {(error.strerror or str(error)).lower()}") from None
    finally:
        temporary.unlink(missing_ok=True)
