"""Processor time: that of this process and of those it started and waited for. Other work on the machine delays the answer and
hardly changes it. Also the number of cores."""

import os
import resource
import time
from collections.abc import Callable
from typing import TypeVar

_Answer = TypeVar("_Answer")


def timed(work: Callable[[], _Answer]) -> tuple[float, _Answer]:
    """(processor seconds, answer) of `work`."""
    began = _spent()
    answer = work()
    return _spent() - began, answer


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _spent() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
