"""Choose an implementation by the class of the first argument, at compile time.

A slab's medium and its face are NamedTuples; the kernel calls `strain(medium)` and numba compiles in the version that belongs to
the class, and no other: a rigid face or a uniform slab pays nothing for the grips and layers that a different scene has.
"""

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from slipwave.compiled.cache import add_choices

_OPTIONS = {"error_model": "numpy", "fastmath": {"contract"}}


def dispatch(generic: Callable[..., Any], versions: dict[type, Callable[..., Any]], inline: bool = False) -> None:
    """Make `generic(first, ...)` compile to `versions[class of first]`; argument names must be those of `generic`.

    `inline` compiles it into its callers: worth it for small parts of a hot loop, where handing over arrays costs more than the
    work; not for loops over cells, which vectorise better on their own.
    """
    add_choices(generic, versions.items)

    @overload(generic, jit_options=_OPTIONS, strict=False, inline="always" if inline else "never")
    def _choose(*arguments):  # type: ignore[no-untyped-def]
        return versions[arguments[0].instance_class]
