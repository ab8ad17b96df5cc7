"""The programme of planted faults: anchors hold, the original stays as it is, and a fault that no test notices survives."""

import ast
import json
import tomllib
from functools import cache

import pytest

from tests.faults.mutants import EQUIVALENT, is_equivalent, sample, wilson
from tests.faults.mutations import Mutant, mutants_of, places_of
from tests.faults.nearest import Reach
from tests.faults.planting import ROOMS, ROOT, AnchorError, Fault, read_faults
from tests.faults.programme import Store, key_of, try_fault
from tests.faults.trial import Copy

FAULTS = read_faults()
EQUIVALENTS = tomllib.loads(EQUIVALENT.read_text(encoding="utf-8"))["equivalent"]


@cache
def functions_in(file):
    return {node.name for node in ast.walk(ast.parse((ROOT / file).read_bytes())) if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_every_fault_still_has_its_place_and_its_check(fault):
    text = (ROOT / fault.file).read_text(encoding="utf-8")
    assert fault.planted(text) != text
    assert fault.user
    assert fault.check
    for check in fault.check:
        file, _, name = check.partition("::")
        assert name.partition("[")[0] in functions_in(file) | {""}


def test_names_differ_and_every_room_has_faults():
    assert len({fault.name for fault in FAULTS}) == len(FAULTS) >= 139
    assert {fault.room for fault in FAULTS} == set(ROOMS)


SUM = "def total(values):\n    return sum(values)\n\n\ndef count(values):\n    return len(values)\n"
SETTINGS = "[tool.pytest.ini_options]\nmarkers = ['slow']\n"
TEST = "from slipwave.sums import total\n\ndef test_total():\n    assert total([1, 2]) == 3\n"


def fault(old, new, within="total"):
    return Fault("small", "slipwave/sums.py", within, old, new, "wrong sums", ("tests/test_sums.py",))


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A copy of a checkout of one module and one test, with the programme's own plugin."""
    root = tmp_path / "original"
    texts = {"slipwave/__init__.py": "", "slipwave/sums.py": SUM, "tests/test_sums.py": TEST, "pyproject.toml": SETTINGS}
    plugin = ("tests/faults/witness.py", "tests/faults/__init__.py", "tests/__init__.py")
    for name, text in (texts | {name: (ROOT / name).read_text() for name in plugin}).items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    monkeypatch.setattr("tests.faults.trial.tracked_files", lambda root: [p for p in root.rglob("*") if p.is_file()])
    (tmp_path / "work").mkdir()
    return Copy(tmp_path / "work", root)


def test_a_fault_is_caught_by_what_it_breaks_and_the_copy_is_clean_again(copy):
    record = try_fault(fault("sum(values)", "max(values)"), copy)
    found = [record[key] for key in ("caught", "by_its_check", "caught_by", "says")]
    assert found == [True, True, "tests/test_sums.py::test_total", "assert total([1, 2]) == 3  [assert 2 == 3]"]
    assert (copy.tree / "slipwave/sums.py").read_text() == SUM
    assert (copy.tree.parents[1] / "original/slipwave/sums.py").read_text() == SUM


@pytest.mark.parametrize(
    ("old", "new", "within", "test", "says"),
    [
        ("sum(values)", "sum(list(values))", "total", TEST, "its check runs the changed code and stays green"),
        ("len(values)", "2 * len(values)", "count", TEST, "its check never runs the changed code"),
        ("sum(values)", "sum(valves)", "total", TEST, "by accident only: NameError in tests/test_sums.py::test_total"),
        ("return sum", "import nothing_of_that_name\n    return sum", "total", TEST, "by accident only: ModuleNotFoundError"),
        ("sum(values)", "max(values)", "total", TEST.replace("3", "4"), "its check is not green without it"),
    ],
    ids=["equivalent", "not reached", "crash", "import", "red anyway"],
)
def test_what_no_assertion_notices_survives(old, new, within, test, says, copy):
    (copy.tree / "tests/test_sums.py").write_text(test)
    record = try_fault(fault(old, new, within), copy)
    assert record["caught"] is False
    assert record["says"].startswith(says)


@pytest.mark.parametrize(
    ("old", "new", "within"),
    [
        ("absent", "0", "total"),
        ("values", "0", "total"),
        ("len(values)", "0", "total"),
        ("sum(values)", "0", "totals"),
        ("sum(values)", "0", "A.total"),
        ("return sum(values)", "return sum(values)  # all", "total"),
    ],
)
def test_a_place_that_is_not_there_once_or_a_change_of_nothing_is_refused(old, new, within):
    with pytest.raises(AnchorError):
        fault(old, new, within).planted(SUM)


def test_a_record_is_of_use_until_what_decides_it_changes(tmp_path):
    def known(name, fault=FAULTS[0]):
        return Store(tmp_path / "records.json", "faults").known(name, key_of(fault, ["a.py"], tmp_path)) is not None

    (tmp_path / "a.py").write_text("1")
    store, key = Store(tmp_path / "records.json", "faults"), key_of(FAULTS[0], ["a.py"], tmp_path)
    store.add({"name": "first", "caught": False, "where": "", "what": "", "says": "", "key": key})
    assert [known("first"), known("other"), known("first", FAULTS[1])] == [True, False, False]
    (tmp_path / "a.py").write_text("2")
    assert not known("first")
    store.forget_survivors()
    assert store.known("first", key) is None


@pytest.mark.parametrize(
    ("code", "old", "new"),
    [
        ("x + y", "x + y", {"(x - y)", "(x * y)", "(x / y)", "(x // y)", "(x % y)", "(x ** y)"}),
        ("x | y", "x | y", {"(x & y)", "(x ^ y)"}),
        ("x < y", "x < y", {"(x == y)", "(x != y)", "(x <= y)", "(x > y)", "(x >= y)"}),
        ("x is y", "x is y", {"(x is not y)"}),
        ("x in y", "x in y", {"(x not in y)"}),
        ("x and y", "x and y", {"(x or y)"}),
        ("-x", "-x", {"(x)"}),
        ("2.5", "2.5", {"3.5", "1.5"}),
        ("True", "True", {"False"}),
        ("x if y else z", "y", {"(not y)"}),
        ("x @ y", "", set()),
        ("f'{2}'", "", set()),
        ("list(zip(x, y, strict=True))", "", set()),
    ],
)
def test_mutants_are_those_of_cosmic_ray(code, old, new):
    found = mutants_of("slipwave/f.py", f"def f(x: 'a', y, z):\n    return {code}\n")
    assert {mutant.new for mutant in found} == new
    assert {mutant.old for mutant in found} <= {old}
    assert {mutant.function for mutant in found} <= {"f"}


def test_mutants_of_statements_chains_and_decorators():
    """A chain of comparisons has a place for each; decorators go but those that compile or keep."""
    loop = "    for y in x:\n        if y:\n            break\n"
    text = f"def f(x):\n{loop}    try:\n        g()\n    except OSError:\n        x += y\n"
    found = {(mutant.old, mutant.new) for mutant in mutants_of("slipwave/f.py", text)}
    assert found >= {("x", "[]"), ("y", "(not y)"), ("break", "continue"), ("OSError", "UnboundLocalError"), ("x += y", "x -= y")}
    places = list(places_of("slipwave/f.py", "def f(x, y, z):\n    return x < y < z\n"))
    assert [len(place) for place in places] == [5, 5]
    assert {mutant.new for place in places for mutant in place} >= {"(x <= y < z)", "(x < y <= z)"}
    text = "class A:\n    @property\n    def f(self):\n        pass\n\n    @cache\n    def g(self):\n        pass\n"
    (mutant,) = mutants_of("slipwave/f.py", text)
    assert (mutant.old, mutant.function) == ("property", "A.f")


@pytest.mark.parametrize("listed", EQUIVALENTS, ids=lambda one: f"{one['file']}: {one['what']}")
def test_every_equivalent_is_a_mutant_of_the_program_as_it_is(listed):
    text = (ROOT / listed["file"]).read_text(encoding="utf-8")
    assert any(is_equivalent(mutant, [listed]) for mutant in mutants_of(listed["file"], text))
    assert listed["reason"]


def test_a_sample_is_of_the_asked_size_and_holds_no_equivalent(tmp_path):
    (tmp_path / "slipwave").mkdir()
    (tmp_path / "slipwave/f.py").write_text("".join(f"A{k} = {k}\n" for k in range(2, 60)))
    drawn = sample(20, 1, [], tmp_path)
    assert len({mutant.name for mutant in drawn}) == 20
    assert drawn[:5] == sample(5, 1, [], tmp_path) != sample(5, 2, [], tmp_path)
    listed = {"file": drawn[3].file, "what": drawn[3].what}
    assert sample(19, 1, [listed], tmp_path) == [*drawn[:3], *drawn[4:]]


def test_wilsons_interval():
    """Wilson (1927): for 8 of 10, 0.490 to 0.943."""
    assert wilson(8, 10) == pytest.approx((0.4902, 0.9433), abs=1e-4)


def nearest(folder, file, function, functions, **seconds):
    """Names of the tests tried first and later on a mutant of this function, where each runs these functions in a second."""
    noted = {test: {"seconds": seconds.get(test.rpartition("::")[2], 1.0), "functions": f} for test, f in functions.items()}
    (folder / "1.json").write_text(json.dumps(noted))
    found = Reach(folder, set(functions)).tests_for(Mutant(file, function, 0, 1, "1", "2"))
    return [[test.rpartition("::")[2] for test in tests] for tests in found]


def test_the_tests_nearest_to_a_mutant_come_first_and_long_ones_later(tmp_path):
    """Tests beside those that run a function may use what a fixture of theirs computed once."""
    f, g = "slipwave/f.py::f", "slipwave/f.py::g"
    runs = {
        "a.py::wide": [f, g],
        "a.py::near": [f],
        "b.py::long": [f],
        "b.py::endless": [f],
        "a.py::beside": [],
        "c.py::none": [g],
    }
    functions = {f"tests/slipwave/{test}": names for test, names in runs.items()}
    first, later = nearest(tmp_path, "slipwave/f.py", "f", functions, long=30.0, endless=200.0)
    assert (first, later) == (["near", "wide", "beside"], ["long"])


def test_compiled_code_meets_the_tests_of_what_imports_it(tmp_path):
    """One test runs another function of its file in Python; the kernels that are compiled with it are run by the others."""
    tests = {
        "tests/fullwave/test_far.py::far": ["fullwave/adapt.py::to_tolerance"],
        "tests/fullwave/test_own.py::own": ["fullwave/lines/system.py::total_stress"],
        "tests/fullwave/test_near.py::near": ["fullwave/lines/motion.py::rates"],
        "tests/reduced/test_other.py::other": ["reduced/delay/march.py::DelayMarch.solve"],
    }
    assert nearest(tmp_path, "fullwave/lines/system.py", "retard", tests) == [["own", "near", "far"], []]


def test_a_change_that_never_ends_is_stopped_by_processor_time(copy, monkeypatch):
    """However long the machine, busy with other things, takes to give it that."""
    monkeypatch.setattr("tests.faults.trial._WAITING", 1000.0)
    with copy.with_text("slipwave/sums.py", SUM.replace("return sum(values)", "while values:\n        pass")):
        assert copy.run(["tests/test_sums.py"], limit=2.0).trouble == "endless"
    assert copy.run(["tests/test_sums.py"], limit=30.0).is_green
