"""A random sample of small changes: how many does the test suite notice?  `make mutants`, or `python -m tests.faults.mutants`.

Every place of the four rooms where an operator below applies is equally likely; the sample depends on the seed only. Strings are
left alone. Tests that run the changed function (`reach` says which) and those beside them are tried, some seconds of them first
and then the others; with `--whole` the whole suite for those that survive.
"""

import argparse
import ast
import copy as copies
import json
import math
import random
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from slipwave.sources import imported_names
from tests.faults.planting import FOLDER, ROOMS, ROOT
from tests.faults.programme import CHECK_SECONDS, SUITE_SECONDS, Record, Store, run_all
from tests.faults.trial import WHOLE_SUITE, Copy

RESULT = ROOT / "reports" / "mutants.json"
EQUIVALENT = FOLDER / "equivalent.toml"
_FIRST_SECONDS, _ALL_SECONDS = 20.0, 180.0
_FIRST_TESTS, _ALL_TESTS = 60, 400
_READ_EVERY_FILE = ("tests/test_settings.py",)
_SWAPS: dict[type, tuple[type, ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Add: (ast.Sub,),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div,),
    ast.Div: (ast.Mult,),
    ast.Pow: (ast.Mult,),
    ast.FloorDiv: (ast.Div,),
    ast.Mod: (ast.Mult,),
    ast.And: (ast.Or,),
    ast.Or: (ast.And,),
}


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

    @property
    def decided_by(self) -> list[str]:
        """The changed file."""
        return [self.file]


def all_mutants(root: Path = ROOT) -> list[Mutant]:
    """Every mutant of the four rooms."""
    files = (path for room in ROOMS for path in sorted((root / room).rglob("*.py")))
    return [m for path in files for m in mutants_of(path.relative_to(root).as_posix(), path.read_text(encoding="utf-8"))]


def mutants_of(file: str, text: str) -> Iterator[Mutant]:
    """All mutants of one file."""
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    lines = text.splitlines(keepends=True)

    def offset(line: int, column: int) -> int:
        return starts[line - 1] + len(lines[line - 1].encode()[:column].decode())

    for node, function in _changeable(ast.parse(text), ""):
        begin, end = offset(node.lineno, node.col_offset), offset(node.end_lineno, node.end_col_offset)
        for changed in _changes(node):
            new = ast.unparse(changed)
            wrapped = f"({new})" if isinstance(node, ast.BinOp | ast.BoolOp | ast.Compare | ast.UnaryOp) else new
            yield Mutant(file, function, begin, end, text[begin:end], wrapped)


def _changeable(node: ast.AST, function: str) -> Iterator[tuple[Any, str]]:
    """Nodes that run, with the function they lie in; neither annotations nor strings with values in them."""
    for field, value in ast.iter_fields(node):
        if field in ("annotation", "returns", "decorator_list") or isinstance(node, ast.JoinedStr):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue  # of zip: a guard that no right program meets
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                yield from _changeable(child, f"{function}.{child.name}".lstrip("."))
            elif isinstance(child, ast.AST):
                if isinstance(child, ast.expr | ast.stmt):
                    yield child, function
                yield from _changeable(child, function)


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    """The node with one thing wrong."""
    match node:
        case ast.Compare(ops=[only]) if type(only) in _SWAPS:
            for other in _SWAPS[type(only)]:
                yield _with(node, ops=[other()])
        case ast.BinOp(op=op) | ast.AugAssign(op=op) | ast.BoolOp(op=op) if type(op) in _SWAPS and not _is_text(node):
            for other in _SWAPS[type(op)]:
                yield _with(node, op=other())
        case ast.UnaryOp(op=ast.USub() | ast.Not(), operand=operand):
            yield operand
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield ast.Constant(value + 1)
        case ast.Constant(value=float(value)):
            yield ast.Constant(2.0 * value if value else 1.0)
        case ast.Return(value=ast.AST() as value) if not isinstance(value, ast.Constant):
            yield ast.Return(ast.Constant(None))
        case ast.Call(keywords=[_, *_]):
            for number in range(len(node.keywords)):
                if node.keywords[number].arg == "strict":
                    continue
                yield _with(node, keywords=[k for i, k in enumerate(node.keywords) if i != number])


def _with(node: ast.AST, **fields: Any) -> ast.AST:
    changed = copies.copy(node)
    for name, value in fields.items():
        setattr(changed, name, value)
    return changed


def _is_text(node: ast.AST) -> bool:
    return any(
        isinstance(part, ast.JoinedStr) or (isinstance(part, ast.Constant) and isinstance(part.value, str))
        for part in ast.walk(node)
    )


class Reach:
    """What `reach` wrote: for every test its seconds and functions."""

    def __init__(self, folder: Path, still_there: set[str]) -> None:
        noted: dict[str, Any] = {}
        for path in folder.glob("*.json"):
            noted |= json.loads(path.read_text(encoding="utf-8"))
        self._tests = {test: facts for test, facts in noted.items() if test in still_there}

    def tests_for(self, mutant: Mutant) -> tuple[list[str], list[str]]:
        """Tests near the mutant, the nearest and most specific first: some seconds of them, and those of some minutes more."""
        room = Path(mutant.file).parts[0]
        found = self._distances(mutant)
        chosen = sorted(
            found,
            key=lambda test: (
                found[test],
                f"tests/{room}/" not in test,
                len(self._tests[test]["functions"]),
                self._tests[test]["seconds"],
            ),
        )
        first = self._within(chosen, _FIRST_SECONDS, _FIRST_TESTS)
        return first, self._within([test for test in chosen if test not in first], _ALL_SECONDS, _ALL_TESTS)

    def _distances(self, mutant: Mutant) -> dict[str, int]:
        """0 for tests that run the mutant's function, and those that read every file; 1 for those beside them, which may share a
        result with them.

        A function that no test runs in Python is compiled, or runs at import: then 1 for tests that run a function of its file,
        and one more for each import between them and it.
        """
        place = f"{mutant.file}::{mutant.function}"
        found = {test: 0 for test, facts in self._tests.items() if place in facts["functions"]}
        if found:
            beside = {test.partition("::")[0] for test in found}
            found |= {test: 1 for test in self._tests if test not in found and test.partition("::")[0] in beside}
        else:
            far = _imports_between(mutant.file)
            for test, facts in self._tests.items():
                steps = [far[file] for name in facts["functions"] if (file := name.partition("::")[0]) in far]
                if steps:
                    found[test] = 1 + min(steps)
        return found | {test: 0 for test in self._tests if test.partition("::")[0] in _READ_EVERY_FILE}

    def _within(self, tests: list[str], seconds: float, count: int) -> list[str]:
        """At most `count` of `tests`, in their order, that take less than `seconds` together."""
        chosen: list[str] = []
        for test in tests:
            if self._tests[test]["seconds"] < seconds and len(chosen) < count:
                chosen.append(test)
                seconds -= self._tests[test]["seconds"]
        return chosen


def _imports_between(file: str, root: Path = ROOT) -> dict[str, int]:
    """The files that import `file`, with the number of imports on the way to it; itself at 0."""
    steps = {file: 0}
    reached = [file]
    for one in reached:
        for user in _users(root)[one] - steps.keys():
            steps[user] = steps[one] + 1
            reached.append(user)
    return steps


@cache
def _users(root: Path) -> dict[str, set[str]]:
    """The files that import a file of the four rooms by its name."""
    files = [path for room in ROOMS for path in (root / room).rglob("*.py")]
    users: dict[str, set[str]] = {path.relative_to(root).as_posix(): set() for path in files}
    modules = {name.removesuffix(".py").removesuffix("/__init__").replace("/", "."): name for name in users}
    for path in files:
        for name in imported_names(path):
            if name in modules:
                users[modules[name]].add(path.relative_to(root).as_posix())
    return users


def try_mutant(mutant: Mutant, copy: Copy, reach: Reach, whole: bool) -> Record:
    """The record of one mutant: noticed or not, by which test, and whether by an assertion."""
    text = (copy.tree / mutant.file).read_text(encoding="utf-8")
    line = text.count("\n", 0, mutant.begin) + 1
    where = f"{mutant.file}:{line}"
    record: Record = {"name": mutant.name, "room": mutant.file.partition("/")[0], "where": where, "what": mutant.what}
    record["line"] = text.splitlines()[line - 1].strip()
    nearest, others = reach.tests_for(mutant)
    found = None
    with copy.with_text(mutant.file, text[: mutant.begin] + mutant.new + text[mutant.end :]):
        for tests, limit in ((nearest, CHECK_SECONDS), (others, SUITE_SECONDS), (WHOLE_SUITE if whole else [], SUITE_SECONDS)):
            if tests and (found is None or found.is_green):
                found = copy.run(tests, limit)
    if found is None or found.is_green:
        said = "the whole suite stays green" if whole else f"{len(nearest) + len(others)} tests stay green"
        return record | {"caught": False, "says": said, "seconds": round(found.seconds, 1) if found else 0.0}
    by = found.caught or (found.accidents[0] if found.accidents else {"test": "", "says": found.trouble})
    return record | {"caught": True, "caught_by": by["test"], "says": by["says"], "seconds": round(found.seconds, 1)}


def collected() -> set[str]:
    """All tests of the checkout, by their node ids."""
    command = [sys.executable, "-m", "pytest", "--override-ini=addopts=", "--collect-only", "-q", "tests"]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return {line for line in told.stdout.splitlines() if "::" in line}


def is_equivalent(record: Record, listed: list[dict[str, str]]) -> bool:
    """Whether a mutant is listed: by its file, its change and, where the same change can be made in several lines, a text that
    occurs in its line."""
    file = record["where"].partition(":")[0]
    return any(
        (one["file"], one["what"]) == (file, record["what"]) and one.get("line", "") in record.get("line", "") for one in listed
    )


def wilson(noticed: int, of: int) -> tuple[float, float]:
    """95 % interval of a share (Wilson 1927)."""
    z = 1.959964
    share, scale = noticed / of, 1.0 + z * z / of
    half = z * math.sqrt(share * (1.0 - share) / of + z * z / (4.0 * of * of))
    return (share + z * z / (2.0 * of) - half) / scale, (share + z * z / (2.0 * of) + half) / scale


def main() -> int:
    """Try a sample of mutants and print the score with its interval."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults.mutants", description="Score of a random sample of mutants.")
    parser.add_argument("--count", type=int, default=150, metavar="N", help="size of the sample (default: 150)")
    parser.add_argument("--seed", type=int, default=8, metavar="N", help="of the sample (default: 8)")
    parser.add_argument("--jobs", type=int, default=2, metavar="N", help="tried at a time (default: 2)")
    parser.add_argument("--reach", type=Path, required=True, metavar="FOLDER", help="what the plugin `reach` wrote")
    parser.add_argument("--whole", action="store_true", help="the whole suite for those that survive the tests nearest to them")
    options = parser.parse_args()
    everything = all_mutants()
    sample = random.Random(options.seed).sample(everything, options.count)
    print(f"{len(everything)} mutants, sample of {len(sample)}")
    reach = Reach(options.reach, collected())
    store = Store(RESULT, "mutants")
    if options.whole:
        store.forget_survivors()
    records = run_all(sample, lambda mutant, copy: try_mutant(mutant, copy, reach, options.whole), options.jobs, store)
    listed = tomllib.loads(EQUIVALENT.read_text(encoding="utf-8"))["equivalent"]
    judged = [record for record in records if record["caught"] or not is_equivalent(record, listed)]
    noticed = sum(record["caught"] for record in judged)
    low, high = wilson(noticed, len(judged))
    print(f"{len(records) - len(judged)} equivalent ones are left out ({EQUIVALENT.name})")
    print(f"{noticed} of {len(judged)} mutants noticed: {noticed / len(judged):.3f}, 95 % interval {low:.3f} to {high:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
