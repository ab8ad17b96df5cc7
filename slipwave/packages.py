"""Code from outside: a user's Python file, run on request, and entry points of installed packages."""

import importlib.util
import logging
import sys
import traceback
from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from slipwave.errors import SceneError

log = logging.getLogger("slipwave")

_RUN = set[str]()  # files that were run


def run_file(path: Path, name: str, label: str) -> ModuleType:
    """Run the Python file `path` as a module called `name`. Raises SceneError, which begins with `label`, if it cannot be run."""
    if path.suffix != ".py" or not path.is_file():
        raise SceneError(f"{label}: {'must be a Python file' if path.exists() else 'no such file'}")
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    _RUN.add(str(path))
    module = sys.modules[name] = importlib.util.module_from_spec(spec)  # where compiled code on disk looks for its classes
    try:
        spec.loader.exec_module(module)
    except SceneError:
        raise
    except Exception as error:
        where = "" if isinstance(error, SyntaxError) else f" ({line_of_user(error)})"  # that names its line
        raise SceneError(f"{label}: cannot be run: {type(error).__name__}: {error}{where}") from error
    return module


def line_of_user(error: BaseException) -> str:
    """Location of an error in a file that `run_file` ran, "FILE.py, line 12, in march"; empty if it did not."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in _RUN]
    return f"{frames[-1].filename}, line {frames[-1].lineno}, in {frames[-1].name}" if frames else ""


def load_from_packages(group: str, take: Callable[[Any, str], None]) -> None:
    """Call `take` with each object that installed packages offer in the `group` of entry points, and a label for messages. A
    failing package is logged in one line and skipped."""
    for entry in entry_points(group=group):
        label = f"{entry.dist.name if entry.dist else 'an installed package'}: {group} {entry.name} = {entry.value!r}"
        try:
            take(entry.load(), label)
        except Exception as error:
            reason = str(error) if isinstance(error, SceneError) else f"{label}: {type(error).__name__}: {error}"
            log.warning("note: %s; it is left out", " ".join(reason.split()))
