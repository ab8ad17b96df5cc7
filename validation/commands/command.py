"""A command as a Python function, whose signature, docstring and argument checks follow from its class of options."""

import inspect
import textwrap
from collections.abc import Callable, Mapping
from functools import wraps
from inspect import Parameter, Signature
from typing import Any, TypeVar

from slipwave.errors import NumericsError, SceneError
from slipwave.packages import ended
from validation.commands.options import SceneOptions, options_of
from validation.commands.result import Result, Stopped

_Answer = TypeVar("_Answer")


def command(compute: Callable[[Any, Any], _Answer]) -> Callable[..., _Answer]:
    """`compute` (source, options) as a function of a source and keywords; `__wrapped__` is `compute` itself.

    The function raises SceneError for unknown arguments and for wrong types. For a failed result it raises NumericsError, or
    Stopped if the user stopped it, with the result as `result`."""
    kind: type[SceneOptions] = compute.__annotations__["options"]
    known = options_of(kind)
    first = inspect.signature(compute).parameters["source"]
    keywords = [
        Parameter(one.name, _kind(one.more), default=Parameter.empty if one.is_required else one.default, annotation=one.hint)
        for one in known.values()
        if one.is_in("python")
    ]
    signature = Signature([first, *keywords, Parameter("changes", Parameter.VAR_KEYWORD, annotation=Any)])

    @wraps(compute)
    def call(*given: Any, **named: Any) -> _Answer:
        try:
            bound = signature.bind(*given, **named).arguments
        except TypeError as error:
            raise SceneError(f"{compute.__name__}: {error}") from None
        source, changes = bound.pop("source", first.default), bound.pop("changes", {})
        options = kind(**{name: known[name].checked(value) for name, value in bound.items()}, changes=changes)
        try:
            result = compute(source, options.load_own())
        except SystemExit as end:
            raise ended(end) from end
        if isinstance(result, Result) and (result.failed or result.stopped):
            raise (Stopped if result.stopped else NumericsError)(result.failed, result)
        return result

    call.__signature__ = signature.replace(return_annotation=compute.__annotations__["return"])  # type: ignore[attr-defined]
    call.__doc__ = f"{inspect.cleandoc(compute.__doc__ or '')}\n\n{_section(known)}"
    return call


def _kind(more: Mapping[str, Any]) -> Any:
    return Parameter.POSITIONAL_OR_KEYWORD if more.get("positional") else Parameter.KEYWORD_ONLY


def _section(known: Mapping[str, Any]) -> str:
    """The section of a docstring on the options."""
    lines = [f"{one.name}: {one.help}" for one in known.values() if one.is_in("python")]
    lines.append("changes: of the scene, as those of `slipwave.read_scene`")
    return "\n".join(
        ["Options:", *(textwrap.fill(line, 120, initial_indent="    ", subsequent_indent="        ") for line in lines)]
    )
