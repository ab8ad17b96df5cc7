"""The shape of the house: no file and no function too long, no function of too many arguments, no public name twice."""

import ast
from collections import Counter, defaultdict

from slipwave.sources import ROOT

ROOMS = ("slipwave", "reduced", "fullwave", "validation")
FILES = {path.relative_to(ROOT).as_posix(): path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))}
TREES = {name: ast.parse(path.read_bytes()) for name, path in FILES.items()}
FUNCTIONS = [
    (f"{name}:{node.lineno} {node.name}", node)
    for name, tree in TREES.items()
    for node in ast.walk(tree)
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
]
COMPILED = ("njit", "allocating", "inlined", "by_class", "register_jitable")
ROLES = {"run", "answer", "main"}
"""What every study, and every program, calls its own."""
TWICE = set(
    """
    Cycle Onset Quantity Run Side Verdict all_verdicts branch_claims column error essential_abscissa
    facts_of mean_table orbit orbit_claims orbit_of planes rates scenes score settled show spread
    steady_state verdicts
    """.split()  # noqa: SIM905
)
"""Public names that are still defined in two files, until one of them is renamed."""
MANY = {"add_rows", "differentiate_rows", "march_lines"}
"""Kernels that still take more."""


def test_no_file_has_more_than_500_lines() -> None:
    assert [name for name, path in FILES.items() if len(path.read_text().splitlines()) > 500] == []


def test_no_function_has_more_than_60_lines() -> None:
    assert [place for place, node in FUNCTIONS if (node.end_lineno or 0) - node.lineno >= 60] == []


def test_no_function_has_more_than_8_parameters_or_9_if_compiled() -> None:
    def most(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
        names = [ast.unparse(decorator) for decorator in node.decorator_list]
        return 9 if any(name.startswith(COMPILED) or ".register(" in name for name in names) else 8

    def count(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
        own = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
        return len([one for one in own if one.arg not in ("self", "cls")])

    assert [f"{place}: {count(node)}" for place, node in FUNCTIONS if count(node) > most(node) and node.name not in MANY] == []


def test_a_public_name_is_defined_once() -> None:
    places = defaultdict(set)
    for file, tree in TREES.items():
        for node in tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].add(file)
    found = {name: sorted(files) for name, files in places.items() if len(files) > 1 and name not in ROLES | TWICE}
    assert found == {}


def test_a_name_of_a_module_is_given_once() -> None:
    """A constant that is given again farther down is silently another one for the functions above."""

    def given(node: ast.stmt) -> list[str]:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        names = [one for target in targets for one in (target.elts if isinstance(target, ast.Tuple) else [target])]
        return [one.id for one in names if isinstance(one, ast.Name)]

    counts = {file: Counter(name for node in tree.body for name in given(node)) for file, tree in TREES.items()}
    assert [f"{file}: {name}" for file, found in counts.items() for name, count in found.items() if count > 1] == []
