"""Writes files whole or not at all; conventions of all netCDF files."""

import os
import platform
import re
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path
from threading import RLock

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.packages import log

CONVENTIONS = "CF-1.11"
"""The conventions that netCDF files follow; `make cf` checks them."""

TIME = "time"
"""The time coordinate of netCDF files: from the start, in transits. It has no date, so no `standard_name` of CF."""

FIGURES = (".png", ".pdf", ".svg")
"""Kinds of file that figures are drawn to."""

MOST_BYTES = 10**9
"""Of a file of data; a longer one is refused."""

ONE_THREAD = RLock()
"""Held by the thread that writes a file, draws, or reads a netCDF file. netCDF's library ends a process in which two threads use
it, the style of figures belongs to the whole process, and a process has one name for the parts of files that begin alike."""

_EXTRA = dict.fromkeys(FIGURES, "plot") | dict.fromkeys((".nc", ".vtu", ".xdmf"), "files")

_LONGEST_STEM = 40
_PATIENCE = 10  # seconds for a pipe without a writer
_PROBE = 1 << 20  # bytes; a disk with less space counts as full

_HOST = re.sub(r"\W", "", platform.node())[:_LONGEST_STEM]
_told: set[str] = set()
_PART = re.compile(rf"\..*-{_HOST}-(\d+)\.(nc|png|pdf|svg|npz|csv|vtu|xdmf|h5|samples|html|json|xml|patch)")


def part_of(path: Path, suffix: str) -> Path:
    """A hidden name in the folder of `path`, ending in `suffix`, that no other process uses, even on another machine that shares
    the disk."""
    return path.with_name(f".{path.stem[:_LONGEST_STEM]}-{_HOST}-{os.getpid()}{suffix}")


def remove_leftovers(folder: Path) -> None:
    """Remove the parts of files in `folder` that processes of this machine left when they were killed."""
    with suppress(OSError):
        for path in list(folder.iterdir()):
            part = _PART.fullmatch(path.name)
            if part and not is_running(int(part[1])):
                path.unlink(missing_ok=True)


def is_running(process: int) -> bool:
    """Whether a process of this machine has this number; True where that cannot be asked."""
    try:
        if os.name == "posix":
            os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True


def reason_of(error: Exception) -> str:
    """The system's message about a file, without the file's name."""
    return str(getattr(error, "strerror", None) or error).lower()


@contextmanager
def whole_or_absent(path: Path) -> Iterator[Path]:
    """Context with a temporary file in the folder of `path` to write to. If the block succeeds, the file is flushed to disk and
    replaces `path`, or the file that this leads to as a link; if not, it is deleted. Other threads wait (`ONE_THREAD`).

    Raises SceneError naming the file if it cannot be written, whatever error a library raises on a full disk. A process killed
    inside the block leaves `path` unchanged; its temporary file is removed when the next file is written to that folder. Its name
    contains the process number, so that no two runs write to the same file.
    """
    target = _behind(path)
    if not os.path.isdir(target.parent):  # libraries of netCDF say that permission is denied
        raise SceneError(f"{str(path)!r} cannot be written: the folder {str(target.parent)!r} does not exist")
    with ONE_THREAD:
        remove_leftovers(target.parent)
        temporary = part_of(target, path.suffix)
        try:
            yield temporary
            with temporary.open("rb") as written:
                os.fsync(written.fileno())
            os.replace(temporary, target)
        except Exception as error:
            # first what the disk says: the library of netCDF calls a full one no permission
            reason = _refusal(temporary) or (error if isinstance(error, OSError) else None)
            if reason is None:
                raise
            raise SceneError(f"{str(path)!r} cannot be written: {reason_of(reason)}") from None
        finally:
            temporary.unlink(missing_ok=True)


@contextmanager
def going_on() -> Iterator[None]:
    """Context that writes a file for later, such as a checkpoint: if it cannot be written, the reason is told once, and nothing
    ends, because the next try may succeed and what is computed must not be lost with it."""
    try:
        yield
    except SceneError as error:
        if str(error) not in _told:
            log.warning("note: %s; the computation goes on", error)
        _told.add(str(error))


@contextmanager
def alone_in(folder: Path, label: str) -> Iterator[None]:
    """Context that only one process at a time enters for a `folder`, which is created. Raises SceneError, which begins with
    `label`, if another process holds it; a killed process releases it. On systems without such locks nothing is checked."""
    folder.mkdir(parents=True, exist_ok=True)
    if os.name != "posix":
        yield
        return
    import fcntl

    lock = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                reason = "another process writes to this folder now; wait for its end, or name another folder"
                raise SceneError(f"{label}: {reason}") from None
        yield
    finally:
        os.close(lock)


def content_of(path: Path, label: str) -> bytes:
    """The bytes of a file of data, or of a pipe. Raises SceneError, which begins with `label`, for a folder, a device, more than
    1 GB, and if it cannot be read. A pipe to which nobody writes is empty."""
    try:
        kind = path.stat().st_mode
        is_pipe = stat.S_ISFIFO(kind)
        if not (is_pipe or stat.S_ISREG(kind)):
            raise SceneError(f"{label}: is {'a folder' if stat.S_ISDIR(kind) else 'a device'}; must be a file or a pipe")
        flags = os.O_NONBLOCK if is_pipe else getattr(os, "O_BINARY", 0)
        with open(os.open(path, os.O_RDONLY | flags), "rb", buffering=0) as file:
            content = bytearray(_first_of_pipe(file) if is_pipe else b"")
            while len(content) <= MOST_BYTES and (more := file.read(_PROBE)):
                content += more
    except (OSError, ValueError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"{label}: cannot be read: {reason_of(error)}") from None
    if len(content) > MOST_BYTES:
        raise SceneError(f"{label}: is longer than 1 GB")
    return bytes(content)


def _first_of_pipe(file: FileIO) -> bytes:
    """The first bytes of a pipe that does not block; with a writer it blocks from then on."""
    for _ in range(_PATIENCE):
        first = file.read(_PROBE)
        if first != b"":  # None: there is a writer, who has written nothing yet
            os.set_blocking(file.fileno(), True)
            return first or b""
        time.sleep(1.0)
    return b""


def require_folder(folder: Path) -> None:
    """Make sure, before anything is computed, that `folder` exists (its last part is made) and can be written."""
    try:
        folder.mkdir(exist_ok=True)
    except (OSError, ValueError) as error:
        raise SceneError(f"--out = {str(folder)!r}: cannot be used: {reason_of(error)}") from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise SceneError(f"--out = {str(folder)!r}: this folder cannot be written")


def require_writable(path: Path, suffixes: tuple[str, ...], option: str = "--out") -> None:
    """Make sure, before anything is computed, that `path` can become a file of one of these kinds: that it can be written, and
    that the library that writes it is installed."""
    try:
        problem = _why_not(path, suffixes)
    except (OSError, ValueError) as error:
        problem = reason_of(error)
    if problem:
        raise SceneError(f"{option} = {str(path)!r}: {problem}")
    if path.suffix in _EXTRA:
        require(_EXTRA[path.suffix], f"{option} = {str(path)!r}")


def _why_not(path: Path, suffixes: tuple[str, ...]) -> str:
    if not str(path).isprintable():
        return "the path has characters that cannot be printed, or is no valid text"
    if path.suffix not in suffixes:
        return f"the name must end in {' or '.join(suffixes)}"
    if path.is_dir():
        return "is a folder; must be a file"
    if path.exists() and not path.is_file():
        return "is no regular file"
    folder = _behind(path).parent
    if not folder.is_dir():
        return f"the folder {str(folder)!r} does not exist"
    if not os.access(folder, os.W_OK | os.X_OK):
        return f"the folder {str(folder)!r} cannot be written"
    return ""


def _behind(path: Path) -> Path:
    """The path that a link leads to, there or not, which in a ring of links is one of them; another path as it is."""
    return Path(os.path.realpath(path)) if os.path.islink(path) else path


def _refusal(path: Path) -> OSError | None:
    """Why no more bytes can be written to `path`; None if they can. On a full disk libraries raise errors of their own kinds."""
    try:
        with path.open("ab") as file:
            file.write(bytes(_PROBE))
    except OSError as error:
        return error
    return None
