"""Cache of compiled code on disk, valid as long as its sources have not changed. No error of the cache ends a run.

One file holds one function compiled for one set of argument types. Its name is a digest of all that shapes the machine code: the
argument types, the processor, the versions of Python, numpy, numba and llvmlite, and the program text of these modules: the
function's own, those of its arguments' classes, those of the functions that compiled code chooses by class (`add_choices`, for
example friction laws), and every module that these import. A user's own classes and functions enter by their bytecode (`frozen`).
A file begins with a digest of its contents; if that does not match, the file is deleted. If the folder cannot be read or written,
functions are compiled without it, and one line on stderr says so.

The folder is `$NUMBA_CACHE_DIR` if that variable is set, else `$XDG_CACHE_HOME/slipwave` (default ~/.cache). Files that were not
used for a month are removed. numba's own cache, which a user's functions may use, is left alone: it sees a change of a function's
own file only, and NUMBA_CACHE_LOCATOR_CLASSES, which would change that, acts on every function of the process and does not see
argument types. Private names of numba without a public substitute: `_reduce` and `_rebuild` of a compiled function, `dumps`,
which pickles them, `NullCache`, the interface of a cache, and `c_helpers`, the memory functions that the code calls.
"""

import contextlib
import hashlib
import os
import pickle
import sys
import time
import uuid
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import Any, TypeAlias

import llvmlite  # type: ignore[import-untyped]
import numba
import numpy as np
from llvmlite.binding import add_symbol  # type: ignore[import-untyped]
from numba.core.caching import NullCache
from numba.core.runtime._nrt_python import c_helpers
from numba.core.serialize import dumps

from slipwave.compiled.frozen import frozen_parts
from slipwave.compiled.parts import rebuilt
from slipwave.sources import cache_folder, digest_of, import_closure, inside

STARTED = time.time()
_UNUSED_SECONDS = 30 * 86400.0
_SUFFIX = ".compiled"
_DIGEST_BYTES = hashlib.sha256().digest_size
_VERSIONS = f"{sys.version} {np.__version__} {numba.__version__} {llvmlite.__version__}"

Choices: TypeAlias = Callable[[], Iterable[tuple[type, Callable[..., Any]]]]
"""The versions that a compiled call may choose from, each with the class of its first argument."""

_choices: list[tuple[Path, Choices]] = []


def add_choices(generic: Callable[..., Any], choices: Choices) -> None:
    """Declare that a compiled call of `generic` may choose any of `choices()`, whose modules that of `generic` need not
    import."""
    _choices.append((_file_of(generic), choices))


COMPILING: list[float] = []
"""Seconds of each time that this process compiled functions or loaded them from the disk: no part of a run's time."""
_running: list[float] = []


def timed(compile_for: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """`compile_for` with its time taken; what it compiles in turn is a part of it."""

    def compiled(signature: Any) -> Any:
        _running.append(perf_counter())
        try:
            return compile_for(signature)
        finally:
            began = _running.pop()
            if not _running:
                COMPILING.append(perf_counter() - began)

    return compiled


class _Trouble:
    """Errors of the cache folder in this process: the first is printed; after a failed write nothing more is written."""

    has_warned = False
    is_writing = True

    def warn(self, trouble: str, is_writing: bool = True) -> None:
        """Print one line on stderr, the first time only."""
        self.is_writing = self.is_writing and is_writing
        if not self.has_warned:
            where = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or "~/.cache"
            line = f"slipwave: the cache of compiled code in {where} {trouble}; compiling again, which may take half a minute"
            with contextlib.suppress(OSError, ValueError):
                print(" ".join(line.split()), file=sys.stderr)
        self.has_warned = True


TROUBLE = _Trouble()


class DiskCache(NullCache):  # type: ignore[misc]
    """numba's cache interface for one compiled function: `load_overload` and `save_overload`. `is_part`: it is called from
    compiled code only."""

    def __init__(self, function: Callable[..., Any], is_part: bool = False) -> None:
        self._function, self._is_part = function, is_part

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The function compiled for `sig`, or None."""
        _name_runtime()
        try:
            path = self._path(sig, target_context.codegen())
            packed = path.read_bytes() if path else None
        except FileNotFoundError:
            return None
        except (OSError, RuntimeError) as error:  # RuntimeError: there is no home folder
            return TROUBLE.warn(f"cannot be read ({error})")
        if path is None or packed is None:
            return None
        try:
            kept, parts = pickle.loads(checked(packed, path.name))
            compiled = rebuilt(target_context, parts) if kept == sig else None
        except Exception as error:  # a damaged file may raise anything; it is compiled again
            with contextlib.suppress(OSError):
                path.unlink()
            return TROUBLE.warn(f"holds a damaged file, which is replaced ({path.name}: {error})")
        with contextlib.suppress(OSError):
            os.utime(path)
        return compiled

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save `data`, the function compiled for `sig`."""
        if not TROUBLE.is_writing:
            return
        try:
            path = self._path(sig, data.codegen)
            if path and not (data.lifted or data.library.has_dynamic_globals):
                _write(path, dumps((sig, data._reduce())))
        except Exception as error:  # neither a full disk nor a new numba with other internals may end a run
            TROUBLE.warn(f"cannot be written ({error})", is_writing=False)

    def _path(self, sig: Any, codegen: Any) -> Path | None:
        """File for the code of `sig`; None if a source of it is unknown, or was edited since the process began."""
        made_from = _made_from(self._function, set(_classes(getattr(sig, "args", sig))))
        if made_from is None:
            return None
        sources, foreign = made_from
        name = f"{self._function.__module__}.{self._function.__qualname__}"
        facts = f"{name} {self._is_part} {sig} {codegen.magic_tuple()} {_VERSIONS} {_program(sources)} {foreign}"
        return cache_folder() / f"{name}-{'part-' * self._is_part}{hashlib.sha256(facts.encode()).hexdigest()[:24]}{_SUFFIX}"


@cache
def _name_runtime() -> None:
    """Tell the linker where numba's memory functions are: all that loading needs of numba's own preparation, which compiles
    others and imports every part of numba."""
    for name, address in c_helpers.items():
        add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


def _classes(kinds: Iterable[Any]) -> Iterator[type]:
    """Classes of the NamedTuples among numba types."""
    for kind in kinds:
        if hasattr(kind, "instance_class"):
            yield kind.instance_class
        yield from _classes(getattr(kind, "types", ()))


def _made_from(function: Callable[..., Any], classes: set[type]) -> tuple[frozenset[Path], str] | None:
    """The project's files whose text determines the code of `function` compiled for arguments of `classes`, and the text
    of the user's functions in it (`frozen`); None if unknown, or if a file was edited since the start. A choice counts if its
    class is in `classes` or in one of the files."""
    if function.__module__ not in sys.modules:  # where compiled code on disk looks for the function
        return None
    sources: frozenset[Path] = frozenset()
    functions = {function}
    while True:
        homes = {thing: _home_of(thing) for thing in classes} | {thing: _file_of(thing) for thing in functions}
        brought = frozen_parts([thing for thing, home in homes.items() if not inside(home)])
        if brought is None:
            return None
        text, called = brought
        starts = called.union(home for home in homes.values() if inside(home))
        if starts <= sources:
            break
        sources = _closure(starts.union(sources))
        pairs = [pair for owner, choices in _choices if owner in sources for pair in choices()]
        functions = {function, *(version for kind, version in pairs if kind in classes or _home_of(kind) in sources)}
    # a file edited after the start is no longer the text that this process has imported
    return None if any(path.stat().st_mtime > STARTED for path in sources) else (sources, text)


def _home_of(kind: type) -> Path:
    return _resolved(getattr(sys.modules.get(kind.__module__), "__file__", None) or kind.__module__)


def _file_of(function: Callable[..., Any]) -> Path:
    return _resolved(function.__code__.co_filename)


@cache
def _resolved(name: str) -> Path:
    return Path(name).resolve()


@cache
def _closure(starts: frozenset[Path]) -> frozenset[Path]:
    return frozenset(import_closure(starts, packages=False))


@cache
def _program(sources: frozenset[Path]) -> str:
    return digest_of(sorted(sources))


def _digest(contents: bytes, name: str) -> bytes:
    return hashlib.sha256(name.encode() + contents).digest()


def checked(packed: bytes, name: str) -> bytes:
    """The contents of a file. Raises ValueError if a byte of it has changed."""
    contents = packed[_DIGEST_BYTES:]
    if packed[:_DIGEST_BYTES] != _digest(contents, name):
        raise ValueError("its digest does not match")
    return contents


def _write(path: Path, contents: bytes) -> None:
    """Write a file, preceded by its digest, whole or not at all, also when several processes write it."""
    _prune_once(path.parent)
    part = path.with_name(f"{uuid.uuid4().hex}.part")
    try:
        part.write_bytes(_digest(contents, path.name) + contents)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


@cache
def _prune_once(folder: Path) -> None:
    """Make the folder, and remove files from it that were not used for a month."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in folder.iterdir():
        with contextlib.suppress(OSError):  # another process may be removing them too
            if path.suffix in (_SUFFIX, ".part") and path.stat().st_mtime < STARTED - _UNUSED_SECONDS:
                path.unlink()
