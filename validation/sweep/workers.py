"""How processes of a sweep start: as copies of one that has imported what they need, where the system can copy processes.

That one is `multiprocessing`'s fork server: it has no threads, it ends with this process, and later sweeps use it again.
"""

import multiprocessing
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy
from multiprocessing import forkserver
from types import ModuleType
from typing import Any

from slipwave.threads import VARIABLES

_IMPORTED = ["validation.sweep.engine", "reduced.delay.alike", "reduced.stability"]
_ENVIRONMENT = threading.Lock()
_IDLE = {"--help", "--dry", "--gather", "--scheduler"}  # options of a sweep without processes here


def starting() -> Any:
    """The context of `multiprocessing` that starts processes."""
    if not _copies():
        return multiprocessing.get_context("spawn")
    context: Any = copy(multiprocessing.get_context("forkserver"))
    context.Process = _worker
    context.set_forkserver_preload(_IMPORTED)
    # the fork server imports before it is told our path; it would take files of the working folder with the names of ours
    with environment({**dict.fromkeys(VARIABLES, "1"), "PYTHONSAFEPATH": "1"}):
        forkserver.ensure_running()
    return context


def _worker(*given: Any, **named: Any) -> Any:
    """A process that does not run the user's script again: no sweep computes a function of it (`measures.measure_name`). So a
    script needs no guard around its sweep, and may come from standard input."""
    process: Any = multiprocessing.get_context("forkserver").Process(*given, **named)
    process._Popen = _start_without_main  # no public option leaves the script out
    return process


def _start_without_main(process: Any) -> Any:
    main, sys.modules["__main__"] = sys.modules["__main__"], ModuleType("__main__")
    try:
        return type(process)._Popen(process)
    finally:
        sys.modules["__main__"] = main


def start_early(words: list[str]) -> None:
    """Start to import for the processes that a sweep with these `words` needs, while this process itself imports."""
    if _copies() and not _IDLE.intersection(words):
        starting()


def _copies() -> bool:
    return "forkserver" in multiprocessing.get_all_start_methods()


@contextmanager
def environment(values: dict[str, str]) -> Iterator[None]:
    """Context with these environment variables, which new processes inherit; for one thread at a time, so that each restores the
    former values."""
    with _ENVIRONMENT:
        before = {name: os.environ.get(name) for name in values}
        os.environ.update(values)
        try:
            yield
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value
