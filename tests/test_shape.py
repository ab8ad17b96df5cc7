"""The shape of the house: short files and functions, few parameters, no public name twice, finished objects."""

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
COMPILED = ("njit", "allocating", "inlined", "by_class", "register_jitable", "intrinsic")
ROLES = {"run", "answer", "main"}
"""What every study, and every program, calls its own."""
OF_LIBRARIES = {
    "dispatcher._cache", "dispatcher.get_call_template", "dispatcher.get_overload", "dispatcher._compiler._get_implementation",
    "dispatcher.compile",
    "_brief.maxstring", "_brief.maxother", "_brief.maxlevel", "_brief.maxlist", "_brief.maxdict", "_brief.maxtuple",
    "node.body",
    "sys.stdout", "sys.stderr", "sys.unraisablehook", "context.Process", "process._Popen",
    "environment.filters", "environment.globals", "os.environ", "xml.SubElement(case, 'system-out').text",
    "call.__doc__", "call.__signature__", "call.__annotations__", "kind.__name__",
    "mark.until", "work.until",
    "differences[name].attrs", "differences['other_regime'].attrs",
}  # fmt: skip
"""Attributes that numba, reprlib, ast, jinja2, Python and scipy expect their users to set, or for which they have no option; and
`until` of a mark and of the progress, the end of the stretch of a run that has just begun."""


def test_no_file_has_more_than_500_lines():
    assert [name for name, path in FILES.items() if len(path.read_text().splitlines()) > 500] == []


def test_no_function_has_more_than_60_lines():
    assert [place for place, node in FUNCTIONS if (node.end_lineno or 0) - node.lineno >= 60] == []


def test_no_function_has_more_than_8_parameters_or_9_if_compiled():
    def most(node):
        names = [ast.unparse(decorator) for decorator in node.decorator_list]
        return 9 if any(name.startswith(COMPILED) or ".register(" in name for name in names) else 8

    def count(node):
        own = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
        return len([one for one in own if one.arg not in ("self", "cls", "typing")])  # an intrinsic's `typing` is numba's

    assert [f"{place}: {count(node)}" for place, node in FUNCTIONS if count(node) > most(node)] == []


def test_a_public_name_is_defined_once():
    places = defaultdict(set)
    for file, tree in TREES.items():
        for node in tree.body:
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                places[node.name].add(file)
    assert {name: sorted(files) for name, files in places.items() if len(files) > 1 and name not in ROLES} == {}


def test_a_name_of_a_module_is_given_once():
    """A constant that is given again farther down is silently another one for the functions above."""

    def given(node):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        names = [one for target in targets for one in (target.elts if isinstance(target, ast.Tuple) else [target])]
        return [one.id for one in names if isinstance(one, ast.Name)]

    counts = {file: Counter(name for node in tree.body for name in given(node)) for file, tree in TREES.items()}
    assert [f"{file}: {name}" for file, found in counts.items() for name, count in found.items() if count > 1] == []


def attributes_set(tree):
    """Attributes that a program sets of anything but `self`, as `solver.step`."""
    nodes = (node for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store | ast.Del))
    return {name for name in map(ast.unparse, nodes) if not name.startswith("self.") or name.count(".") > 1}


def test_no_program_edits_what_it_did_not_make():
    assert set().union(*map(attributes_set, TREES.values())) == OF_LIBRARIES
    edit = "def march(self, solver):\n    self.time = 1\n    solver.step *= 2\n    self.solver.step, other = 1, 2\n"
    assert attributes_set(ast.parse(edit)) == {"solver.step", "self.solver.step"}
