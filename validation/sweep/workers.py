"""How processes of a sweep start: as copies of one that has imported what they need, where the system can copy processes.

That one is `multiprocessing`'s fork server: it has no threads, it ends with this process, and later sweeps use it again.
"""

import multiprocessing
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import forkserver
from multiprocessing.context import BaseContext

from slipwave.threads import VARIABLES

_IMPORTED = ["validation.sweep.engine", "reduced.delay.alike", "reduced.stability"]
_ENVIRONMENT = threading.Lock()
_IDLE = {"--help", "--dry", "--gather", "--scheduler"}  # options of a sweep without processes here


def starting() -> BaseContext:
    """The way to start a process."""
    if not _copies():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_IMPORTED)
    # the fork server imports before it is told our path; it would take files of the working folder with the names of ours
    with environment({**dict.fromkeys(VARIABLES, "1"), "PYTHONSAFEPATH": "1"}):
        forkserver.ensure_running()
    return context


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
