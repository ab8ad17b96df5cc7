"""`njit` for the whole house: numba with a disk cache that cannot go stale.

numba notices a change only in the file that holds a compiled function, not in the functions inlined from elsewhere: a
corrected friction law would go on being answered by yesterday's machine code. Here the cache lives in a folder named after the
contents of every source file of the solver rooms, so any edit compiles afresh and an unchanged tree starts warm.

The folder is `$NUMBA_CACHE_DIR/<digest>` if that variable is set, else `$XDG_CACHE_HOME/slipwave/<digest>` (default ~/.cache).
"""

import hashlib
import os
import tempfile
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

_ROOT = Path(__file__).resolve().parent.parent
_ROOMS = ("scene", "reduced", "fullwave")
_PROCESS = uuid.uuid4().hex[:12]
_dispatchers: list[Any] = []
_disk_cache_enabled = True

Function = TypeVar("Function", bound=Callable[..., Any])


def source_digest(rooms: tuple[str, ...] = _ROOMS) -> str:
    """Hash of every Python source file in `rooms`; names the compile cache and dates stored results."""
    digest = hashlib.sha256()
    for room in rooms:
        for path in sorted((_ROOT / room).rglob("*.py")):
            digest.update(path.relative_to(_ROOT).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _cache_folder() -> Path:
    """A writable cache folder; falls back on a temporary one where the home cannot be written."""
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    base = Path(chosen) if chosen else Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "slipwave"
    folder = base / source_digest()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        folder = Path(tempfile.mkdtemp(prefix="slipwave-cache-"))
    return folder


numba.config.CACHE_DIR = str(_cache_folder())


def njit(function: Function) -> Function:
    """Compile `function` with numba, cached on disk; fused multiply-add allowed, no other reordering of arithmetic."""
    dispatcher = numba.njit(cache=_disk_cache_enabled, error_model="numpy", fastmath={"contract"})(function)
    _own_file_names(dispatcher)
    _dispatchers.append(dispatcher)
    return cast(Function, dispatcher)


def _own_file_names(dispatcher: Any) -> None:
    """Name this process's compiled files after itself.

    numba numbers them 1, 2, ...: two processes that start on an empty cache both write number 1, and whoever reads the index of
    the one may get the machine code of the other. With names of their own they can at worst compile the same thing twice.
    """
    file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if file is not None:
        file._data_name_pattern = file._data_name_pattern.replace("{number", f"{_PROCESS}.{{number")


def inlined(function: Function) -> Function:
    """Compile `function` into its callers: for the parts of a hot loop, where a call's reference counting would show."""
    return cast(Function, numba.njit(inline="always", error_model="numpy", fastmath={"contract"})(function))


@njit
def overwrite(target: Any, source: Any) -> None:
    """target <- source, arrays of one size; a loop compiles twenty times faster than numba's slice assignment."""
    for i in range(target.size):
        target.flat[i] = source.flat[i]


def leave_disk_cache() -> None:
    """Keep this process's compiled code off the disk: called when a law from outside the package, whose source the digest does
    not see, is registered, so that a later edit of it can never be answered by old machine code."""
    global _disk_cache_enabled
    if not _disk_cache_enabled:
        return
    _disk_cache_enabled = False
    from numba.core.caching import NullCache

    for dispatcher in _dispatchers:
        dispatcher._cache = NullCache()
