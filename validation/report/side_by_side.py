"""Distributes tasks to several processes, each of which does one at a time. One Ctrl-C ends all of them.

The processes are spawned. Each leads its own process group, with everything that it starts. They ignore Ctrl-C; the waiting
process receives it and ends their groups. A process whose parent was killed ends itself.
"""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.queues import Queue
from queue import Empty
from typing import Any, TypeVar

Task = TypeVar("Task")
Answer = TypeVar("Answer")
Tell = Callable[[float], None]

_LOOK = 0.2  # seconds between two checks for news from the processes
_news: "list[Queue[tuple[int, float]]]" = []
"""In a process that works, where its news go: a queue can be handed to a process only when it starts."""


def share_out(
    work: Callable[[Task, Tell], Answer], tasks: Sequence[Task], processes: int, progress: Callable[[Task, float], None]
) -> Iterator[tuple[Task, Answer | None]]:
    """(task, work(task, tell)) as tasks end; the answer is None for tasks that were running or waiting when a process died.

    `work` is a function of a module; tasks and answers can be pickled. What `work` passes to `tell` (a share of the task, 0 to 1)
    reaches `progress`. Tasks are begun in the order given.
    """
    context = get_context("spawn")
    news: Queue[tuple[int, float]] = context.Queue()
    pool = ProcessPoolExecutor(min(processes, len(tasks)), context, _begin, (news,))
    try:
        with _deaf():
            futures: dict[Future[Answer], Task] = {_submitted(pool, work, k, task): task for k, task in enumerate(tasks)}
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
        pool.shutdown()


def _submitted(pool: ProcessPoolExecutor, work: Callable[[Task, Tell], Answer], number: int, task: Task) -> Future[Answer]:
    try:
        return pool.submit(_perform, work, number, task)
    except BrokenExecutor as error:  # a process died while others were started
        broken: Future[Answer] = Future()
        broken.set_exception(error)
        return broken


def _perform(work: Callable[[Task, Tell], Answer], number: int, task: Task) -> Answer:
    def tell(share: float) -> None:
        """Send the share to the parent."""
        for news in _news:
            news.put((number, share))

    return work(task, tell)


def _begin(news: "Queue[tuple[int, float]]") -> None:
    """Called in each process when it starts."""
    _news.append(news)
    os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # drop a Ctrl-C that came before
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    signal.signal(signal.SIGINT, signal.default_int_handler)  # for processes that a study starts
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
    """Processes started in this block begin without hearing Ctrl-C. One that comes meanwhile is raised here when the block
    ends."""
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
