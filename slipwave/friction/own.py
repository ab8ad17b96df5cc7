"""Friction laws of the user's own: loaded from a Python file on request, and named by the digest of that file."""

import copyreg
import re
import warnings
from functools import partial
from pathlib import Path
from typing import Any

from slipwave.errors import SceneError
from slipwave.friction.law import LAWS, Law
from slipwave.packages import OwnFile, kept_if_wrong, own_file, run_file

LAW_FILES: dict[Path, None] = {}
"""The files that were run, in order; processes that are started later run them too."""

_KINDS: dict[tuple[str, str], type[Any]] = {}
"""Parameters of all laws that were loaded, by their name, which tells one that was loaded anew, and the digest of the file."""


def load_laws(path: Path) -> list[str]:
    """Run the Python file `path`, which registers laws (docs/extending.md), and return their names.

    It is called on the user's request only, never by a scene. Raises SceneError if the file cannot be run or registers no law.
    """
    label, name = f"--law = {str(path)!r}", f"own_law_{path.stem}"
    before = dict(LAWS)
    with kept_if_wrong(name, LAWS):
        run_file(path, name, label)
        names = [name for name, law in LAWS.items() if before.get(name) is not law]
        if not names:
            raise SceneError(f"{label}: registers no friction law: call slipwave.friction.register(...) in it")
    LAW_FILES[path.resolve()] = None
    for name in names:
        own, kind = own_law(name), LAWS[name].parameters  # its digest is that of the text that was run
        if own is not None:
            _KINDS[kind.__name__, own.digest] = kind
            copyreg.pickle(kind, partial(_packed, name, own))
    return names


def _packed(name: str, own: OwnFile, law: Law) -> tuple[Any, ...]:
    """A pickle of `law` names its file: another process cannot import the file, but runs it."""
    return _unpacked, (name, own, type(law).__name__, tuple(law))


def _unpacked(name: str, own: OwnFile, kind: str, values: tuple[float, ...]) -> Law:
    """The law, as it was when it was pickled. Raises SceneError if its file is not there, or has changed."""
    if name not in LAWS:
        load_laws(own.path)
    known = own_law(name)
    if (kind, own.digest) not in _KINDS and (known is None or known.digest != own.digest):
        raise SceneError(f"friction law {name!r}: is not that of {str(own.path)!r} with the digest {own.digest}, as it is needed")
    return _KINDS.get((kind, own.digest), LAWS[name].parameters)(*values)


def own_law(name: str) -> OwnFile | None:
    """The file of the law `name`, of its function or of its parameters; None if both are built in, or it is unknown."""
    parts: tuple[Any, ...] = (LAWS[name].respond, LAWS[name].parameters) if name in LAWS else ()
    return next(filter(None, map(own_file, parts)), None)


def refused_by_compiler(error: Exception) -> Exception:
    """What to raise for an `error` of numba: a SceneError that names the function of a user's law that cannot be compiled, with
    the compiler's reason; if there is none, the error itself."""
    from numba import float64, njit, typeof
    from numba.core.errors import NumbaError

    from slipwave.friction.check import sample_of

    for name, law in LAWS.items():
        own = own_law(name)
        if own is None:
            continue
        sample = typeof(sample_of(name, law))
        for label, function in zip(law._fields[1:], law[1:], strict=True):
            try:
                with warnings.catch_warnings(action="ignore"):
                    njit(function).compile((sample, *[float64] * (function.__code__.co_argcount - 1)))
            except NumbaError as refusal:
                lines = [line.strip() for line in str(refusal).splitlines() if line.strip()]
                why = next((line for line in lines if not line.startswith("Failed in nopython")), type(refusal).__name__)
                place = re.findall(rf"{re.escape(own.path.name)}(?:\", line | \()(\d+)", str(refusal))
                where = f" ({own.path}, line {place[-1]})" if place else ""
                return SceneError(f"friction law {name!r}: numba cannot compile {label}{where}: {why.rstrip(':')}")
    return error
