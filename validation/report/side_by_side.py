"""Work that several processes share, one task at a time each, and that one Ctrl-C ends altogether.

The processes are new ones (spawn), each the leader of a group of its own with all that it starts. They never hear a Ctrl-C; the
process that waits for them does, and ends their groups. A process whose parent was killed ends itself.
"""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.queues import Queue
from queue import Empty
from typing import Any, TypeVar

Task = TypeVar("Task")
Answer = TypeVar("Answer")
Tell = Callable[[float], None]

_LOOK = 0.2  # seconds between two looks at what the processes tell
_news: "Queue[tuple[int, float]] | None" = None


def share_out(
    work: Callable[[Task, Tell], Answer], tasks: Sequence[Task], processes: int, progress: Callable[[Task, float], None]
) -> Iterator[tuple[Task, Answer | None]]:
    """(task, work(task, tell)) as they come; the answer is None for tasks that were under way or waiting when a process died.

    `work` is a function of a module, tasks and answers can be pickled; what `work` tells (a share of the task, 0 to 1) reaches
    `progress`. Tasks are begun in the order given.
    """
    context = get_context("spawn")
    news: Queue[tuple[int, float]] = context.Queue()
    pool = ProcessPoolExecutor(min(processes, len(tasks)), context, _begin, (news,))
    try:
        with _deaf():
            futures: dict[Future[Answer], Task] = {pool.submit(_perform, work, k, task): task for k, task in enumerate(tasks)}
        waiting = set(futures)
        while waiting:
            done, waiting = wait(waiting, _LOOK, FIRST_COMPLETED)
            for number, share in _heard(news):
                progress(tasks[number], share)
            for future in done:
                yield futures[future], None if future.exception() else future.result()
    finally:
        for child in active_children():
            _end_group(child.pid)
        pool.shutdown(wait=False, cancel_futures=True)


def _perform(work: Callable[[Task, Tell], Answer], number: int, task: Task) -> Answer:
    def tell(share: float) -> None:
        """Put the news where the parent looks."""
        if _news is not None:
            _news.put((number, share))

    return work(task, tell)


def _begin(news: "Queue[tuple[int, float]]") -> None:
    """Called in each process when it starts."""
    global _news
    _news = news
    os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # forget one that came before
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what a study starts may be sent one
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        _end_group(os.getpid())


def _end_group(leader: int | None) -> None:
    if leader is None:
        return
    for end in (os.killpg, os.kill):  # the latter for a process that does not lead its group yet
        with suppress(ProcessLookupError):
            end(leader, signal.SIGKILL)


@contextmanager
def _deaf() -> Iterator[None]:
    """What is started in this block begins deaf to Ctrl-C; one that comes meanwhile is heard here when the block ends."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _heard(news: "Queue[Any]") -> Iterator[tuple[int, float]]:
    while True:
        try:
            yield news.get_nowait()
        except Empty:
            return
