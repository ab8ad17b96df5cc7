"""Friction laws of the user's own: loaded from a Python file on request, and named by the digest of that file."""

import hashlib
from pathlib import Path
from typing import NamedTuple

from slipwave.errors import SceneError
from slipwave.friction.law import HOUSE, LAWS
from slipwave.packages import run_file


class OwnLaw(NamedTuple):
    """The file in which a law is written, and the digest of its contents."""

    path: Path
    digest: str


LAW_FILES: dict[Path, None] = {}
"""The files that were run, in order; processes that are started later run them too."""


def load_laws(path: Path) -> list[str]:
    """Run the Python file `path`, which registers laws (docs/extending.md), and return their names.

    It is called on the user's request only, never by a scene. Raises SceneError if the file cannot be run or registers no law.
    """
    label = f"--law = {str(path)!r}"
    before = dict(LAWS)
    run_file(path, f"own_law_{path.stem}", label)
    found = [name for name, law in LAWS.items() if before.get(name) is not law]
    if not found:
        raise SceneError(f"{label}: registers no friction law: call slipwave.friction.register(...) in it")
    LAW_FILES[path.resolve()] = None
    return found


def own_law(name: str) -> OwnLaw | None:
    """File and digest of the law `name`; None if it is built in or unknown."""
    if name not in LAWS:
        return None
    path = Path(LAWS[name].respond.__code__.co_filename).resolve()
    if path.parent == HOUSE:
        return None
    content = path.read_bytes() if path.is_file() else LAWS[name].respond.__code__.co_code  # typed into a notebook: no file
    return OwnLaw(path, hashlib.sha256(content).hexdigest()[:16])
