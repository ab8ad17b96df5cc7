"""Code from outside: a user's Python file, run on request and known by its digest, and entry points of installed packages."""

import hashlib
import importlib.util
import logging
import sys
import sysconfig
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any, NamedTuple

from slipwave.errors import SceneError
from slipwave.sources import imports_in, inside

log = logging.getLogger("slipwave")

_RUN = set[str]()  # files that were run
_all_entry_points = cache(entry_points)  # to read them takes milliseconds
_INSTALLED = {Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "platstdlib", "purelib", "platlib")}


class OwnFile(NamedTuple):
    """A user's Python file, and the digest of its text and of the user's modules that it imports."""

    path: Path
    digest: str


@cache
def own_file(thing: Any) -> OwnFile | None:
    """The user's file that defines a module, function or class, as it was when this was first asked; None if it is ours."""
    module = thing if isinstance(thing, ModuleType) else sys.modules.get(thing.__module__)
    code = getattr(thing, "__code__", None)
    path = Path(code.co_filename if code else str(getattr(module, "__file__", None))).resolve()
    if inside(path):
        return None
    if not path.is_file():  # typed into a notebook
        return OwnFile(path, hashlib.sha256(code.co_code if code else b"").hexdigest()[:16])
    files = {path: str(getattr(module, "__package__", None) or "")}
    waiting, digest = [path], hashlib.sha256()
    while waiting:
        here = waiting.pop()
        content = here.read_bytes()
        digest.update(content)
        for name in imports_in(content):
            with suppress(ImportError):  # a relative import of a file that is no part of a package
                there = sys.modules.get(importlib.util.resolve_name(name, files[here]))
                file = Path(getattr(there, "__file__", None) or "").resolve()
                if file.suffix == ".py" and file not in files and not (inside(file) or _INSTALLED.intersection(file.parents)):
                    files[file] = str(there.__package__ or "") if there else ""
                    waiting.append(file)
    return OwnFile(path, digest.hexdigest()[:16])


@contextmanager
def kept_if_wrong(name: str, *known: Any) -> Iterator[None]:
    """Context in which a user's file becomes the module `name`; an error puts back what that and the lists and tables `known`
    were before."""
    module, contents = sys.modules.get(name), [registry.copy() for registry in known]
    try:
        yield
    except BaseException:
        if module:
            sys.modules[name] = module
        for registry, content in zip(known, contents, strict=True):
            registry.clear()
            (registry.update if isinstance(registry, dict) else registry.extend)(content)
        raise


@contextmanager
def no_exit(label: str) -> Iterator[None]:
    """Context in which the user's code cannot end the program: if it tries, `ended` is raised."""
    try:
        yield
    except SystemExit as end:
        raise ended(end, label) from end


def ended(end: SystemExit, label: str = "") -> SceneError:
    """The error, which begins with `label` or the line, about a user's code that ended the program."""
    who = label or line_of_user(end) or "a law, family or measure of your own"
    return SceneError(f"{who}: ends the program (sys.exit({end.code!r})); it must return, or raise an error")


def run_file(path: Path, name: str, label: str) -> ModuleType:
    """Run the Python file `path` as a module called `name`. Raises SceneError, which begins with `label`, if it cannot be run."""
    if path.suffix != ".py" or not path.is_file():
        raise SceneError(f"{label}: {'must be a Python file' if path.exists() else 'no such file'}")
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    _RUN.add(str(spec.origin))  # as tracebacks name it, also where `path` is relative
    module = sys.modules[name] = importlib.util.module_from_spec(spec)  # where compiled code on disk looks for its classes
    try:
        with no_exit(label):
            spec.loader.exec_module(module)
    except SceneError:
        raise
    except Exception as error:
        where = "" if isinstance(error, SyntaxError) else f" ({line_of_user(error)})"  # that names its line
        raise SceneError(f"{label}: cannot be run: {type(error).__name__}: {error}{where}") from error
    _name_apart(module, path)
    return module


def _name_apart(module: ModuleType, path: Path) -> None:
    """Put a digest of the file's functions, with the values that they name, into the names of its named tuples. Functions that
    numba has compiled tell classes within their arguments apart by name alone: another file, or the same one edited, would run
    with the code of the first."""
    from slipwave.compiled.frozen import frozen_parts  # imported here to keep start-up fast

    functions = (
        function for function in vars(module).values() if isinstance(getattr(function, "py_func", function), FunctionType)
    )
    parts = [frozen_parts([function]) for function in functions]
    text = b"".join(part[0].encode() if part else path.read_bytes() for part in parts)
    digest = hashlib.sha256(text).hexdigest()[:8]
    for kind in vars(module).values():
        if isinstance(kind, type) and issubclass(kind, tuple) and kind.__module__ == module.__name__:
            kind.__name__ = f"{kind.__qualname__}_{digest}"


def line_of_user(error: BaseException) -> str:
    """Location of an error in a file that `run_file` ran, "FILE.py, line 12, in march"; empty if it did not."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in _RUN]
    return f"{frames[-1].filename}, line {frames[-1].lineno}, in {frames[-1].name}" if frames else ""


def load_from_packages(group: str, take: Callable[[Any, str], None]) -> None:
    """Call `take` with each object that installed packages offer in the `group` of entry points, and a label for messages. A
    failing package is logged in one line and skipped."""
    for entry in _all_entry_points().select(group=group):
        label = f"{entry.dist.name if entry.dist else 'an installed package'}: {group} {entry.name} = {entry.value!r}"
        try:
            with no_exit(label):
                take(entry.load(), label)
        except Exception as error:
            reason = str(error) if isinstance(error, SceneError) else f"{label}: {type(error).__name__}: {error}"
            log.warning("note: %s; it is left out", " ".join(reason.split()))
