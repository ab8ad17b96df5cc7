"""Arguments of the door's functions are checked against their annotations: a wrong type is wrong input, as a wrong value is."""

import inspect
import numbers
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from types import NoneType
from typing import Any, ParamSpec, TypeVar, get_args, get_origin

import numpy as np

from slipwave.errors import SceneError
from slipwave.input.wording import listed, shorten

P = ParamSpec("P")
R = TypeVar("R")

_WORDS = {bool: "True or False", int: "a whole number", float: "a number", str: "a text", Path: "a path", NoneType: "None"}
_KINDS: dict[Any, Any] = {bool: bool, int: numbers.Integral, float: numbers.Real}
_READ = ("source", "changes")
"""Arguments whose types are checked where they are read."""


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """`function`, which raises SceneError for arguments that it does not have and for those of another type than it declares.

    Numbers of numpy are taken for those of Python.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def call(*given: P.args, **named: P.kwargs) -> R:
        try:
            bound = signature.bind(*given, **named)
        except TypeError as error:
            raise SceneError(f"{function.__name__}: {error}") from None
        for name, value in bound.arguments.items():
            if name not in _READ:
                hint = signature.parameters[name].annotation
                bound.arguments[name] = value = _plain(value, hint)
                if not _fits(value, hint):
                    raise SceneError(f"{name} = {shorten(value)}: must be {listed(dict.fromkeys(_words(hint)))}")
        return function(*bound.args, **bound.kwargs)

    return call


def _plain(value: Any, hint: Any) -> Any:
    """A number of numpy as one of Python, and what can be read only once as a list."""
    if get_origin(hint) is Iterable and isinstance(value, Iterable) and not isinstance(value, str | Mapping):
        return list(value)
    return value.item() if isinstance(value, np.generic) else value


def _fits(value: Any, hint: Any) -> bool:
    """Whether `value` is of the type that an annotation names."""
    kind, parts = get_origin(hint), get_args(hint)
    if kind is tuple:
        pairs = isinstance(value, tuple | list) and len(value) == len(parts)
        return pairs and all(map(_fits, value, parts))
    if kind is Mapping:
        return isinstance(value, Mapping) and all(_fits(item, parts[1]) for item in value.values())
    if kind in (Iterable, Sequence):
        return isinstance(value, kind) and not isinstance(value, Mapping) and all(_fits(one, parts[0]) for one in value)
    if parts:
        return any(_fits(value, part) for part in parts)
    return isinstance(value, _KINDS.get(hint, hint)) and (hint is bool or not isinstance(value, bool))


def _words(hint: Any) -> Iterable[str]:
    """What an annotation allows, in words."""
    kind, parts = get_origin(hint), get_args(hint)
    if kind is tuple:
        yield f"({', '.join(' or '.join(_words(part)) for part in parts)})"
    elif kind is Mapping:
        yield f"{{a text: {next(iter(_words(parts[1])))}}}"
    elif kind in (Iterable, Sequence):
        yield f"a list of {next(iter(_words(parts[0])))}s".replace("a list of a ", "a list of ")
    elif parts:
        for part in parts:
            yield from _words(part)
    else:
        yield _WORDS[hint]
