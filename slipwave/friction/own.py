"""Friction laws of the user's own: loaded from a Python file on request, and named by the digest of that file."""

from pathlib import Path
from typing import Any

from slipwave.errors import SceneError
from slipwave.friction.law import LAWS
from slipwave.packages import OwnFile, own_file, run_file

LAW_FILES: dict[Path, None] = {}
"""The files that were run, in order; processes that are started later run them too."""


def load_laws(path: Path) -> list[str]:
    """Run the Python file `path`, which registers laws (docs/extending.md), and return their names.

    It is called on the user's request only, never by a scene. Raises SceneError if the file cannot be run or registers no law.
    """
    label = f"--law = {str(path)!r}"
    before = dict(LAWS)
    run_file(path, f"own_law_{path.stem}", label)
    names = [name for name, law in LAWS.items() if before.get(name) is not law]
    if not names:
        raise SceneError(f"{label}: registers no friction law: call slipwave.friction.register(...) in it")
    LAW_FILES[path.resolve()] = None
    for name in names:
        own_law(name)  # its digest is that of the text that was run
    return names


def own_law(name: str) -> OwnFile | None:
    """The file of the law `name`, of its function or of its parameters; None if both are built in, or it is unknown."""
    parts: tuple[Any, ...] = (LAWS[name].respond, LAWS[name].parameters) if name in LAWS else ()
    return next(filter(None, map(own_file, parts)), None)
