"""`import slipwave`: the answers of the command line as objects, errors to catch; what works without the extras' libraries."""

import copy
import json
import logging
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import slipwave as sw
from slipwave.errors import SceneError
from slipwave.extras import EXTRAS, OF_THE_REPORT
from slipwave.threads import VARIABLES
from validation.commands.cli import COMMANDS
from validation.commands.options import options_of

FAST = {"drive.velocity": 2000}
"""Cycles of four transits, which repeat after 100."""


@pytest.mark.parametrize(
    "changes", [{"slab": {"r": 10**-2.3}, "drive.velocity": 50}, {"log10_r": -2.3, "V": 50}, {"r": 10**-2.3, "velocity": 50}]
)
def test_changes_may_be_tables_or_dotted_keys(changes):
    scene = sw.read_scene("paper", **changes)
    assert scene.digest == sw.read("paper", ["slab.log10_r=-2.3", "drive.velocity=50"]).digest
    assert (scene.transit, scene.velocity) == (10.0**-2.3, 50.0)


@pytest.mark.parametrize("steps", [((0, 100), (10, 120)), np.array([[0.0, 100], [10, 120]]), [(0, 100), [10, np.float64(120)]]])
def test_steps_of_the_drive_may_be_an_array_or_tuples(steps):
    wanted = sw.read("paper", ["drive.velocity=[[0, 100], [10, 120]]"])
    assert sw.read_scene("paper", V=steps).digest == sw.read_scene("paper", drive={"velocity": steps}).digest == wanted.digest
    whole = dict(wanted.tables) | {"drive": {"velocity": steps}}
    assert sw.read(whole).digest == wanted.digest
    assert whole["drive"]["velocity"] is steps


@pytest.mark.parametrize("keys", [("interface.law", "cutoff_velocity"), ("cutoff_velocity", "interface.law")])
def test_keys_of_a_law_are_short_in_the_call_that_chooses_it(keys):
    values = {"interface.law": "ageing-cutoff", "cutoff_velocity": 1e4}
    wanted = sw.read("paper", ["interface.law=ageing-cutoff", "interface.cutoff_velocity=1e4"])
    assert sw.stability("paper", set={key: values[key] for key in keys}).summary == sw.stability(wanted).summary
    assert sw.stability("paper", settings=[f"{key}={values[key]}" for key in keys]).summary == sw.stability(wanted).summary


def test_the_table_of_friction_is_changed_in_a_run_as_elsewhere():
    """`interface` is an option of a run, too."""
    changed = sw.run("paper", "block8", until=20.0, interface={"b": 0.05})
    assert changed.final == sw.run("paper", "block8", until=20.0, b=0.05).final
    assert changed.final != sw.run("paper", "block8", until=20.0).final


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda result: pickle.loads(pickle.dumps(result))])
def test_a_run_with_its_history_is_copied_and_pickled(copied):
    run = sw.run("paper", "block8", until=20.0, interface=True)
    other = copied(run)
    assert other.summary == run.summary
    assert other.dataset.equals(run.dataset)


def test_a_scene_of_a_program_runs_as_long_as_wanted_but_has_no_keys_to_change():
    from dataclasses import replace

    scene = replace(sw.read_scene("paper"), until=20.0)
    assert [sw.run(scene, "block8", until=until).summary["until"] for until in (None, 30.0)] == [20.0, 30.0]
    with pytest.raises(sw.SceneError, match=r"^run.until = -3.0: must be a number from 0.001 to"):
        sw.run(scene, "block8", until=-3.0)
    for change in ({"V": 30.0}, {"a": 0.03}):  # a parameter of the law is a key as any other
        with pytest.raises(sw.SceneError, match="made in Python"):
            sw.run(scene, "block8", **change)


@pytest.mark.parametrize(
    ("work", "told"),
    [
        (lambda: sw.run("paper", model="dg7"), 'did you mean "dg:7"'),
        (lambda: sw.run("paper", untill=5.0), "untill = 5.0: neither an option nor a key of a scene; did you mean until"),
        (lambda: sw.stability("paper", slab={"epsilom": 1.0}), r"did you mean epsilon"),
        (lambda: sw.stability("unlike", log10_r=-2.6), r"log10_r = -2.6: give the whole key, upper.log10_r or lower.log10_r"),
        (lambda: sw.stability("paper", slab={"r": -2.6}), r"slab\.r = -2.6: .*; its logarithm is slab\.log10_r$"),
        (lambda: sw.run("paper", cells="8"), "^cells = '8': must be a whole number or None$"),
        (lambda: sw.run("paper", settings=["slab.r=1", 3]), "^settings = .*: must be a list of texts$"),
        (lambda: sw.branch("paper", over=("log10_r", -2.7)), r"^over = \('log10_r', -2.7\): must be a text, \(a text, a number"),
        (lambda: sw.branch("paper", "log10_r", -2.7, -2.6), "^branch: too many positional arguments$"),
        (lambda: sw.run("paper", set={5: 1.0}), r"^set = \{5: 1.0\}: must be \{a text: values\} or None$"),
        (lambda: sw.curve("paper", "LP", "V=90:95"), "^along: missing; must be given, as in along V=100:120$"),
        (lambda: sw.branch("paper", "V=90:95", stop_at="no--over"), "^stop_at 'no--over': must be one of HB"),
        (lambda: sw.sweep("paper", vary=iter(["V=1:2:2", "V=3:4:2"]), dry=True), "^vary: drive.velocity is given twice"),
        (
            lambda: sw.run("paper", "block8", until=5.0, interface=True, samples="nowhere/kept"),
            "^samples = 'nowhere/kept': the folder 'nowhere' does not exist$",
        ),
        (lambda: sw.stability(), "^stability: missing a required argument: 'source'$"),
    ],
)
def test_wrong_input_is_a_scene_error(work, told):
    with pytest.raises(sw.SceneError, match=told):
        work()


def test_a_program_is_left_in_silence(capsys, monkeypatch):
    monkeypatch.setattr(logging.getLogger("slipwave"), "handlers", [])  # without that of the command line
    sw.run("paper", until=20.0)
    assert capsys.readouterr() == ("", "")


def test_a_result_shows_its_figures():
    found = sw.run("paper", "kelvin-voigt", until=200, **FAST)
    assert "<RunResult: scene = paper, model = kelvin-voigt, until = 200, events = 50, " in repr(found)
    assert "period.mean = 3.93112" in repr(found)
    assert "<tr><th>period.mean</th><td>3.93112</td></tr>" in found._repr_html_()


@pytest.fixture(scope="module")
def turning():
    """From a Hopf point through two folds: 2.703 is passed once before and twice between them."""
    return sw.branch("paper", ("log10_r", -2.72, -2.6995), "kelvin-voigt", tol=1e-4, stop_at="LP")


def test_a_branch_tells_its_points_and_special_points(turning):
    facts = turning.summary
    assert f"points = {len(facts['points'])}, special = HB at -2.69955; LP at -2.70021" in repr(turning)
    assert turning.special == facts["special"]
    assert (turning.special[1].type, turning.points[3].period) == ("LP", facts["points"][3]["period"])
    with pytest.raises(AttributeError, match="BranchResult has no attribute 'multipliers'; it has schema, scene"):
        turning.multipliers  # noqa: B018


def test_the_orbit_of_a_special_point_is_neutral(turning):
    fold = turning.special[1]
    orbit = sw.orbit(fold)
    assert ((orbit.period, orbit.stable), orbit.multipliers.dtype) == ((fold.period, None), complex)
    assert orbit.multipliers[0] == pytest.approx(1.0, abs=1e-2)
    assert orbit.error_estimate.period == pytest.approx(1e-4 * fold.period)
    told = sw.orbit(fold, response=True).summary
    assert (told["response"], "as in a fold" in told["notes"][-1]) == (None, True)
    assert sw.stability(turning.points[0]).log10_r_c == pytest.approx(-2.69955, abs=1e-5)
    with pytest.raises(sw.SceneError, match="at a Hopf point the orbit shrinks to steady sliding"):
        sw.orbit(turning.special[0])


def test_the_orbit_of_a_point_is_that_of_the_grid_of_its_branch():
    point = sw.branch("paper", ("log10_r", -2.6, -2.55), "dg:2", cells=3, most_points=2).points[0]
    assert sw.orbit(point).period == pytest.approx(point.period, rel=1e-6)
    assert sw.orbit(point, cells=4).period != pytest.approx(point.period, rel=1e-3)


def test_the_orbit_of_a_point_beside_a_fold_is_on_the_same_side_of_it():
    """Before, the orbit on the other side of the fold, which was taken for the nearest in period, of the other stability."""
    branch = sw.branch("paper", ("log10_r", -2.7, -2.67), most_points=145)
    folds = [special.log10_r for special in branch.special[1:3]]
    near = [point for point in branch.points if min(abs(point.log10_r - fold) for fold in folds) < 2e-6]
    assert {point.stable for point in near} == {True, False}
    for point in near:
        orbit = sw.orbit(point)
        assert (orbit.period, orbit.stable) == (pytest.approx(point.period, rel=1e-6), point.stable)


def test_points_of_a_branch_are_selected_by_its_parameter(turning):
    """The branch begins at the Hopf point and turns back at the fold: it passes values between them once, then once more."""
    data = turning.dataset
    values, periods = data["point_value"].values, data.period.values
    assert data.period.plot(x="log10_r")[0].get_xdata().tolist() == values.tolist()
    assert data.period.sel(log10_r=float(values[2])).values.tolist() == [periods[2]]
    between = 0.3 * values[2] + 0.7 * values[3]
    assert data.sel(log10_r=between).period.values.tolist() == [periods[3]]
    assert data.sel(log10_r=slice(values[4], values[2])).period.values.tolist() == periods[2:5].tolist()
    with pytest.raises(KeyError, match="the branch goes from"):
        data.sel(log10_r=-2.0)


@pytest.mark.parametrize("name", [name for name in COMMANDS if hasattr(getattr(sw, name, None), "__wrapped__")])
def test_a_value_of_any_other_class_is_refused_by_name(name):
    for one in options_of(getattr(sw, name).__wrapped__.__annotations__["options"]).values():
        with pytest.raises(SceneError, match=f"^{one.name} = .*must be "):
            one.checked(object())


HIDDEN = sorted(name for modules in EXTRAS.values() for name in (*modules, "pandas"))
SCRIPT = f"""
import contextlib, io, json, sys
from importlib.abc import MetaPathFinder

class Hides(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name.partition(".")[0] in {HIDDEN}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Hides())
import slipwave
from validation.commands.cli import main

found = {{}}
for line in sys.stdin.read().splitlines():
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main(line.split())
    found[line] = status, out.getvalue(), err.getvalue()
motion = slipwave.run("paper", model="block8", until=5)
try:
    motion.dataset
except slipwave.SceneError as error:
    found["dataset"] = str(error)
print(json.dumps(found))
"""
WORK = {
    "run paper --model block8 --until 60 --json": ("events", 1),
    "stability paper --json": ("unstable_roots", 2),
    "compare paper --models block8,kelvin-voigt --until 5 --json": ("reference", "block8"),
    "orbit paper --model block8 --tol 1e-3 --json": ("period", pytest.approx(76.610300, rel=1e-6)),
}
NO_FILES = "needs xarray and netCDF4 and meshio: pip install 'slipwave[files]'"
REFUSED = {
    "run paper --plot run.png": "--plot = 'run.png': needs matplotlib: pip install 'slipwave[plot]'",
    "run paper --model dg:3 --fields last.vtu": f"--fields = 'last.vtu': {NO_FILES}",
    "run run.nc": f"SCENE = 'run.nc': {NO_FILES}",
    "run paper --model fem:4": "model = 'fem:4': needs skfem: pip install 'slipwave[fem]'",
    "compare paper --models delay,fd": "--out = 'compare.png': needs matplotlib: pip install 'slipwave[plot]'",
    "report --quick": f"the report: needs {' and '.join(name for extra in OF_THE_REPORT for name in EXTRAS[extra])}: "
    "pip install 'slipwave[report]'",
}


def test_a_light_install_runs_and_says_what_it_lacks(tmp_path):
    words = "\n".join([*WORK, *REFUSED])
    done = subprocess.run([sys.executable, "-c", SCRIPT], input=words, capture_output=True, text=True, check=True, cwd=tmp_path)
    found = json.loads(done.stdout)
    for line, (key, value) in WORK.items():
        status, out, err = found[line]
        assert status == 0, err
        assert json.loads(out)[key] == value
    for line, told in REFUSED.items():
        assert found[line] == [2, "", f"slipwave: {told}\n"]
    assert found["dataset"] == f"a dataset: {NO_FILES}"
    assert list(tmp_path.iterdir()) == []


_COUNT = """
import sys
from pathlib import Path
from threading import get_native_id

import numpy as np

import slipwave as sw

work = {
    "run": lambda: [sw.run("paper", model, until=400) for model in ("delay", "quasidynamic")],
    "orbit": lambda: sw.orbit("layered"),
}[sys.argv[1]]


def waits():
    others = [path for path in Path("/proc/self/task").iterdir() if path.name != str(get_native_id())]
    return sum(int((path / "status").read_text().split("\\nvoluntary_ctxt_switches:")[1].split()[0]) for path in others)



work()  # loads and compiles
before = waits()
work()
after = waits()
np.ones((400, 400)) @ np.ones((400, 400))
print(after - before, waits() - after)
"""


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts of thread switches are read from Linux's /proc")
@pytest.mark.parametrize("work", ["run", "orbit"])
def test_threads_of_blas_sleep_while_a_command_of_python_computes(work):
    free = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    free["OPENBLAS_THREAD_TIMEOUT"] = "4"  # idle threads sleep at once
    done = subprocess.run([sys.executable, "-c", _COUNT, work], env=free, capture_output=True, text=True, check=True)
    woken, by_a_product = map(int, done.stdout.split())
    if not by_a_product:
        pytest.skip("BLAS has one thread here")
    assert woken == 0


def test_a_family_that_is_edited_and_loaded_again_is_the_one_that_is_analysed(tmp_path):
    """Before, `stability` kept the numbers of the first."""
    text = (
        "from reduced.impedance.reduction import Reduction\nfrom slipwave.family import Family\n"
        'EDITED = Family("edited", f"{__name__}:edited", "a block")\n'
        "def edited(scene, name):\n    return Reduction(name, mass=1.0 / 12.0)\n"
    )
    path, found = tmp_path / "edited.py", []
    for mass in ("12.0", "8.0"):
        path.write_text(text.replace("12.0", mass))
        found.append(sw.stability("paper", "edited", family=path).log10_r_c)
    assert found == [sw.stability("paper", block).log10_r_c for block in ("block12", "block8")]
    assert found[0] != found[1]
