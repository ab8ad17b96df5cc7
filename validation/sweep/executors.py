"""Executors: processes of this machine, or an existing cluster."""

import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from typing import Any, TypeAlias

from slipwave.errors import SceneError
from slipwave.extras import require
from slipwave.threads import VARIABLES
from validation.models.stopwatch import cores
from validation.sweep.workers import environment, starting

Workers: TypeAlias = tuple[Callable[[], Executor], int, Callable[[], bool]]
"""What starts executors, the number of their workers, and what says whether these can be reached."""


@contextmanager
def processes(workers: int) -> Iterator[Callable[[], Executor]]:
    """Context with a function that starts pools of `workers` processes on this machine, each with one thread for algebra. They
    end with this process, however it ends."""
    made: list[ProcessPoolExecutor] = []

    def start() -> Executor:
        """Start a new pool, which replaces the one before."""
        while made:
            kill(made.pop())
        context = starting()
        with environment(dict.fromkeys(VARIABLES, "1")):
            pool = ProcessPoolExecutor(workers, context, _begin, (dict(os.environ),))
            made.append(pool)
            with suppress(BrokenExecutor):  # a process killed as it starts: the next submission raises
                for _ in range(workers):
                    pool.submit(int)
        return pool

    try:
        yield start
    finally:
        for pool in made:
            kill(pool)


def kill(pool: ProcessPoolExecutor) -> None:
    """End the processes of a pool now; what they were computing is lost."""
    running = list((pool._processes or {}).values())  # not public before Python 3.14
    pool.shutdown(wait=False, cancel_futures=True)
    for leader in (process.pid for process in running if process.pid):
        _end_group(leader)


def _end_group(leader: int) -> None:
    """End a process and all that it has started."""
    for end in (os.killpg, os.kill):  # the latter for a process that does not lead its group yet
        with suppress(ProcessLookupError):
            end(leader, signal.SIGKILL)


def _begin(inherited: dict[str, str]) -> None:
    """Initialise a worker: it leads a group of processes, which Ctrl-C does not reach, and ends with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.setsid()
    os.environ.clear()  # what the fork server was started with
    os.environ.update(inherited)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        """End this process when the parent has ended."""
        assert parent is not None
        parent.join()
        _end_group(os.getpid())

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def started(workers: int, scheduler: str | None = None, executor: Executor | None = None) -> Iterator[Workers]:
    """Context with a given `executor`, with the dask `scheduler` at an address, or with `workers` processes of this machine (0:
    one per core). Raises SceneError as `_cluster`."""
    if executor is not None:
        yield lambda: executor, workers or getattr(executor, "_max_workers", None) or cores(), lambda: True
    elif scheduler:
        with _cluster(scheduler) as known:
            yield known
    else:
        with processes(workers or cores()) as start:
            yield start, workers or cores(), lambda: True


@contextmanager
def _cluster(address: str) -> Iterator[Workers]:
    """Context with the dask scheduler at `address` and its workers' threads. Raises SceneError if none answers within dask's
    own time (`distributed.comm.timeouts.connect`, 30 s unless the user says otherwise), or if it has no workers."""
    require("cluster", "--scheduler")
    for name in ("distributed", "tornado.application"):  # a lost scheduler is reported in one line, by us
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    import distributed

    try:
        client: Any = distributed.Client(address, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, TimeoutError) as error:
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise SceneError(f"--scheduler = {address!r}: no scheduler answers there: {reason}") from None
    try:
        workers = sum(client.nthreads().values())
        if not workers:
            raise SceneError(f"--scheduler = {address!r}: has no workers")
        yield lambda: client.get_executor(pure=False, retries=0), workers, lambda: client.status == "running"
    finally:
        client.close(timeout=1)
