"""Models by name, what `auto` takes, the error of a chosen grid; laws, families and measures of the user's own files."""

import importlib
import multiprocessing
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import slipwave
import slipwave as sw
from fullwave.adapt import _difference_of, _probe
from slipwave.errors import SceneError
from slipwave.family import features_of
from slipwave.friction import LAWS
from slipwave.input.stored import read_stored
from slipwave.packages import own_file
from slipwave.solve import follow
from slipwave.sources import ROOT
from validation.models.build import build, build_all, judged_grid, prepare
from validation.models.by_name import FAMILIES, GRIDS, families, honouring, resolve
from validation.models.cycle import watch
from validation.models.own import load_families, own_files

HAVE = {"paper": "", "ramp": "", "slip-law": "", "unlike": "unlike", "unlike-irrational": "unlike", "grip": "grip"}
HAVE |= {"machine": "grip mass", "reflection": "reflection", "layered": "layers", "viscous": "kelvin-voigt"}


def test_features():
    assert {name: features_of(slipwave.read(name)) for name in HAVE} == {name: {*words.split()} for name, words in HAVE.items()}


@pytest.mark.parametrize("family", families(), ids=lambda family: family.name)
@pytest.mark.parametrize("name", ["paper", "unlike", "grip", "layered", "viscous", "ramp", "reflection", "machine"])
def test_every_family_builds_what_it_honours_and_refuses_the_rest(family, name):
    one = next(found for found in families() if found is family)
    scene = slipwave.read(name)
    if one in honouring(scene):
        solver = build(one.example, scene)
        assert solver.model == one.example
        assert solver.scene is scene
        assert solver.time == 0.0
    else:
        with pytest.raises(SceneError, match=r"models that can: .*fd") as caught:
            build(one.example, scene)
        assert len(str(caught.value).splitlines()) == 1


def test_auto_is_the_exact_one_or_says_why_not():
    assert resolve("auto", slipwave.read("paper")) == ("delay", "exact for this scene")
    chosen, why = resolve("auto", slipwave.read("viscous"))
    assert chosen in [family.example for family in GRIDS]
    assert "Kelvin-Voigt" in why
    assert resolve("block8", slipwave.read("paper")) == ("block8", "")


@pytest.mark.parametrize(
    ("name", "tolerance", "model"),
    [("dg", None, "dg:7"), ("dg", 1e-4, "dg:5"), ("dg", 1e-8, "dg:7"), ("fem", 1e-6, "fem:6"), ("sbp", 1e-3, "sbp:6")],
)
def test_a_degree_left_open_suits_the_tolerance(name, tolerance, model):
    solver = build(name, slipwave.read("paper", ["run.until=20"]), tolerance=tolerance)
    assert solver.model == model


def test_a_tolerance_beside_given_cells_is_for_the_steps_of_the_exact_march():
    scene = slipwave.read("paper", {"slab.log10_r": -2.6})
    plain, coarse, fine = (build("dg:8", scene, cells=4, tolerance=tolerance) for tolerance in (None, 1e-5, 1e-9))
    assert [solver.settings["cells"] for solver in (plain, coarse, fine)] == [[4]] * 3
    assert [solver.settings["resolution"] for solver in (plain, coarse, fine)] == [1e-12, 1e-5, 1e-9]
    exact, far, near = (follow(solver, 60.0).psi for solver in (plain, coarse, fine))
    assert 1e-10 < abs(far / exact - 1.0) < 1e-7  # 1.5e-9 measured
    assert abs(near / exact - 1.0) < 1e-10  # 4e-12 measured


def test_options_go_to_the_models_that_take_them():
    delay, leapfrog = build_all("delay,fd", slipwave.read("paper"), cells=10, tolerance=1e-6)
    assert (delay.model, leapfrog.model) == ("delay", "fd")
    assert getattr(leapfrog, "cells") == 10  # noqa: B009
    for options in ({"cells": 10}, {"cfl": 0.5}):
        with pytest.raises(SceneError, match="none of the models"):
            build_all("delay,block8", slipwave.read("paper"), **options)  # type: ignore[arg-type]


ELEMENTS = """
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.families import FullWave
from reduced.impedance.reduction import Reduction
from slipwave.family import Family

ORDER = lambda p: p + 1
MINE = FullWave("mine:P", f"{__name__}:Mine", "my elements", numbers=range(1, 5), default=3, order_interface=ORDER, cfl=0.75)
BLOCK10 = Family("block10", f"{__name__}:block10", "spring and block of mass rho h/10")


class Mine(DiscontinuousGalerkin):
    family = MINE


def block10(scene, name):
    return Reduction(name, mass=0.1)
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(ELEMENTS)
    return path


def test_a_full_wave_and_a_reduction_of_ones_own(file, answer):
    """The elements are ours under another name, so that every digit is the same."""
    ours = sw.run("paper", "dg:3", until=20, cells=4, time="explicit").final
    mine = sw.run("paper", "mine:3", until=20, cells=4, time="explicit", family=file).final
    assert mine == ours
    critical = answer("stability", "paper", "--model", "block10", "--family", str(file))["log10_r_c"]
    lighter, heavier = (sw.stability("paper", model).log10_r_c for model in ("block12", "block8"))
    assert critical != lighter
    assert min(lighter, heavier) < critical < max(lighter, heavier)
    assert sw.models(family=file)["mine:P"] == "my elements"


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ("mass=-1.0", "mass = -1.0: must be a number from 0"),
        ("frequencies=(6.0, 7.0), residues=(2.0,)", r"residues = \(2.0,\): must be as many as frequencies"),
        ("mass=0.1, relaxations=((1.0, -2.0),)", r"relaxations = .*: must be a tuple of pairs \(strength, rate above 0\)"),
        ("mass=0.1, frequencies=(6.0,), residues=(-0.5,)", "is not passive: Re Z"),
        ("damping=0.1, frequencies=(6.0,), residues=(0.1,), decays=(0.1,), offsets=(-5.0,)", "is not passive: Re Z"),
    ],
)
def test_values_that_no_slabs_have_are_named(file, values, told):
    """Before, some made a traceback, some a critical r, and runs blamed the numerics."""
    file.write_text(ELEMENTS.replace("mass=0.1", values))
    for command in (sw.stability, sw.run):
        with pytest.raises(sw.SceneError, match=rf"^model = 'block10': {told}"):
            command("paper", "block10", family=file)


def test_a_file_that_is_loaded_again_replaces_its_own(file):
    load_families(file)
    file.write_text(ELEMENTS.replace("my elements", "better elements"))
    load_families(file)
    assert [family.title for family in FAMILIES if family.name == "mine"] == ["better elements"]
    assert own_files() == [file.resolve()]


@pytest.mark.parametrize(("old", "new"), [("mass=0.1", "mass=0.1]"), (":block10", ":no"), (ELEMENTS, "import math")])
def test_a_file_that_is_wrong_when_it_is_loaded_again_leaves_its_families_as_they_were(file, old, new):
    """Before, the families of the version before it were gone, or made by what there was of the wrong one."""
    before = sw.run("paper", "block10", family=file, until=5.0).final
    file.write_text(ELEMENTS.replace(old, new, 1))
    with pytest.raises(sw.SceneError, match="--family = "):
        load_families(file)
    assert sw.run("paper", "block10", until=5.0).final == before
    assert sw.models()["mine:P"] == "my elements"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"mine:P"', '"dg:P"', "the name 'dg' is taken by another family of models"),
        (":Mine", ":Yours", "Yours': no such class or function"),
        ("class Mine(DiscontinuousGalerkin)", "class Mine", "class Mine lacks the methods advance, deviation, "),
        ("    family = MINE", "    pass", "Mine.family is another one"),
        (ELEMENTS, "import math", "declares no family of models"),
        ("from reduced", "from nowhere", "cannot be run: ModuleNotFoundError: No module named 'nowhere'"),
        ("ORDER = lambda p: p + 1", "ORDER = 1 / 0", "mine.py, line 7, in <module>)"),
    ],
)
def test_what_is_wrong_with_a_file_is_told_in_one_line(file, refused, old, new, told):
    before = list(FAMILIES)
    file.write_text(ELEMENTS.replace(old, new, 1))
    error = refused("run", "paper", "--family", str(file), "--model", "mine")
    assert error.startswith(f"slipwave: --family = {str(file)!r}")
    assert told in error
    assert before == FAMILIES


def test_a_mistake_in_a_method_is_told_by_its_line(file, refused, tmp_path):
    method = "\n    def grid_of(self, *given):\n        return given[9]\n"
    file.write_text(ELEMENTS.replace("    family = MINE\n", "    family = MINE\n" + method))
    call = ["run", "paper", "--family", str(file), "--model", "mine:3", "--cells", "4", "--until", "2"]
    told = refused(*call, "--out", str(tmp_path / "run.nc"), status=3)
    assert f"slipwave: {file.resolve()}, line 16, in grid_of: IndexError: tuple index out of range" in told
    assert not (tmp_path / "run.nc").exists()
    with pytest.raises(IndexError):
        sw.run("paper", "mine:3", cells=4, until=2, family=file)


def test_a_file_of_results_names_the_family_and_demands_it_again(file, printed, refused, tmp_path):
    first, ours = str(tmp_path / "run.nc"), str(tmp_path / "ours.nc")
    own = ["--family", str(file)]
    printed("run", "paper", *own, "--model", "mine:3", "--cells", "4", "--until", "5", "--out", first)
    printed("run", first, *own, "--until", "5")
    facts = read_stored(first).facts
    assert (facts["family_file"], len(facts["family_digest"])) == ("mine.py", 16)
    file.write_text(ELEMENTS + "\n")
    assert "was computed with another family of 'mine:3'" in refused("run", first, *own)
    printed("run", "paper", "--until", "5", "--model", "dg:3", "--out", ours)
    assert "family_file" not in read_stored(ours).facts


PACKAGE = {
    "mine.py": ELEMENTS,
    "laws.py": "from slipwave.friction import ageing, register\nfrom slipwave.friction.law import steady_psi\n"
    "class Mine(ageing.Ageing): pass\nregister('my-ageing', Mine, ageing.respond_ageing, steady_psi)\n",
    "mine-1.0.dist-info/METADATA": "Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n",
    "mine-1.0.dist-info/entry_points.txt": "[slipwave.families]\nmine = mine:MINE\nblock10 = mine:block10\nlost = nowhere:LOST\n"
    "[slipwave.laws]\nmine = laws\n",
}


def test_an_installed_package_brings_its_family_and_its_law(tmp_path):
    for name, text in PACKAGE.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    code = "import slipwave as s; print(s.models()['mine:P'], s.stability('paper', settings='interface.law=my-ageing').stable)"
    environment = {"PYTHONPATH": str(tmp_path), "HOME": str(Path.home())}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    assert done.stdout.split() == ["my", "elements", "False"]
    assert done.stderr.count("note: mine: slipwave.families") == 2
    assert "block10 = 'mine:block10': is no slipwave.family.Family; it is left out" in done.stderr
    assert "ModuleNotFoundError: No module named 'nowhere'; it is left out" in done.stderr


SCENE = sw.read("paper", {"drive.velocity": 2000, "run.until": 9.0})
"""Too short for cycles, so that the state at its end is compared."""


@pytest.mark.parametrize(
    ("model", "options"),
    [
        ("fd", {}),
        ("fd", {"cfl": 0.5}),
        ("dg:3", {}),
        ("dg:3", {"time": "explicit"}),
        ("dg:3", {"time": "exact"}),
        ("sbp:4", {"cfl": 0.4, "time": "explicit"}),
    ],
)
def test_the_estimate_is_that_of_the_march_that_ran(model, options):
    grid = sw.run(SCENE, model, **options).summary["grid"]
    fine = build(model, SCENE, **options)
    assert (grid["cells"], grid["step"]) == (fine.cells, fine.step)  # type: ignore[attr-defined]
    fewer = build(model, SCENE, cells=int(grid["cells"] / 1.5), **options)
    ends = [follow(solver, 9.0) for solver in (fine, fewer)]
    now, before = (np.array([end.ln_v, end.psi]) for end in ends)
    assert grid["quantity"] == "final state"
    assert grid["error_estimate"] == pytest.approx(1.5 * np.abs((now - before) / now).max(), rel=1e-6, abs=2e-11)


def test_a_grid_that_cannot_be_coarser_is_judged_by_a_finer_one():
    """Layers of 16 cells, the fewest of `sbp:6`, are the same with fewer cells asked for: that difference is none."""
    layers = [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": 1.5}]
    layered = sw.read("paper", {"drive.velocity": 2000, "run.until": 15.0, "slab.layers": layers})
    grid = sw.run(layered, "sbp:6").summary["grid"]
    error = _difference_of(_probe(build("sbp:6", layered, cells=128)), _probe(build("sbp:6", layered)))
    assert grid["quantity"] == "cycles"
    assert 1e-8 < error < grid["error_estimate"] < 5.0 * error


STEPPED = {"drive.velocity": [[0, 300], [40.2, 300], [40.2, 200]]}


@pytest.mark.parametrize(
    ("name", "keys", "model"), [("jump", {}, "fem:4"), ("paper", STEPPED, "dg"), ("paper", STEPPED, "sbp:4")]
)
def test_the_estimate_of_a_grid_holds_behind_fronts(name, keys, model):
    """Every scheme is of order 1 there, and one difference may be small by chance: these errors are 2 to 6 times as large."""
    jumping = sw.read(name, keys | {"run.until": 400.0})
    default = prepare(model, jumping).solver
    judged = judged_grid(default, default.state())
    assert judged is not None
    error = _difference_of(_probe(build("delay", jumping, tolerance=1e-11)), _probe(default))
    assert 0.1 * judged.error_estimate < error < judged.error_estimate


STEEP = "drive.velocity=[[0.0,100.0],[120.0,100.0],[123.0,1000.0]]"


def cycles(solver, until):
    found = watch(solver, until).events()
    return np.concatenate((found.period, found.stress_drop))


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, pytest.param(1e-6, marks=pytest.mark.slow)])
def test_a_ramp_beyond_the_probe_of_a_constant_drive_is_seen(monkeypatch, tolerance):
    """Three cells are enough up to the ramp, whatever the tolerance; they err by 5e-6 after it."""
    monkeypatch.setattr("fullwave.adapt.PROBE", 110.0)
    chosen = slipwave.read("paper", [STEEP, "run.until=200"])
    exact = cycles(build("delay", chosen, tolerance=1e-12), chosen.until)
    built = prepare("dg", chosen, tolerance=tolerance)
    assert built.choice is not None
    error, estimate = float(np.abs(cycles(built.solver, chosen.until) / exact - 1.0).max()), built.choice.error_estimate
    assert error <= 2.0 * estimate
    assert error <= tolerance
    assert estimate <= tolerance


LAW = (ROOT / "examples" / "own_law.py").read_text(encoding="utf-8").split("\nif __name__")[0]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working folder with the law `law.py`, from which modules can be imported."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "law.py").write_text(LAW)
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(tmp_path)):
            del sys.modules[name]


MEASURE = "def f(scene): return {'twice': 2.0 * scene.law.a}"
OWN_LAW = ("--law", "law.py", "--set", "interface.law=cutoff")
SAME = ("--law", "laws.py", "--set", "interface.law=my-ageing")
BRANCH = ("paper", *SAME, "--model", "block8", "--tol", "1e-4", "--over", "r=1e-3:5e-3", "--most-points")
FIT = ("fit", "velocity-steps", *OWN_LAW, "--set", "slab.thickness='20 cm'", "--free", "a", "--data", "steps.csv")
MEMBER = ("--family", "mine.py", "--model", "mine:3", "--cells", "4", "--checkpoint", "kept.npz", "--checkpoint-every", "2")
KEPT = {
    "run": (
        ["run", "paper", *OWN_LAW, "--checkpoint", "kept.npz", "--checkpoint-every", "5", "--until", "8"],
        ["run", "paper", *OWN_LAW, "--checkpoint", "kept.npz", "--until", "9"],
        "delete 'kept.npz'",
        "law law.py",
    ),
    "sweep": (
        ["sweep", "paper", *OWN_LAW, "--vary", "V=50,100", "--measure", "stability", "--workers", "1", "--out", "map"],
        ["sweep", "map", "--law", "law.py", "--workers", "1"],
        "--anew",
        "law law.py",
    ),
    "branch": (
        ["branch", *BRANCH, "2", "--out", "kept.nc"],
        ["branch", *BRANCH, "3", "--resume", "kept.nc"],
        "without --resume",
        "law laws.py",
    ),
    "fit": ([*FIT, "--checkpoint", "kept.json"], [*FIT, "--checkpoint", "kept.json"], "remove it", "law law.py"),
    "family": (
        ["run", "paper", *MEMBER, "--until", "5"],
        ["run", "paper", *MEMBER, "--until", "6"],
        "delete 'kept.npz'",
        "family mine.py",
    ),
    "measure": (
        ["sweep", "paper", "--vary", "V=50,100", "--measure", "mine:f", "--workers", "1", "--out", "map"],
        ["sweep", "map", "--measure", "mine:f", "--workers", "1"],
        "--anew",
        "measure mine.py",
    ),
}


@pytest.mark.parametrize("name", KEPT)
def test_what_was_computed_with_a_file_that_has_changed_is_not_gone_on_with(name, here, refused, printed):
    first, again, way_out, changed = KEPT[name]
    (here / "mine.py").write_text(ELEMENTS if name == "family" else MEASURE)
    (here / "laws.py").write_text(PACKAGE["laws.py"])
    if name == "fit":
        printed("run", *FIT[1:-4], "--model", "quasidynamic", "--until", "90s", "--series", "steps.csv")
    printed(*first)
    sys.modules.pop("mine", None)
    path = here / changed.split()[1]
    text = path.read_text()
    path.write_text(text + "\n# another\n")
    told = refused(*again)
    assert changed in told
    assert way_out in told
    sys.modules.pop("mine", None)
    path.write_text(text)
    printed(*again)


def test_a_sweep_is_drawn_and_gathered_with_its_law_only(here, refused, printed):
    """Before, an edited law drew its boundary over the regimes of the first, and without any the nearest of ours was advised."""
    printed("sweep", "paper", *OWN_LAW, "--vary", "V=50,100", "--measure", "stability", "--workers", "1", "--out", "map")
    printed("sweep", "map", "--law", "law.py", "--gather")
    drawn = (["map", "map"], ["map", "map/sweep.nc"], ["sweep", "map", "--gather"])
    del LAWS["cutoff"]
    for words in (*drawn, ["sweep", "map"]):
        assert "': needs the friction law of the file law.py (digest" in refused(*words)
    (here / "law.py").write_text(LAW + "\n# another\n")
    for words in drawn:
        assert "was computed with another law law.py: digest" in refused(*words, "--law", "law.py")
    (here / "law.py").write_text(LAW)
    for words in drawn:
        printed(*words, "--law", "law.py")


def test_a_digest_is_that_of_the_user_s_text_as_it_was_loaded_with_what_it_imports(here):
    (here / "parts").mkdir()
    for name, text in (("__init__", ""), ("whole", "from . import half\ndef f(x): return half.x"), ("half", "x = 1")):
        (here / "parts" / f"{name}.py").write_text(text)
    sys.path.append(str(here))

    def digest():
        for name in [name for name in sys.modules if name.startswith("parts")]:
            del sys.modules[name]
        importlib.invalidate_caches()
        function = importlib.import_module("parts.whole").f
        first = own_file(function)
        (here / "parts" / "half.py").write_text("x = 100")
        assert own_file(function) == first
        return first

    assert digest().path == here / "parts" / "whole.py"
    assert digest() == digest() != own_file(test_a_digest_is_that_of_the_user_s_text_as_it_was_loaded_with_what_it_imports)
    assert own_file(sw.read_scene) is None


def test_processes_of_the_users_load_the_law_and_the_family(file, here):
    """Before, they died, because no process can import these files."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as executor:
        words = {"law": "law.py", "family": file, "set": {"interface.law": "cutoff"}, "models": "block10"}
        found = sw.sweep("paper", vary="V=50,100", measure="stability", executor=executor, **words)
    assert found.summary["done"] == 2


END = "import sys\n"
EXITS = {
    "law": (["verify", "--law", "user.py"], "sys.exit(0)"),
    "family": (["verify", "--family", "user.py"], "sys.exit(3)"),
    "measure": (["sweep", "paper", "--vary", "V=50,100", "--measure", "user:f", "--out", "map"], "sys.exit(0)"),
    "function of a measure": (
        ["sweep", "paper", "--vary", "V=50,100", "--measure", "user:f", "--workers", "1", "--out", "map"],
        "def f(scene): sys.exit(0)",
    ),
    "function of a law": (["verify", "--law", "user.py"], LAW.replace("v, age = math.exp(z), math.exp(psi)", "sys.exit(0)")),
    "function of a family": (
        ["run", "paper", "--model", "mine", "--family", "user.py"],
        "from slipwave.family import Family\ndef make(*given, **named): sys.exit(0)\n"
        "MINE = Family('mine', f'{__name__}:make', 'mine')\n",
    ),
}


@pytest.mark.parametrize("name", EXITS)
def test_a_file_that_ends_the_program_is_wrong_input(name, here, refused):
    words, text = EXITS[name]
    (here / "user.py").write_text(END + text)
    junit = ["--junit", "rows.xml"] if words[0] == "verify" else []
    told = refused(*words, *junit)
    assert "ends the program (sys.exit(" in told
    assert "user" in told
    assert not (here / "rows.xml").exists()


def test_a_file_that_ends_the_program_ends_no_program_in_python(here):
    (here / "user.py").write_text("raise SystemExit(0)")
    with pytest.raises(SceneError, match="ends the program"):
        sw.verify(law=here / "user.py")
