"""The single small changes that make a mutant: the operators of cosmic-ray (Bingham, https://cosmic-ray.readthedocs.io).

Left out are replacements that arithmetic or an order can only crash on (bit operators, identity) and changes of a guard or of
speed alone: `strict` of zip, decorators that compile or keep results. Annotations and strings are left alone.
"""

import ast
import copy as copies
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from typing import Any

from tests.faults.planting import ROOMS, ROOT

_ORDERS = (ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE)
_ARITHMETIC = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow)
_BITS = (ast.BitOr, ast.BitAnd, ast.BitXor)
_PAIRS = ((ast.Is, ast.IsNot), (ast.In, ast.NotIn), (ast.And, ast.Or))
_FAMILIES: tuple[tuple[type, ...], ...] = (_ORDERS, _ARITHMETIC, _BITS, *_PAIRS)
_SPEED_OR_GUARD = {"cache", "lru_cache", "njit", "inlined", "abstractmethod"}


@dataclass(frozen=True)
class Mutant:
    """Characters [begin, end) of `file` become `new`; `function` is the one they lie in."""

    file: str
    function: str
    begin: int
    end: int
    old: str
    new: str

    @property
    def name(self) -> str:
        """Unique for a state of the file."""
        return f"{self.file}:{self.begin}:{self.new}"

    @property
    def what(self) -> str:
        """The change in one line."""
        return " ".join(f"{self.old} -> {self.new}".split())

    def line_number(self, text: str) -> int:
        """Where it begins in the text of its file."""
        return text.count("\n", 0, self.begin) + 1

    @property
    def decided_by(self) -> list[str]:
        """The changed file."""
        return [self.file]


def all_places(root: Path = ROOT) -> list[list[Mutant]]:
    """Every place of the four rooms that an operator changes, with its mutants."""
    files = (path for room in ROOMS for path in sorted((root / room).rglob("*.py")))
    return [place for path in files for place in places_of(path.relative_to(root).as_posix(), path.read_text(encoding="utf-8"))]


def mutants_of(file: str, text: str) -> list[Mutant]:
    """All mutants of one file."""
    return [mutant for place in places_of(file, text) for mutant in place]


def places_of(file: str, text: str) -> Iterator[list[Mutant]]:
    """The mutants of each place of one file."""
    lines = text.splitlines(keepends=True)
    starts = [0, *accumulate(map(len, lines))]

    def offset(line: int, column: int) -> int:
        return starts[line - 1] + len(lines[line - 1].encode()[:column].decode())

    def mutants(node: Any, function: str, changed: list[str]) -> list[Mutant]:
        begin, end = offset(node.lineno, node.col_offset), offset(node.end_lineno, node.end_col_offset)
        return [Mutant(file, function, begin, end, text[begin:end], one) for one in changed]

    for node, function in _nodes(ast.parse(text), ""):
        for target, changes in ((target, changes) for target, changes in _places(node) if changes):
            yield mutants(target, function, [_source(target, change) for change in changes])
        for decorator in getattr(node, "decorator_list", []):
            if not {part.id for part in ast.walk(decorator) if isinstance(part, ast.Name)} & _SPEED_OR_GUARD:
                yield mutants(decorator, f"{function}.{node.name}".lstrip("."), ["(lambda same: same)"])


def _source(node: ast.AST, change: ast.AST) -> str:
    joined = isinstance(node, ast.BinOp | ast.BoolOp | ast.Compare | ast.UnaryOp) or isinstance(change, ast.UnaryOp)
    return f"({ast.unparse(change)})" if joined else ast.unparse(change)


def _nodes(node: ast.AST, function: str) -> Iterator[tuple[Any, str]]:
    """Nodes that run, with the function they lie in."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list") or isinstance(node, ast.JoinedStr):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue
            if isinstance(child, ast.expr | ast.stmt | ast.ExceptHandler):
                yield child, function
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                yield from _nodes(child, f"{function}.{child.name}".lstrip("."))
            elif isinstance(child, ast.AST):
                yield from _nodes(child, function)


def _places(node: ast.AST) -> Iterator[tuple[ast.AST, list[ast.AST]]]:
    """What an operator changes in a node, and the things that may stand there instead."""
    match node:
        case ast.Compare(ops=ops):
            for number, op in enumerate(ops):
                yield node, [_with(node, ops=[*ops[:number], other(), *ops[number + 1 :]]) for other in _others(op)]
        case ast.BinOp(op=op) | ast.AugAssign(op=op) | ast.BoolOp(op=op) if not _is_text(node):
            yield node, [_with(node, op=other()) for other in _others(op)]
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield node, [operand]
        case ast.Constant(value=bool(value)):
            yield node, [ast.Constant(not value)]
        case ast.Constant(value=int() | float() | complex() as value):
            yield node, [ast.Constant(value + 1), ast.Constant(value - 1)]
        case ast.If(test=test) | ast.While(test=test) | ast.IfExp(test=test) | ast.Assert(test=test):
            yield test, [ast.UnaryOp(ast.Not(), test)]
        case ast.For(iter=items):
            yield items, [ast.List([], ast.Load())]
        case ast.Break() | ast.Continue():
            yield node, [ast.Continue() if isinstance(node, ast.Break) else ast.Break()]
        case ast.ExceptHandler(type=ast.expr() as kind):
            yield kind, [ast.Name("UnboundLocalError")]


def _others(op: ast.AST) -> list[type]:
    return [other for family in _FAMILIES if type(op) in family for other in family if type(op) is not other]


def _with(node: ast.AST, **fields: Any) -> ast.AST:
    changed = copies.copy(node)
    for name, value in fields.items():
        setattr(changed, name, value)
    return changed


def _is_text(node: ast.AST) -> bool:
    return any(isinstance(part, ast.JoinedStr) or isinstance(getattr(part, "value", None), str) for part in ast.walk(node))
