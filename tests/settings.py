"""The settings of a module: constants, what fields and parameters are if nothing is given, and what differs between the quick and
the full report. Texts and paths are none.
"""

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from types import LambdaType, ModuleType
from typing import Any

import numpy as np


def settings_of(module: ModuleType) -> Iterator[str]:
    """`module.name = value`, one line for each setting."""
    for name, expression in _settings(ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))):
        value = _evaluated(expression, module, name)
        is_given = any(isinstance(part, ast.Constant) and part.value is not None for part in ast.walk(expression))
        if is_given and not isinstance(value, str | Path | re.Pattern):
            yield f"{module.__name__}.{name} = {_told(value)}"


def _settings(scope: ast.Module | ast.ClassDef, within: str = "") -> Iterator[tuple[str, ast.expr]]:
    """Name and expression."""
    for node in scope.body:
        match node:
            case ast.Assign(value=value) | ast.AnnAssign(value=ast.expr() as value):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names = [one.id for target in targets for one in ast.walk(target) if isinstance(one, ast.Name)]
                if within or any(name.isupper() for name in names):
                    yield within + ", ".join(names), value
            case ast.ClassDef():
                yield from _settings(node, f"{within}{node.name}.")
            case ast.FunctionDef():
                yield from ((f"{within}{node.name}({name})", value) for name, value in _defaults(node.args))
                yield from ((f"{within}{node.name}(quick)", both) for both in _both(node))


def _defaults(arguments: ast.arguments) -> Iterator[tuple[str, ast.expr]]:
    named = [*arguments.posonlyargs, *arguments.args]
    by_place = named[len(named) - len(arguments.defaults) :]
    for parameters, values in ((by_place, arguments.defaults), (arguments.kwonlyargs, arguments.kw_defaults)):
        yield from ((one.arg, value) for one, value in zip(parameters, values, strict=True) if value is not None)


def _both(function: ast.FunctionDef) -> Iterator[ast.expr]:
    """What a function chooses, or is, in the quick and in the full report, if that needs nothing else to be known."""
    if [argument.arg for argument in function.args.args] == ["quick"]:
        yield ast.parse(f"{function.name}(True), {function.name}(False)", mode="eval").body
    for node in ast.walk(function):
        if isinstance(node, ast.IfExp) and ast.unparse(node.test) in ("quick", "budget.quick"):
            known = {name.id for name in ast.walk(node) if isinstance(name, ast.Name) and not name.id.isupper()}
            if known <= {"quick", "budget", "tuple"}:
                yield ast.Tuple([node.body, node.orelse], ast.Load())


def _evaluated(expression: ast.expr, module: ModuleType, name: str) -> Any:
    """As the module evaluates it, within the class that it belongs to."""
    scope: Any = module
    for part in name.partition("(")[0].split(".")[:-1]:
        scope = vars(scope)[part]
    whole = ast.fix_missing_locations(ast.Expression(expression))
    return eval(compile(whole, name, "eval"), vars(module), dict(vars(scope)))


def _told(value: Any) -> str:
    """A setting in numbers; sentences within it are left out, and what is neither is told by its kind."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{_told(key)}: {_told(one)}' for key, one in value.items())}}}"
    if isinstance(value, np.ndarray):
        ends = f" from {value.flat[0]:.12g} to {value.flat[-1]:.12g}" if value.size else ""
        return f"{value.size}{ends}, in all {value.sum():.12g}"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_told, value))})"
    if isinstance(value, set | frozenset):
        return f"({', '.join(sorted(map(_told, value)))})"
    if isinstance(value, str):
        return "…" if " " in value else value
    if isinstance(value, bool | int | range | None):
        return str(value)
    if isinstance(value, float):
        return f"{value:.12g}"
    if is_dataclass(value) and not isinstance(value, type):
        return f"{type(value).__name__}({', '.join(_told(getattr(value, field.name)) for field in fields(value))})"
    if isinstance(value, LambdaType) and value.__code__.co_varnames == ("p",):
        return f"what makes 2 and 7 {_told([value(2), value(7)])}"
    return str(getattr(value, "__name__", type(value).__name__))
