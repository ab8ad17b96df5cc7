"""Digests of programs; the compile cache: warm when nothing changed, compiled again where an edit reaches, never in the way."""

import ast
import math
import os
import pickle
import resource
import shutil
import subprocess
import sys

import numpy as np
import pytest

from slipwave import sources
from slipwave.compiled import cache as compile_cache
from slipwave.compiled import inlined, njit
from slipwave.compiled.parts import PartCompiler
from slipwave.observe.detector import _size_of
from slipwave.sources import ROOT, SOLVER_PACKAGES, import_closure, program
from tests.test_shape import FUNCTIONS, TREES

SWING = np.array([1.0, 2.0, 3.5])
ANSWER = 1.5
PROGRAM = """
import numpy as np
from slipwave.observe.detector import _size_of
swing = np.array([1.0, 2.0, 3.5])
for _ in range(2):
    print(_size_of(swing), _size_of(swing.astype(np.float32)))
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache in a process that has not complained yet."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compile_cache.TROUBLE, "has_warned", False)
    monkeypatch.setattr(compile_cache.TROUBLE, "is_writing", True)
    return tmp_path


def ask(swing=SWING):
    """Answer of a fresh compiled function, and whether it came from the disk."""
    fresh = njit(_size_of.py_func)
    return fresh(swing), sum(fresh.stats.cache_hits.values())


def kept(folder):
    """The file of the function that Python calls; that of its part is for compiled callers."""
    (path,) = (path for path in folder.iterdir() if "-part-" not in path.name)
    return path


@pytest.mark.parametrize("share", [0.0, 0.001, 0.3, 0.999])
def test_a_truncated_file_is_told_and_replaced(share, folder, capsys):
    ask()
    whole = kept(folder).read_bytes()
    kept(folder).write_bytes(whole[: int(share * len(whole))])
    assert ask() == (ANSWER, 0)
    assert capsys.readouterr().err.count("damaged file") == 1
    assert ask() == (ANSWER, 1)


def test_a_change_of_any_byte_or_of_the_name_is_noticed(folder):
    ask()
    path = kept(folder)
    whole = path.read_bytes()
    for place in range(0, len(whole), 211):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << place % 8
        with pytest.raises(ValueError, match="digest"):
            compile_cache.checked(bytes(damaged), path.name)
    with pytest.raises(ValueError, match="digest"):
        compile_cache.checked(whole, "x" + path.name)
    path.write_bytes(bytes(damaged))
    assert ask() == (ANSWER, 0)


def test_a_part_on_the_disk_is_not_compiled_again(folder, monkeypatch):
    ask()
    kept(folder).unlink()
    monkeypatch.setattr(PartCompiler, "compile_extra", None)
    assert ask() == (ANSWER, 0)


def test_code_for_other_types_is_kept_apart(folder):
    swings = SWING, SWING.astype(np.float32)
    assert [ask(swing) for swing in swings] == [(ANSWER, 0)] * 2
    assert len(list(folder.glob("*-part-*"))) == 2
    assert len(list(folder.iterdir())) == 4
    assert [ask(swing) for swing in swings] == [(ANSWER, 1)] * 2


def run(environment, limit=None):
    """A process of its own that compiles a function for two types."""
    return subprocess.run(
        [sys.executable, "-c", PROGRAM], env=os.environ | environment, capture_output=True, text=True, preexec_fn=limit
    )


def _full_disk():
    resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))


@pytest.mark.parametrize("trouble", ["a file in its place", "a full disk", "nowhere"])
def test_a_run_without_a_usable_folder_ends_well(trouble, folder):
    place = folder / "cache"
    if trouble == "a file in its place":
        place.write_text("not a folder")
    where = {"NUMBA_CACHE_DIR": "/dev/null/cache" if trouble == "nowhere" else str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    done = run(where, _full_disk if trouble == "a full disk" else None)
    assert (done.returncode, done.stdout) == (0, "1.5 1.5\n" * 2), done.stderr
    assert done.stderr.startswith("slipwave: the cache of compiled code in ")
    assert done.stderr.count("\n") == 1


def test_a_file_edited_since_the_process_began_keeps_its_functions_off_the_disk(folder, monkeypatch):
    monkeypatch.setattr(compile_cache, "STARTED", 0.0)
    assert [ask(), ask()] == [(ANSWER, 0)] * 2
    assert list(folder.iterdir()) == []


# one function for each way in which compiled code takes in code of another file
PROBES = {
    "called": """
from slipwave.compiled import njit
from slipwave.observe.extrema import bounds

@njit
def probe(knots):
    return bounds(knots)[1]
""",
    "inlined": """
from slipwave.compiled import njit
from slipwave.friction.interface import solve_interface

@njit
def probe(law):
    return solve_interface(law, 1e-5, 0.4, 0.1, 0.0)[0]
""",
    "overloaded": """
from slipwave.compiled import njit
from slipwave.friction.law import respond

@njit
def probe(law):
    return respond(law, 0.3, 0.1)[2]
""",
    "dispatched": """
from fullwave.lines.system import total_stress
from slipwave.compiled import njit

@njit
def probe(medium, state):
    return total_stress(medium, 1, state, state, 0)
""",
}
ASK_ALL = """
import numpy as np
from fullwave.lines.system import Elastic
from slipwave import called, inlined, overloaded, dispatched
from slipwave.friction.ageing import Ageing
law, knots = Ageing(0.369, 0.0349, 0.0489), np.array([1.0, 2.0, 4.0])
given = {called: (knots,), inlined: (law,), overloaded: (law,), dispatched: (Elastic(), knots)}
for module, arguments in given.items():
    value = module.probe(*arguments)
    print(module.__name__.split(".")[1], value, sum(module.probe.stats.cache_hits.values()))
"""
# the places that are edited at once, as (file, old, new); every probe whose module imports one of the files is compiled again
EDITS = {
    "called inlined dispatched": [
        ("slipwave/observe/extrema.py", "return bottom, top\n", "return bottom, 2.0 * top\n"),
        ("slipwave/friction/interface.py", "impedance * v - incoming", "impedance * v - 1.01 * incoming"),
        ("fullwave/lines/system.py", "return state[slot]\n", "return 2.0 * state[slot]\n"),
    ],
    "overloaded inlined dispatched": [("slipwave/friction/ageing.py", "law.a_star + law.a * z", "law.a_star - law.a * z")],
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the solver rooms with the probes in it, its cache warm."""
    folder = tmp_path_factory.mktemp("tree")
    for room in SOLVER_PACKAGES:
        shutil.copytree(ROOT / room, folder / room, ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in PROBES.items():
        (folder / "slipwave" / f"{name}.py").write_text(text)
    assert {hits for _, hits in ask_all(folder).values()} == {0}
    return folder


@pytest.fixture(scope="module")
def untouched(tree):
    return ask_all(tree)


def ask_all(tree):
    """Value and hits in the cache of every probe, in a process of its own."""
    environment = os.environ | {"PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(tree / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([sys.executable, "-c", ASK_ALL], cwd=tree, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return {name: (float(value), int(hits)) for name, value, hits in map(str.split, done.stdout.splitlines())}


def ask_with(tree, places):
    """The same with some places changed."""
    kept = {tree / file: (tree / file).read_text() for file, _, _ in places}
    for file, old, new in places:
        assert kept[tree / file].count(old) == 1
        (tree / file).write_text(kept[tree / file].replace(old, new))
    try:
        return ask_all(tree)
    finally:
        for path, text in kept.items():
            path.write_text(text)


@pytest.mark.parametrize("reached", EDITS)
def test_an_edited_formula_is_compiled_again_and_nothing_else_is(reached, tree, untouched):
    edited = ask_with(tree, EDITS[reached])
    assert {name for name, (_, hits) in edited.items() if not hits} == set(reached.split())
    changed = {name for name, (value, _) in edited.items() if value != pytest.approx(untouched[name][0], rel=1e-3)}
    assert changed == set(reached.split()) - ({"dispatched"} if "overloaded" in reached else set())


def test_an_edited_comment_or_docstring_compiles_nothing(tree, untouched):
    told = '"""Root z of'
    assert ask_with(tree, [("slipwave/friction/interface.py", told, '"""\n\n    The one root z of')]) == untouched


def test_every_choice_made_at_compile_time_is_declared_to_the_cache():
    for file, tree in TREES.items():
        called = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        if called & {"overload", "generated_jit", "overload_method", "overload_attribute", "lower_builtin"}:
            assert "add_choices" in called, file


COMPILED = ("njit", "inlined", "by_class", "register_jitable")
"""Decorators of functions whose arrays belong to their caller."""


def borrows(function):
    names = [ast.unparse(decorator) for decorator in function.decorator_list]
    return any(name.startswith(COMPILED) or ".register(" in name for name in names)


def owned(function):
    """What a function makes or returns that would have to be released: results of numpy, and all but numbers."""
    within = [node for statement in function.body for node in ast.walk(statement)]
    made = {ast.unparse(node.func) for node in within if isinstance(node, ast.Call)}
    returned = [node for node in ast.walk(function.returns or ast.Constant(None)) if isinstance(node, ast.Name)]
    arrays = {node.id for node in returned} - {"tuple", "int", "float", "bool", "Response", "Law"}
    return {name for name in made if name.startswith("np.") or name.endswith(".copy")} | arrays


def test_a_function_that_counts_no_references_makes_and_returns_no_array():
    found = {place: owned(node) for place, node in FUNCTIONS if isinstance(node, ast.FunctionDef) and borrows(node)}
    assert {place: names for place, names in found.items() if names} == {}, "must be `allocating`"
    texts = "@njit\ndef new(x: A) -> float:\n  return np.zeros(3)[0]", "@inlined\ndef same(x: Array) -> Array:\n  return x"
    new, same = (ast.parse(text).body[0] for text in texts)
    assert [(borrows(one), owned(one)) for one in (new, same)] == [(True, {"np.zeros"}), (True, {"Array"})]


def test_the_cache_of_a_users_own_compiled_functions_is_left_alone():
    program = (
        "import numba; before = numba.config.CACHE_DIR; import slipwave.scene.drive; assert numba.config.CACHE_DIR == before"
    )
    environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    assert subprocess.run([sys.executable, "-c", program], env=environment).returncode == 0


def test_a_division_by_zero_is_a_number_and_no_exception():
    """A step that is too long meets one: it is refused and halved, and compiled code must get that far."""
    quotient = njit(lambda x, y: x / y)
    assert quotient(1.0, 0.0) == math.inf
    assert math.isnan(quotient(0.0, 0.0))
    assert inlined(lambda x, y: x / y)(1.0, 0.0) == math.inf


def closure(file, packages=True):
    return {path.relative_to(ROOT).as_posix() for path in import_closure([ROOT / file], packages)}


def test_imports_are_followed_through_modules_packages_and_functions():
    found = closure("slipwave/friction/interface.py", packages=False)
    assert {
        "slipwave/friction/interface.py",
        "slipwave/compiled/functions.py",
        "slipwave/friction/__init__.py",
        "slipwave/friction/slip.py",
    } <= found
    assert "slipwave/friction/check.py" in found  # imported within `register`
    assert not found & {"slipwave/__init__.py", "slipwave/input/assemble.py", "slipwave/scene/scene.py"}


@pytest.mark.parametrize(
    ("other", "same"),
    [
        ('"""Other."""\n\n\n# a comment\ndef f(x):\n    """Told."""\n    return x + 1\n', True),
        ("def f(x):\n    return (x +\n            1)\n", True),
        ("def f(x):\n    return x + 2\n", False),
        ("def f(x):\n    return x - 1\n", False),
        ("def f(y):\n    return y + 1\n", False),
        ("def f(x=0):\n    return x + 1\n", False),
    ],
)
def test_a_digest_sees_the_program_only(other, same, tmp_path):
    texts = "def f(x):\n    return x + 1\n", other
    for number, text in enumerate(texts):
        (tmp_path / f"{number}.py").write_text(text)
    assert (program(tmp_path / "0.py") == program(tmp_path / "1.py")) is same


@pytest.mark.parametrize("room", ["slipwave", "reduced", "fullwave"])
def test_the_digest_of_the_solvers_sees_each_of_their_rooms(room, monkeypatch):
    digest = sources.source_digest.__wrapped__  # not the one that this process keeps
    before, read = digest(), sources.program
    edited = min((ROOT / room).rglob("*.py"))
    monkeypatch.setattr(sources, "program", lambda path: read(path) + "edited" * (path == edited))
    assert digest() != before


@pytest.fixture
def started_again(tmp_path, monkeypatch):
    """Forgets what this process has read, as at the start of another one; its files are kept in a folder of this test."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.setattr(sources, "_NEW", {})

    def forget():
        sources._read.cache_clear()
        sources._kept.cache_clear()

    forget()
    yield forget
    forget()


def test_a_text_is_parsed_once_for_all_processes_and_again_when_it_is_edited(started_again, tmp_path, monkeypatch):
    path, parsed, parse = tmp_path / "program.py", [], sources._parsed
    monkeypatch.setattr(sources, "_parsed", lambda content: parsed.append(content) or parse(content))
    texts = [b"import slipwave\n", b"import slipwave\n", b"import reduced\n", b"import slipwave\n"]
    for text in texts:
        path.write_bytes(text)
        assert sources.imported_names(path) == (text.split()[1].decode(),)
        sources._keep()
        started_again()
    assert parsed == [texts[0], texts[2]]


@pytest.mark.parametrize(
    "spoilt",
    [lambda content: content[:-20], lambda content: pickle.dumps({key: tuple(one) for key, one in sources._kept().items()})],
    ids=["damaged", "kept by another version"],
)
def test_what_is_kept_in_another_form_is_parsed_again_and_replaced(spoilt, started_again, tmp_path):
    path = tmp_path / "program.py"
    path.write_text("x = 1\n")
    whole = program(path)
    sources._keep()
    (kept,) = (tmp_path / "kept").iterdir()
    kept.write_bytes(spoilt(kept.read_bytes()))
    started_again()
    assert program(path) == whole
    sources._keep()
    started_again()
    assert len(sources._kept()) == 1
