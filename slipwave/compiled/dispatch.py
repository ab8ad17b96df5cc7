"""Choose an implementation by the class of the first argument, in plain Python and, at compile time, in compiled code.

A slab's medium and its face are NamedTuples. The kernel calls `strain(medium)`, and numba compiles in only the version for that
class, so a rigid face or a uniform slab costs nothing for the grips and layers of other scenes.
"""

from collections.abc import Callable
from functools import singledispatch
from typing import Any, ParamSpec, Protocol, TypeVar, cast

from numba.extending import overload

from slipwave.compiled.cache import add_choices
from slipwave.compiled.parts import PartCompiler

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer", covariant=True)
Version = TypeVar("Version", bound=Callable[..., Any])

_OPTIONS = {"error_model": "numpy", "fastmath": {"contract"}, "no_cfunc_wrapper": True, "pipeline_class": PartCompiler}


class ByClass(Protocol[Arguments, Answer]):
    """A function with a version for each class of its first argument, as `functools.singledispatch` makes it."""

    def __call__(self, *arguments: Arguments.args, **options: Arguments.kwargs) -> Answer:
        """Call the version for the first argument's class."""

    def register(self, kind: type) -> Callable[[Version], Version]:
        """Decorator of the version for the class `kind`."""


def by_class(inline: bool = False) -> Callable[[Callable[Arguments, Answer]], ByClass[Arguments, Answer]]:
    """Decorator of a function whose versions are registered class by class; its own body is the version of all other classes.

    `inline` has LLVM inline it. This pays for small parts of a hot loop, where passing arrays costs more than the work;
    it does not for loops over cells, which vectorise better in a function of their own.
    """

    def _decorate(function: Callable[Arguments, Answer]) -> ByClass[Arguments, Answer]:
        generic = singledispatch(function)
        add_choices(function, generic.registry.items)

        @overload(generic, jit_options={**_OPTIONS, "forceinline": inline}, strict=False)
        def _choose(*arguments):  # type: ignore[no-untyped-def]
            return generic.dispatch(arguments[0].instance_class)

        return cast(ByClass[Arguments, Answer], generic)

    return _decorate
