"""A fault: one place of one file changed. It is anchored by a qualified name and by text within it, never by a line number."""

import ast
import tomllib
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parent.parent
ROOMS = ("slipwave", "reduced", "fullwave", "validation")


class AnchorError(ValueError):
    """The place of a fault is not there, or not alone."""


@dataclass(frozen=True)
class Fault:
    """`old` becomes `new` within `within` (a function, Class or Class.method; empty: the whole file) of `file`.

    `user` says what it would do to somebody who relies on the program; `check` names the tests (pytest's node ids) that should
    notice first.
    """

    name: str
    file: str
    within: str
    old: str
    new: str
    user: str = ""
    check: tuple[str, ...] = ()

    @property
    def room(self) -> str:
        return self.file.partition("/")[0]

    @property
    def where(self) -> str:
        return f"{self.file}::{self.within}" if self.within else self.file

    @property
    def what(self) -> str:
        return " ".join(f"{self.old.strip()} -> {self.new.strip() or 'nothing'}".split())

    def planted(self, text: str) -> str:
        """The file's text with the fault in it. Raises AnchorError if `old` is not there exactly once, or if nothing changes."""
        begin, end = span(text, self.within)
        if text.count(self.old, begin, end) != 1:
            raise AnchorError(f"{self.name}: {self.old!r} is {text.count(self.old, begin, end)} times in {self.where}")
        at = text.index(self.old, begin)
        changed = text[begin:at] + self.new + text[at + len(self.old) : end]
        if self.file.endswith(".py") and _program(changed) == _program(text[begin:end]):
            raise AnchorError(f"{self.name}: the program is the same after the change")
        return text[:begin] + changed + text[end:]


def read_faults(folder: Path = FOLDER) -> list[Fault]:
    return [
        Fault(**{**record, "check": tuple(record["check"])})
        for room in ROOMS
        for record in tomllib.loads((folder / f"{room}.toml").read_text(encoding="utf-8"))["fault"]
    ]


def span(text: str, name: str) -> tuple[int, int]:
    """Where the definition of `name` begins and ends in `text`, decorators included."""
    if not name:
        return 0, len(text)
    node = _named(ast.parse(text), name)
    starts = [0, *accumulate(map(len, text.splitlines(keepends=True)))]
    first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
    return starts[first - 1], starts[node.end_lineno or node.lineno]


def _program(lines: str) -> str:
    """What Python makes of a file, or of an indented definition."""
    return ast.dump(ast.parse(f"if True:\n{lines}" if lines[:1].isspace() else lines))


def _named(tree: ast.Module, name: str) -> ast.Module | ast.FunctionDef | ast.ClassDef:
    scope: ast.Module | ast.FunctionDef | ast.ClassDef = tree
    for part in filter(None, name.split(".")):
        inner = (n for n in ast.walk(scope) if isinstance(n, ast.FunctionDef | ast.ClassDef) and n is not scope)
        found = next((n for n in inner if n.name == part), None)
        if found is None:
            raise AnchorError(f"there is no {name}")
        scope = found
    return scope
