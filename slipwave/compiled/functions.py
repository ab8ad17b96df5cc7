"""`njit` for all packages: numba with a disk cache that cannot go stale (`slipwave.compiled.cache`)."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from slipwave.compiled.cache import DiskCache

Function = TypeVar("Function", bound=Callable[..., Any])


def njit(function: Function) -> Function:
    """Compile `function` with numba, cached on disk; fused multiply-add allowed, no other reordering of arithmetic."""
    dispatcher = numba.njit(error_model="numpy", fastmath={"contract"})(function)
    dispatcher._cache = DiskCache(function)
    return cast(Function, dispatcher)


def inlined(function: Function) -> Function:
    """Compile `function` into its callers: for parts of a hot loop, where the reference counting of a call would cost time."""
    return cast(Function, numba.njit(inline="always", error_model="numpy", fastmath={"contract"})(function))


@njit
def overwrite(target: Any, source: Any) -> None:
    """target <- source, arrays of one size; a loop compiles twenty times faster than numba's slice assignment."""
    for i in range(target.size):
        target.flat[i] = source.flat[i]
