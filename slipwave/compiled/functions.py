"""`njit` for all packages: numba with a disk cache that cannot go stale (`slipwave.compiled.cache`)."""

from collections.abc import Callable
from functools import update_wrapper
from typing import Any, TypeVar, cast

import numba
from numba.types import unliteral

from slipwave.compiled.cache import DiskCache, timed
from slipwave.compiled.parts import PartCompiler, WholeCompiler

Function = TypeVar("Function", bound=Callable[..., Any])


def njit(function: Function) -> Function:
    """Compile `function` with numba, cached on disk; fused multiply-add allowed, no other reordering of arithmetic.

    It must neither create nor return arrays: references are not counted, which would take up to a third of a march's time, so
    that such an array would never be released. Functions that create arrays are `allocating`."""
    return _compiled(function, counts=False)


def allocating(function: Function) -> Function:
    """As `njit`, for a function that creates or returns arrays."""
    return _compiled(function, counts=True)


def _compiled(function: Function, counts: bool, inline: bool = False) -> Function:
    """A part, for calls from compiled code, and around it a function for calls from Python (`slipwave.compiled.parts`).

    No public option of numba leaves references uncounted (`_nrt`), keeps code in another cache (`_cache`), gives compiled callers
    another version, compiled once for a number and a constant of its type (`get_call_template`, `get_overload`), or compiles
    another function than the one that is called (`_get_implementation`).
    """
    dispatcher, part = (_dispatcher(function, counts, is_part, inline) for is_part in (False, True))
    dispatcher._compiler._get_implementation = lambda *_: _call_of(function, part)
    called = part.get_call_template
    dispatcher.get_call_template = lambda arguments, named: called([unliteral(argument) for argument in arguments], named)
    dispatcher.get_overload = part.get_overload
    return cast(Function, dispatcher)


def _call_of(function: Callable[..., Any], part: Any) -> Callable[..., Any]:
    """A function of the name and the arguments of `function` that calls the `part`. The names tell machine code apart."""
    names = ", ".join(function.__code__.co_varnames[: function.__code__.co_argcount])
    return update_wrapper(eval(f"lambda {names}: part({names})", {"part": part, "__name__": function.__module__}), function)


def _dispatcher(function: Function, counts: bool, is_part: bool, inline: bool) -> Any:
    options = {"no_cfunc_wrapper": True, "no_cpython_wrapper": is_part, "_nrt": counts, "forceinline": inline}
    compiler = PartCompiler if is_part else WholeCompiler
    dispatcher = numba.njit(error_model="numpy", fastmath={"contract"}, nogil=True, pipeline_class=compiler, **options)(function)
    dispatcher._cache = DiskCache(function, is_part)
    dispatcher.compile = timed(dispatcher.compile)
    return dispatcher


def inlined(function: Function) -> Function:
    """As `njit`, for small parts of a hot loop, where a call would cost time: LLVM inlines it. If numba did, it would infer the
    types again in each caller."""
    return _compiled(function, counts=False, inline=True)
