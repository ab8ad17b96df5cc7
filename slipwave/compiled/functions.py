"""`njit` for all packages: numba with a disk cache that cannot go stale (`slipwave.compiled.cache`)."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.types import unliteral

from slipwave.compiled.cache import DiskCache

Function = TypeVar("Function", bound=Callable[..., Any])


def njit(function: Function) -> Function:
    """Compile `function` with numba, cached on disk; fused multiply-add allowed, no other reordering of arithmetic.

    It must neither create nor return arrays: references are not counted, which would take up to a third of a march's time, so
    that such an array would never be released. Functions that create arrays are `allocating`."""
    return _compiled(function, counts=False)


def allocating(function: Function) -> Function:
    """As `njit`, for a function that creates or returns arrays."""
    return _compiled(function, counts=True)


def _compiled(function: Function, counts: bool) -> Function:
    """Two versions: one for calls from Python, and one for calls from compiled code, which needs no wrapper for Python.

    No public option of numba leaves references uncounted (`_nrt`), keeps code in another cache (`_cache`), or gives compiled
    callers another version, compiled once for a number and a constant of its type (`get_call_template`, `get_overload`).
    """
    dispatcher, part = (_dispatcher(function, counts, is_part) for is_part in (False, True))
    called = part.get_call_template
    dispatcher.get_call_template = lambda arguments, named: called([unliteral(one) for one in arguments], named)
    dispatcher.get_overload = part.get_overload
    return cast(Function, dispatcher)


def _dispatcher(function: Function, counts: bool, is_part: bool) -> Any:
    options = {"no_cfunc_wrapper": True, "no_cpython_wrapper": is_part, "_nrt": counts}
    dispatcher = numba.njit(error_model="numpy", fastmath={"contract"}, nogil=True, **options)(function)
    dispatcher._cache = DiskCache(function, is_part)
    return dispatcher


def inlined(function: Function) -> Function:
    """Compile `function` into its callers: for small parts of a hot loop, where a call would cost time."""
    return cast(Function, numba.njit(inline="always", error_model="numpy", fastmath={"contract"})(function))
