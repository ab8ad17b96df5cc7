"""Linear algebra on one thread: products of small matrices gain nothing from more, and lose a factor of 50 on a busy machine."""

import os
from functools import cache
from typing import Any

VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Environment variables that libraries of linear algebra read when they are loaded."""


def one_thread_by_default() -> None:
    """Limit the libraries that this process and its children load from now on to one thread, unless the environment sets a
    number."""
    if not any(name in os.environ for name in VARIABLES):
        os.environ |= dict.fromkeys(VARIABLES, "1")


@cache
def _controller() -> Any:
    from threadpoolctl import ThreadpoolController  # looks up the loaded libraries, which takes some milliseconds

    return ThreadpoolController()


def one_thread() -> Any:
    """A context in which BLAS uses one thread."""
    return _controller().limit(limits=1)
