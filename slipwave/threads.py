"""Linear algebra on one thread: products of small matrices gain nothing from more, and lose a factor of 50 on a busy machine."""

from functools import cache
from typing import Any


@cache
def _controller() -> Any:
    from threadpoolctl import ThreadpoolController  # looks up the loaded libraries, which takes some milliseconds

    return ThreadpoolController()


def one_thread() -> Any:
    """A context in which BLAS uses one thread."""
    return _controller().limit(limits=1)
