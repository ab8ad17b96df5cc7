"""Identifies a user's functions in compiled code by their bytecode and by the values that they name, which numba freezes.

A file of the project is known by its text (`slipwave.sources`). A user's file may compute its constants in any way; therefore its
functions are identified as they are when compiled.
"""

import inspect
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any

import numpy as np

from slipwave.sources import inside

_LIBRARIES = ("math", "cmath", "numpy")
_PLAIN = (bool, int, float, complex, str, bytes, type(None))


class _Unknown(Exception):
    """A value that may enter compiled code and that has no known text."""


def frozen_parts(things: Iterable[Any]) -> tuple[str, frozenset[Path]] | None:
    """The functions and classes `things` of a user in compiled code as text, and the files of the project that they call; None if
    a value has no known text.

    Known are numbers, texts, arrays, tuples of them, functions of math and numpy, named tuples of an imported module, and
    functions that name nothing else.
    """
    walks = [(_Walk(), thing) for thing in things]  # one for each, so that their order changes nothing
    try:
        text = "\n".join(sorted("\n".join(walk.value(thing)) for walk, thing in walks))
    except _Unknown:
        return None
    return text, frozenset().union(*(walk.files for walk, _ in walks))


class _Walk:
    """Collects the values that a function names, visiting each function once."""

    def __init__(self) -> None:
        self.files: set[Path] = set()
        self._met: set[FunctionType] = set()

    def value(self, value: Any) -> Iterator[str]:
        """Parts of the text of any value. Raises _Unknown."""
        value = getattr(value, "py_func", value)
        match value:
            case FunctionType():
                yield from self._function(value)
            case type():
                yield from self._named_tuple(value)
            case tuple():
                yield str(len(value))
                for part in value:
                    yield from self.value(part)
            case np.ndarray() if value.dtype != object:
                yield f"{value.dtype} {value.shape} {value.tobytes().hex()}"
            case ModuleType() | BuiltinFunctionType() | np.ufunc() if _library(value) in _LIBRARIES:
                yield f"{_library(value)} {value.__name__}"
            case _ if type(value) in _PLAIN or isinstance(value, np.generic):
                yield f"{type(value).__name__} {value!r}"
            case _:
                raise _Unknown

    def _function(self, function: FunctionType) -> Iterator[str]:
        path = Path(function.__code__.co_filename).resolve()
        if inside(path):
            self.files.add(path)
        elif function not in self._met:
            self._met.add(function)
            code = function.__code__
            yield f"{code.co_name} {code.co_code.hex()} {code.co_names} {code.co_varnames} {code.co_freevars}"
            yield from self.value(code.co_consts)
            yield from self.value((function.__defaults__, *sorted((function.__kwdefaults__ or {}).items())))
            named = inspect.getclosurevars(function)
            for name, value in sorted({**named.globals, **named.nonlocals}.items()):
                yield name
                yield from self.value(value)

    def _named_tuple(self, kind: type) -> Iterator[str]:
        home = sys.modules.get(kind.__module__)
        if kind.__module__ == "__main__" or getattr(home, kind.__qualname__, None) is not kind or not hasattr(kind, "_fields"):
            raise _Unknown
        yield f"{kind.__module__}.{kind.__qualname__} {kind._fields}"


def _library(value: Any) -> str:
    if isinstance(value, np.ufunc):
        return "numpy"
    name = value.__name__ if isinstance(value, ModuleType) else value.__module__
    return str(name).partition(".")[0]
