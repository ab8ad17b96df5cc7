"""`njit` for all packages: numba with a disk cache that cannot go stale (`slipwave.compiled.cache`)."""

import gc
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.core import event
from numba.core.types.misc import unliteral

from slipwave.compiled.cache import DiskCache

Function = TypeVar("Function", bound=Callable[..., Any])


class _NoCollection(event.Listener):  # type: ignore[misc]
    """Python's collector of cyclic garbage rests while numba compiles, a tenth of whose time it would take."""

    _running, _was_on = 0, False

    def on_start(self, event: event.Event) -> None:
        """A compilation begins, perhaps within another one."""
        if not self._running:
            self._was_on = gc.isenabled()
            gc.disable()
        self._running += 1

    def on_end(self, event: event.Event) -> None:
        """It ends."""
        self._running -= 1
        if self._was_on and not self._running:
            gc.enable()


event.register("numba:compile", _NoCollection())


def njit(function: Function) -> Function:
    """Compile `function` with numba, cached on disk; fused multiply-add allowed, no other reordering of arithmetic."""
    dispatcher = numba.njit(error_model="numpy", fastmath={"contract"}, no_cfunc_wrapper=True)(function)
    dispatcher._cache = DiskCache(function)
    called = dispatcher.get_call_template
    # numba would compile the function once more for a call with a constant
    dispatcher.get_call_template = lambda arguments, named: called([unliteral(one) for one in arguments], named)
    return cast(Function, dispatcher)


def inlined(function: Function) -> Function:
    """Compile `function` into its callers: for parts of a hot loop, where the reference counting of a call would cost time."""
    return cast(Function, numba.njit(inline="always", error_model="numpy", fastmath={"contract"})(function))


@njit
def overwrite(target: Any, source: Any) -> None:
    """target <- source, arrays of one size; a loop compiles twenty times faster than numba's slice assignment."""
    for i in range(target.size):
        target.flat[i] = source.flat[i]
