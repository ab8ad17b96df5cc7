"""How processes of a sweep start: as copies of one that has imported what they need, where the system can copy processes.

That one is `multiprocessing`'s fork server: it has no threads, it ends with this process, and later sweeps use it again.
"""

import multiprocessing
from multiprocessing import forkserver
from multiprocessing.context import BaseContext

_IMPORTED = ["validation.sweep.engine", "reduced.delay.alike", "reduced.stability"]
_IDLE = {"--help", "--dry", "--gather", "--scheduler"}  # options of a sweep without processes here


def starting() -> BaseContext:
    """The way to start a process."""
    if not _copies():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(_IMPORTED)
    return context


def start_early(words: list[str]) -> None:
    """Start to import for the processes that a sweep with these `words` needs, while this process itself imports."""
    if _copies() and not _IDLE.intersection(words):
        starting()
        forkserver.ensure_running()


def _copies() -> bool:
    return "forkserver" in multiprocessing.get_all_start_methods()
