"""Processor time: that of this process and of those it started and waited for. Other work on the machine delays the answer and
hardly changes it. Also the number of cores."""

import os
import resource
import time
from collections.abc import Callable, Mapping
from typing import TypeVar

Answer = TypeVar("Answer")


def timed(work: Callable[[], Answer]) -> tuple[float, Answer]:
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


def in_turn(works: Mapping[str, Callable[[], Callable[[], object]]], repeats: int) -> list[dict[str, float]]:
    """Processor seconds of every work, once in each of `repeats` rounds, so that a machine that slows down slows all of them.

    A work first prepares, untimed, and returns what is timed.
    """
    return [{name: timed(prepare())[0] for name, prepare in works.items()} for _ in range(repeats)]
