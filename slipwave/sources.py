"""The project's own source files: what a module imports, and digests that identify what was computed from them.

Imports are read from the text (`ast`), including those within functions. A digest leaves out comments and docstrings, so that a
change of these invalidates nothing. What was read is kept on disk beside the compiled code, by the bytes of the file: to parse
the solvers takes longer than a short run.
"""

import ast
import atexit
import hashlib
import os
import pickle
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TypeAlias

ROOT = Path(__file__).resolve().parent.parent
SOLVER_PACKAGES = ("slipwave", "reduced", "fullwave")
_PACKAGES = (*SOLVER_PACKAGES, "validation")
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")
_KEPT, _MOST_KEPT = "sources", 2000  # name of the file beside the compiled code, and texts in it: some versions of all of ours
_DOCUMENTED = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


@cache
def source_digest() -> str:
    """Digest of every Python source file of the solvers, read once per process."""
    return digest_of(path for package in SOLVER_PACKAGES for path in sorted((ROOT / package).rglob("*.py")))


def digest_of(paths: Iterable[Path]) -> str:
    """Digest of the program text of the project's Python files `paths`, in the given order, with their paths in the project."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update(f"{path.relative_to(ROOT).as_posix()}\n{program(path)}\n".encode())
    return digest.hexdigest()[:16]


def import_closure(starts: Iterable[Path], packages: bool = True) -> list[Path]:
    """`starts` and every file of the four packages that they import, directly or indirectly, sorted.

    `packages` adds the `__init__.py` of every parent package, which Python runs first. The `__init__.py` of a package that is
    imported by its own name is always included.
    """
    closure: set[Path] = set()
    to_read = set(starts)
    while to_read:
        path = to_read.pop()
        closure.add(path)
        to_read |= _imported_files(path, packages) - closure
    return sorted(closure)


def inside(path: Path) -> bool:
    """Whether `path` is a source file of the four packages."""
    return path.is_relative_to(ROOT) and path.relative_to(ROOT).parts[0] in _PACKAGES


def program(path: Path) -> str:
    """Digest of the syntax tree of a Python file, without docstrings, comments and line numbers; read once per process."""
    return _read(path)[0]


def imported_names(path: Path) -> tuple[str, ...]:
    """As `imports_in` of a file of the project, read once per process."""
    return _read(path)[1]


_Read: TypeAlias = tuple[str, tuple[str, ...]]
"""A file's `program` and `imported_names`; as pickled on disk, which other versions read too."""

_NEW: dict[bytes, _Read] = {}
"""What this process has read and no earlier one."""


@cache
def _read(path: Path) -> _Read:
    content = path.read_bytes()
    key, kept = hashlib.sha256(sys.version.encode() + content).digest(), _kept()
    if key not in kept:
        if not _NEW:
            atexit.register(_keep)
        kept[key] = _NEW[key] = _parsed(content)
    return kept[key]


def cache_folder() -> Path:
    """Folder of the compiled code. Raises RuntimeError if there is no home folder."""
    chosen, base = os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME")
    return Path(chosen) if chosen else (Path(base) if base else Path.home() / ".cache") / "slipwave"


@cache
def _kept() -> dict[bytes, _Read]:
    """What this process and earlier ones have read."""
    try:
        kept = dict(pickle.loads((cache_folder() / _KEPT).read_bytes()))
    except Exception:  # there is none, or a damaged one, which may raise anything
        return {}
    return kept if all(type(entry) is tuple for entry in kept.values()) else {}  # else another version wrote it


def _keep() -> None:
    """Write what was read, whole or not at all, but no more than _MOST_KEPT texts; of several processes the last one wins."""
    with suppress(OSError, RuntimeError):
        folder = cache_folder()
        folder.mkdir(parents=True, exist_ok=True)
        part = folder / f"{_KEPT}-{os.getpid()}.part"
        part.write_bytes(pickle.dumps(_kept() if len(_kept()) <= _MOST_KEPT else _NEW))
        part.replace(folder / _KEPT)


def imports_in(content: bytes) -> tuple[str, ...]:
    """Modules that a Python text imports; for `from a import b` both a and a.b; relative ones begin with dots."""
    return _parsed(content)[1]


def _parsed(content: bytes) -> _Read:
    """Both from one parse and one walk: it delays every start of the program."""
    tree = ast.parse(content)
    names: list[str] = []
    waiting: list[ast.AST] = [tree]
    while waiting:  # only through statements: the nodes that hold docstrings and imports, an eighth of all
        node = waiting.pop()
        waiting += [inner for name in _BLOCKS for inner in getattr(node, name, ())]
        if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            node.body = node.body[1:]
        elif isinstance(node, ast.ImportFrom):
            base = "." * node.level + (node.module or "")
            names += [base, *(f"{base}{'.' if node.module else ''}{name.name}" for name in node.names)]
        elif isinstance(node, ast.Import):
            names += [name.name for name in node.names]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(names)


@cache
def _imported_files(path: Path, packages: bool) -> set[Path]:
    """Files imported by `path`."""
    return {file for name in imported_names(path) for file in _files(name, packages)}


def _files(name: str, packages: bool) -> Iterator[Path]:
    """The file of the module `name`, if it belongs to the project; with `packages` also those of the packages around it."""
    parts = name.split(".")
    if parts[0] not in _PACKAGES:
        return
    for count in range(1 if packages else len(parts), len(parts) + 1):
        base = ROOT.joinpath(*parts[:count])
        yield from (path for path in (base.with_suffix(".py"), base / "__init__.py") if path.is_file())


@cache
def commit(folder: Path | None = None) -> str:
    """Short hash of the checkout the code runs from, or of the last commit that changed a `folder` of it, with "+" if it was
    edited before it was asked for; "unknown" outside a checkout."""
    import subprocess

    where = ["--", str(folder)] if folder else []
    try:
        short = _git("log", "-1", "--format=%h", "--abbrev=10", *where)
        edited = _git("status", "--porcelain", "--untracked-files=no", *where)
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return short + ("+" if edited else "")


def _git(*words: str) -> str:
    import subprocess

    words = "--no-optional-locks", "-C", str(ROOT), *words  # a process that is killed leaves them, and git refuses to commit
    done = subprocess.run(["git", *words], capture_output=True, text=True, check=True, timeout=10)
    return done.stdout.strip()
