"""Friction laws of the user's own: loaded from a Python file on request, and named by the digest of that file."""

import hashlib
import importlib.util
import sys
from pathlib import Path
from typing import NamedTuple

from slipwave.errors import SceneError
from slipwave.friction.law import HOUSE, LAWS


class OwnLaw(NamedTuple):
    """The file in which a law is written, and the digest of its contents."""

    path: Path
    digest: str


def load_laws(path: Path) -> list[str]:
    """Run the Python file `path`, which registers laws (docs/extending.md), and return their names.

    Only a user's own request leads here, never a scene. Raises SceneError if the file cannot be run or registers no law.
    """
    label = f"--law = {str(path)!r}"
    if path.suffix != ".py" or not path.is_file():
        raise SceneError(f"{label}: {'must be a Python file' if path.exists() else 'no such file'}")
    spec = importlib.util.spec_from_file_location(f"own_law_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    before = dict(LAWS)
    module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)  # where compiled code on disk looks for its classes
    try:
        spec.loader.exec_module(module)
    except SceneError:
        raise
    except Exception as error:
        raise SceneError(f"{label}: cannot be run: {type(error).__name__}: {error}") from error
    found = [name for name, law in LAWS.items() if before.get(name) is not law]
    if not found:
        raise SceneError(f"{label}: registers no friction law: call slipwave.friction.register(...) in it")
    return found


def own_law(name: str) -> OwnLaw | None:
    """Where the law `name` is written; None if it is one of the house or not known."""
    if name not in LAWS:
        return None
    path = Path(LAWS[name].respond.__code__.co_filename).resolve()
    if path.parent == HOUSE:
        return None
    content = path.read_bytes() if path.is_file() else LAWS[name].respond.__code__.co_code  # typed into a notebook: no file
    return OwnLaw(path, hashlib.sha256(content).hexdigest()[:16])
