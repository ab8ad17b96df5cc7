"""A law from outside: refused by name if it is wrong; its code is kept on disk until what shaped it changes."""

import collections
import copy
import math
import pickle
import runpy
import sys
import types
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from numba import njit
from numba.core.errors import NumbaError

import slipwave
from reduced.delay.flow_kernel import logs_of_return
from slipwave.compiled import allocating
from slipwave.compiled.frozen import frozen_parts
from slipwave.errors import SceneError
from slipwave.friction import LAWS, ageing
from slipwave.friction.ageing import Ageing
from slipwave.friction.ageing import respond_ageing as respond
from slipwave.friction.check import check_law
from slipwave.friction.law import Registered, friction_slopes, name_of, register
from slipwave.friction.law import steady_psi as steady_state
from slipwave.friction.own import load_laws, refused_by_compiler

ROOT = Path(__file__).resolve().parents[2]
ANSWERS = ("v", "v_z", "F", "F_z", "F_psi", "G", "G_z", "G_psi")


class Unpriced(NamedTuple):
    a: float
    b: float
    c: float
    d: float


def law_with(respond_=respond, steady=steady_state, parameters=Ageing, rate_of=None):
    return Registered(parameters, respond_, steady, rate_of or (lambda law, z: math.exp(z)), lambda law, v: math.log(v))


@pytest.mark.parametrize("name", LAWS)
def test_every_law_of_the_house_passes_the_check(name):
    own = {"cutoff_velocity": 1e3, "saturation_velocity": 1e-3}
    fields = LAWS[name].parameters._fields
    check_law(name, LAWS[name], (0.6, 0.01, 0.015, *(own[field] for field in fields[3:] if field in own)))


@pytest.mark.parametrize("wrong", ["v_z", "F_z", "F_psi", "G_z", "G_psi"])
@pytest.mark.parametrize("fault", [lambda x: -x, lambda x: 1.001 * x, lambda x: x + 1e-3, lambda x: math.nan, lambda x: 0.0])
def test_a_wrong_derivative_is_refused_by_name(wrong, fault):
    place = ANSWERS.index(wrong)

    def spoilt(law, z, psi):
        answer = list(respond(law, z, psi))
        answer[place] = fault(answer[place])
        return tuple(answer)

    with pytest.raises(SceneError, match=rf"'mine': {wrong} "):
        register("mine", Ageing, spoilt, steady_state)
    assert "mine" not in LAWS


def without_state(law, z, psi):
    """Before, every command ended in a ZeroDivisionError."""
    v = math.exp(z)
    return v, v, law.a_star + law.a * z, law.a, 0.0, 0.0, 0.0, 0.0


@pytest.mark.parametrize(
    ("law", "told"),
    [
        (law_with(steady=lambda law, v: 0.1 - math.log(v)), "state rate G"),
        (law_with(rate_of=lambda law, z: math.exp(2 * z)), "rate_of"),
        (law_with(lambda law, z, psi: respond(law, z, psi)[:7]), "respond must return"),
        (law_with(lambda law, z, psi: (2 * respond(law, z, psi)[0], *respond(law, z, psi)[1:])), "v of respond"),
        (law_with(lambda law, z, psi: 1 / 0), "ZeroDivisionError"),
        (law_with(without_state, lambda law, v: 0.0), r"G_psi = 0 at z = .*; for friction without a state let G = -psi"),
        (law_with(parameters=Unpriced), "defaults"),
        (LAWS["ageing"]._replace(rate_of=lambda law, z: z * z, unknown_of=lambda law, v: v**0.5), "v''"),
    ],
)
def test_other_faults_are_refused_with_their_reason(law, told):
    with pytest.raises(SceneError, match=told):
        check_law("mine", law)


class Bent(NamedTuple):
    a_star: float = 0.369
    a: float = 0.0349
    b: float = 0.0489
    bend: float = 0.0


def bent(law, z, psi):
    v, _, friction, _, _, growth, growth_z, growth_psi = respond(law, z, psi)
    direct = law.a - 0.1 * law.bend * v
    return v, v, friction + law.bend * (psi * psi - 0.1 * v), direct, law.b + law.bend * psi, growth, growth_z, growth_psi


@pytest.mark.parametrize(("bend", "told"), [(2e-3, "F_psi at z = 4.6"), (1.0, "F_z = -9.9651 at z = 4.6")])
def test_a_mistake_that_the_defaults_hide_is_refused_in_a_scene_that_shows_it(bend, told):
    """Before, `stability` said stable or took the root of a negative number; the slope F_psi lacks a factor of 2."""
    register("bent", Bent, bent)
    scene = slipwave.read("paper", {"interface.law": "bent", "interface.bend": bend})
    for ask in (lambda: scene.steady_psi, lambda: friction_slopes(scene.law, 100.0)):
        with pytest.raises(SceneError, match=f"friction law 'bent': {told}"):
            ask()


class Plain(NamedTuple):
    a_star: float = 0.369
    a: float = 0.0349
    b: float = 0.0489


def other_names(p, x, y):
    return respond(p, x, y)


@pytest.mark.parametrize(
    ("name", "parameters", "function", "told"),
    [
        (5, Plain, respond, "law 5: its name must be a text"),
        ("", Plain, respond, "its name must be a text"),
        ("ageing", Plain, respond, "'ageing': is one of slipwave's own; give yours another name"),
        ("mine", Ageing, respond, "'mine': 'ageing' is already registered with the same parameter class"),
        ("mine", Plain(), respond, "must be a class, a NamedTuple of numbers"),
        ("mine", NamedTuple("Keyed", [("law", float), ("a", float)]), respond, "parameter 'law': is a key that every law has"),
        ("mine", collections.namedtuple("Text", "a", defaults=["x"]), respond, "parameter 'a': its default 'x' must be a number"),
        ("mine", Plain, None, "respond = None: must be a function written with def"),
        ("mine", Plain, other_names, "the arguments of respond must be named law, z, psi, not p, x, y"),
    ],
)
def test_parts_that_no_scene_or_solver_can_use_are_refused_when_they_are_registered(name, parameters, function, told):
    """Before, some spoilt every later command of the process, and some gave a built-in law the numbers of another."""
    own = function and as_mine(function)
    before = dict(LAWS)
    with pytest.raises(SceneError, match=told):
        register(name, parameters, own, steady_state)
    assert before == LAWS


def test_a_class_of_parameters_belongs_to_one_law():
    """The functions of the second would be those of the first, too."""
    parameters, own = NamedTuple("Once", [("a_star", float), ("a", float), ("b", float)]), as_mine(respond)
    try:
        register("first", parameters, own)
        register("first", parameters, own)  # a cell of a notebook that runs again
        with pytest.raises(SceneError, match="'second': 'first' is already registered with the same parameter class"):
            register("second", parameters, own)
        assert "second" not in LAWS
    finally:
        LAWS.pop("first", None)


def test_a_function_that_numba_has_compiled_is_taken_as_written():
    parameters, own = NamedTuple("Compiled", [("a_star", float), ("a", float), ("b", float)]), as_mine(respond)
    try:
        register("compiled", parameters, njit(own))
        assert LAWS["compiled"].respond is own
    finally:
        LAWS.pop("compiled", None)


def as_mine(function):
    """The function as if written in a file of the user's."""
    return types.FunctionType(function.__code__.replace(co_filename="mine.py"), function.__globals__)


def test_the_documented_example_is_the_one_that_runs():
    page, program = ((ROOT / name).read_text() for name in ("docs/extending.md", "examples/own_law.py"))
    assert page.split("```python\n")[1].split("```")[0] == program


def test_a_tiny_cutoff_is_the_ageing_law():
    example = runpy.run_path(str(ROOT / "examples" / "own_law.py"), run_name="example")
    mine = example["Cutoff"](cutoff=0.0)
    for z, psi in ((0.0, 0.0), (3.0, -4.0), (-2.0, 5.0)):
        assert example["respond"](mine, z, psi) == pytest.approx(respond(Ageing(0.369, 0.0349, 0.0489), z, psi), rel=1e-14)


MINE = """
import math
from pathlib import Path
from typing import NamedTuple
from slipwave.friction import register
FACTOR = float(Path(__file__).with_suffix(".txt").read_text())

class Mine(NamedTuple):
    a_star: float = 0.369
    a: float = 0.0349
    b: float = 0.0489

def respond(law, z, psi):
    v = math.exp(z)
    return v, v, law.a_star + FACTOR * law.a * z + law.b * psi, FACTOR * law.a, law.b, math.exp(-psi) - v, -v, -math.exp(-psi)

def steady_state(law, v):
    return -math.log(v)

register("mine", Mine, respond, steady_state)
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path


def ask(folder, text, factor):
    """An answer by the law of a file `text` that reads `factor` from another file, and whether its code came from the disk."""
    path = folder / "mine.py"
    path.write_text(text)
    path.with_suffix(".txt").write_text(str(factor))
    assert load_laws(path) == ["mine"]
    fresh = allocating(logs_of_return.py_func)
    law = LAWS["mine"].parameters(0.369, 0.0349, 0.0489)
    answer = fresh(law, 1.4e-5, np.ones((1, 1)), np.full((1, 1), -4.6))[0]
    return answer, sum(fresh.stats.cache_hits.values())


def test_code_of_a_law_is_found_again_until_the_law_changes(folder):
    first, hits = ask(folder, MINE, 1.0)
    assert hits == 0
    assert ask(folder, MINE, 1.0) == (first, 1)
    other, hits = ask(folder, MINE, 1.5)
    assert (hits, other == first) == (0, False)
    other, hits = ask(folder, MINE.replace("FACTOR *", "1.1 * FACTOR *"), 1.0)
    assert (hits, other == first) == (0, False)
    assert ask(folder, MINE, 1.0) == (first, 1)


def test_functions_compiled_for_one_law_are_not_called_with_another_of_its_name(folder):
    """numba tells named tuples within arguments apart by the name of their class."""
    mine, found = MINE.replace("Mine", "Apart"), set[float]()
    for text, factor in ((mine, 1.0), (mine, 1.5), (mine.replace("FACTOR *", "1.1 * FACTOR *"), 1.0), (mine, 1.0)):
        ask(folder, text, factor)
        law = LAWS["mine"].parameters(0.369, 0.0349, 0.0489)
        found.add(float(logs_of_return(law, 1.4e-5, np.ones((1, 1)), np.full((1, 1), -4.6))[0]))
    assert len(found) == 3


def made(constant, default=1.0, bound=2.0):
    scope = {"constant": constant, "exp": math.exp, "np": np}
    text = f"def maker(bound):\n def f(x, y={default}):\n  return exp(x) + np.sin(y) * constant * bound\n return f"
    exec(compile(text, "mine", "exec"), scope)
    function = scope["maker"](bound)
    return function


@pytest.mark.parametrize("constant", [0.5, 1, -0.0, True, (1.0, 2.0), np.array([1.0, 3.0]), np.float32(0.5), made(0.25)])
def test_every_value_that_is_frozen_counts(constant):
    plain, one = frozen_parts([made(0.0)]), frozen_parts([made(constant)])
    assert one == frozen_parts([made(constant)])
    assert one != plain
    assert len({one, frozen_parts([made(constant, default=1.5)]), frozen_parts([made(constant, bound=2.5)])}) == 3


def test_arrays_count_to_the_last_bit():
    assert frozen_parts([made(np.array([1.0, 3.0]))]) != frozen_parts([made(np.array([1.0, np.nextafter(3.0, 4.0)]))])
    assert frozen_parts([made(np.zeros(4))]) != frozen_parts([made(np.zeros((2, 2)))])


@pytest.mark.parametrize(
    "constant", [{}, [1.0], object(), types.ModuleType("mine"), made({}), types.SimpleNamespace, lambda x: lambda: x]
)
def test_what_cannot_be_told_is_never_kept(constant):
    assert frozen_parts([made(constant)]) is None


def test_files_of_the_project_that_a_law_calls_are_named():
    _, files = frozen_parts([made(ageing.respond_ageing)])
    assert [path.name for path in files] == ["ageing.py"]


def test_the_function_that_cannot_be_compiled_is_named_with_its_line(folder):
    """Before, the compiler's two hundred lines ended every command that runs; bugs of ours stay bugs."""
    text = MINE.replace("    v = math.exp(z)\n", '    v = math.exp(z) * {"one": 1.0, 2: z}["one"]\n')
    path = folder / "mine.py"
    path.write_text(text)
    path.with_suffix(".txt").write_text("1.0")
    load_laws(path)
    line = text.splitlines().index('    v = math.exp(z) * {"one": 1.0, 2: z}["one"]') + 1
    found = refused_by_compiler(NumbaError("of a solver"))
    assert isinstance(found, SceneError)
    assert str(found).startswith(f"friction law 'mine': numba cannot compile respond ({path}, line {line}): ")
    assert "\n" not in str(found)
    ask(folder, MINE, 1.0)
    of_ours = NumbaError("of a solver")
    assert refused_by_compiler(of_ours) is of_ours


def test_a_command_says_so_in_one_line(folder):
    path = folder / "mine.py"
    path.write_text(MINE.replace("    v = math.exp(z)\n", '    v = math.exp(z) * {"one": 1.0, 2: z}["one"]\n'))
    path.with_suffix(".txt").write_text("1.0")
    with pytest.raises(SceneError, match=r"^friction law 'mine': numba cannot compile respond \(.*mine.py, line 14\): .+$"):
        slipwave.run("paper", "block8", until=5.0, law=path, set={"interface.law": "mine"})


def test_a_scene_has_the_law_that_is_loaded_now(folder):
    """Before, commands in Python took the law as it was when the scene was read, with changes of keys as it is now."""
    ask(folder, MINE, 1.0)
    scene = slipwave.read("paper", {"interface.law": "mine"})
    assert slipwave.read(scene) is scene
    ask(folder, MINE, 1.5)
    for again in (slipwave.read(scene), slipwave.read(scene, {"title": "again"})):
        assert friction_slopes(again.law, 100.0).direct == pytest.approx(1.5 * 0.0349 / 100.0, rel=1e-12)
    assert friction_slopes(scene.law, 100.0).direct == pytest.approx(0.0349 / 100.0, rel=1e-12)
    with pytest.raises(SceneError, match="friction law Mine: was loaded anew since; read the scene"):
        name_of(scene.law)
    assert pickle.loads(pickle.dumps(scene)) == copy.deepcopy(scene) == scene  # before, the law was "not the same object"


def test_parameters_without_steady_sliding_are_wrong_input_with_the_line_of_the_law():
    """Before, a traceback; a fit whose search came to such values was lost."""
    load_laws(ROOT / "examples" / "own_law.py")
    scene = slipwave.read("paper", {"interface.law": "cutoff", "interface.cutoff": -0.02})
    for ask in (lambda: scene.steady_psi, lambda: scene.steady_stress, lambda: friction_slopes(scene.law, 100.0)):
        with pytest.raises(SceneError, match=r"'cutoff': no steady sliding at V = 100 with .*cutoff = -0.02: .*own_law.py, line"):
            ask()


def test_a_mistake_in_a_file_named_by_its_relative_path_has_its_line(folder, monkeypatch):
    monkeypatch.chdir(folder)
    Path("mine.py").write_text("x = 1 / 0")
    with pytest.raises(SceneError, match=r"division by zero \(.*mine.py, line 1, in <module>\)"):
        load_laws(Path("mine.py"))


def test_a_pickled_law_is_that_of_its_file_in_a_process_that_has_not_loaded_it(folder, monkeypatch):
    """Before, such a process could read no scene or result with a law of the user's own."""
    ask(folder, MINE, 1.0)
    law = LAWS["mine"].parameters(0.3, 0.02, 0.03)
    kept = pickle.dumps(law)
    LAWS.pop("mine")
    sys.modules.pop("own_law_mine")
    assert tuple(pickle.loads(kept)) == tuple(law)
    assert "mine" in LAWS
    ask(folder, MINE + "# another", 1.0)
    monkeypatch.setattr("slipwave.friction.own._KINDS", {})
    with pytest.raises(SceneError, match=r"'mine': is not that of '.*mine.py' with the digest"):
        pickle.loads(kept)
