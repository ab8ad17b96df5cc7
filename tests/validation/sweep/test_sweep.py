"""Sweeps: the same arrays however they are computed, nothing lost when killed, one line for whatever is wrong."""

import contextlib
import itertools
import json
import multiprocessing
import os
import resource
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

import slipwave as sw
from reduced.delay import alike
from slipwave.errors import SceneError
from slipwave.friction import LAWS
from validation.commands.cli import main
from validation.commands.map import _difference, _difference_rows
from validation.models.parameter import Variation
from validation.sweep.engine import Engine, compute
from validation.sweep.executors import processes, started
from validation.sweep.map_figures import _other_side, chart_of_sweep
from validation.sweep.measures import VERDICTS
from validation.sweep.plan import axis_of
from validation.sweep.refine import refine
from validation.sweep.store import Store
from validation.sweep.sweep import _manifest_of, perform_sweep, plan_of

DISC = "tests.validation.sweep_measures:disc"


class Here(Executor):
    _max_workers = 2

    def submit(self, function, /, *given, **named):
        future = Future()
        future.set_result(function(*given, **named))
        return future


HERE = Here()


def plan(counts=(5, 4), measure=DISC, models=("delay",), **options):
    axes = [axis_of("a", f"0.001:0.019:{counts[0]}"), axis_of("b", f"0.011:0.029:{counts[1]}")]
    return plan_of(Variation(sw.read_scene("paper")), axes, models, measure, **options)


def computed(what, folder, workers=0, executor=HERE, **how):
    from validation.sweep.gather import dataset_of, filled_arrays

    store = Store(folder)
    perform_sweep(what, store, started(workers, executor=executor), **how)
    return dataset_of(what, filled_arrays(what, store))


def same(one, other):
    return all(np.array_equal(one[name].values, other[name].values, equal_nan=one[name].dtype.kind == "f") for name in one)


@pytest.mark.parametrize(
    ("scene", "axes"),
    [
        ("paper", {"slab.log10_r": "-2.7:-2.2:3", "V": "1:900:3:log", "interface.a": "0.005,0.012"}),
        ("paper", {"interface.law": "ageing,slip", "V": "10,100"}),
        ("rock", {"slab.thickness": "0.5m:20m:3:log", "slab.shear_modulus": "20GPa,30GPa", "drive.velocity": "1um/s,10um/s"}),
        ("unlike", {"ratio_r": "0.5:2:3", "log10_r": "-2.7,-2.3", "V": "10,100"}),
        ("machine", {"face.stiffness": "0.5,1", "ratio_epsilon": "1,3", "V": "10,100"}),
        ("paper-si", {"slab.thickness": "2cm,4cm", "run.until": "1s,2s"}),
        ("paper-si", {"interface.reference_velocity": "1um/s,2um/s", "drive.velocity": "0.1mm/s,0.2mm/s"}),
    ],
)
def test_the_scene_of_a_point_is_the_scene_with_its_changes(scene, axes):
    """Put together from scenes with one changed key each, in any order, or read whole where two keys change one slab."""
    what = plan_of(Variation(sw.read_scene(scene)), [axis_of(key, values) for key, values in axes.items()], ["delay"], DISC)
    for point in np.random.default_rng(4).permutation(what.size):
        found, wanted = what.scene(int(point)), what.scenes.scene(what.changes(int(point)))
        assert (found, found.digest, found.tables) == (wanted, wanted.digest, wanted.tables)


def test_equal_scenes_written_in_other_tables_have_keys_of_their_own():
    slab = {"epsilon": 2.8e-5, "r": 0.002}
    scenes = [
        sw.read_scene({"interface": sw.read_scene("paper").tables["interface"], "drive": {"velocity": 100.0}} | slabs)
        for slabs in ({"slab": slab}, {"upper": slab, "lower": slab})
    ]
    assert scenes[0] == scenes[1]
    assert [Variation(scene).key_of("r") for scene in scenes] == ["slab.r", "r"]


@pytest.mark.parametrize("scene", ["paper-si", "steel-on-pmma"])
def test_times_in_seconds_are_as_many_at_every_r(scene):
    knots = [[0.0, "1 mm/s"], [0.5, "2 mm/s"], ["1 ms", "2 mm/s"], ["1.5 ms", "1 mm/s"]]
    base = sw.read_scene(scene, **{"run.until": "2 ms", "drive.velocity": knots})
    what = plan_of(Variation(base), [axis_of("log10_r", [-4.7, -4.5])], ["delay"], "run")
    for point in map(what.scene, range(2)):
        transit = point.transit * base.units.time
        assert (point.until * transit, *(time * transit for time in point.drive.times[2:])) == pytest.approx(
            (2e-3, 1e-3, 1.5e-3), rel=1e-12
        )
        assert point.drive.times[:2] == (0.0, 0.5)


@pytest.mark.parametrize(("axis", "factor"), [(("slab.thickness", ["3.3 cm", "6.6 cm"]), None), (("V", [1000, 2000]), 1.848e-3)])
def test_the_size_of_a_transit_is_told_where_it_is_that_of_every_point(axis, factor, tmp_path):
    """2 H/c, c = sqrt(G/rho) = 1000/28 m/s; before, that of the base scene was stated for all thicknesses."""
    base = sw.read("paper-si", {"run.until": 30.0, "slab.thickness": 0.033})
    found = computed(plan_of(Variation(base), [axis_of(*axis)], ["block8"], "run", tol=1e-6), tmp_path / "map")
    assert found["until"].attrs.get("si_factor") == (factor and pytest.approx(factor, rel=1e-12))
    assert found["until"].attrs["si_units"] == "s"
    assert found["until_s"].values == pytest.approx(30.0 * 1.848e-3 * np.array([1.0, 1.0 if factor else 2.0]), rel=1e-12)
    assert found["final_v"].attrs["si_factor"] == 1e-6


def test_a_growth_rate_has_its_unit_and_a_twin_in_si(tmp_path):
    """Before, it was a pure number by its attributes, and nothing of the measure was in SI."""
    what = plan_of(Variation(sw.read("paper-si")), [axis_of("slab.thickness", ["3.3 cm", "3.5 cm"])], ["block8"], "stability")
    point = computed(what, tmp_path / "map").isel(slab_thickness=1)
    found = sw.stability("paper-si", "block8", **{"slab.thickness": 0.035})
    notes = point["growth_rate"].attrs
    assert (notes["in_units_of"], notes["si_units"], notes["si_factor"]) == ("V*/L", "s-1", pytest.approx(1.0 / 0.9, rel=1e-12))
    assert float(point["growth_rate_per_s"]) == pytest.approx(1.0 / found.si.growth_time_s, rel=1e-9)
    assert float(point["angular_frequency_per_s"]) == pytest.approx(2.0 * np.pi * found.si.frequency_Hz, rel=1e-9)


def test_a_point_does_not_depend_on_the_points_before_it():
    """Tables that are made once for many runs: random points in random order, and each alone with all tables made anew."""
    axes = [axis_of("log10_r", "-2.75:-2.2:9"), axis_of("V", "1:1000:7:log")]
    what = plan_of(Variation(sw.read_scene("paper", **{"run.until": 100})), axes, ["delay"], "run", tol=1e-6)
    points = np.random.default_rng(7).permutation(what.size)[:12]
    together = compute(what, np.concatenate((points, points[::-1])))[0]
    for place, point in enumerate(points):
        alike._transit_mesh.cache_clear()
        alike._read_at.cache_clear()
        alone = compute(replace(what), np.array([point]))[0]
        for name, value in alone.items():
            for row in (place, 2 * points.size - 1 - place):
                assert np.array_equal(together[name][row : row + 1], value, equal_nan=value.dtype.kind == "f"), name


def test_arrays_do_not_depend_on_who_computes_them(tmp_path):
    verdicts = plan((2, 2), "verdict", ("block12", "kelvin-voigt"), tol=1e-6)
    here = computed(verdicts, tmp_path / "here")
    with ThreadPoolExecutor(3) as threads:
        assert same(here, computed(verdicts, tmp_path / "threads", executor=threads))
    assert same(here, computed(verdicts, tmp_path / "processes", executor=None, workers=2))


def test_a_point_of_a_sweep_is_a_run(tmp_path):
    what = plan_of(
        Variation(sw.read("paper", {"run.until": 1500.0})), [axis_of("log10_r", [-2.68, -2.6])], ["kelvin-voigt"], "run", tol=1e-8
    )
    point = computed(what, tmp_path / "run").isel(log10_r=1)
    run = sw.run("paper", "kelvin-voigt", until=1500.0, tol=1e-8, log10_r=-2.6)
    assert point["final_psi"].item() == run.done.final.psi
    assert point["period"].item() == run.done.statistics.period.mean


def test_parts_of_a_job_array_and_a_resumed_sweep_are_the_whole(tmp_path):
    whole = computed(plan((7, 5)), tmp_path / "whole")
    for number in (3, 1, 2):
        parts = computed(plan((7, 5)), tmp_path / "parts", part=(number, 3))
    assert same(whole, parts)
    for path in list((tmp_path / "parts" / "parts").iterdir())[::2]:
        path.write_bytes(path.read_bytes()[:-7])  # a truncated part counts as absent
    assert same(whole, computed(plan((7, 5)), tmp_path / "parts"))


def test_a_half_done_sweep_can_be_gathered(tmp_path, answer):
    computed(plan((6, 6)), tmp_path / "half", part=(1, 2))
    told = answer("sweep", str(tmp_path / "half"), "--gather")
    assert (told["points"], told["done"]) == (36, 18)
    data = xarray.load_dataset(tmp_path / "half" / "sweep.nc")
    there = data["status"].values == 0
    assert there.sum() == 18
    x, y = ((data[name].values - middle) / 0.01 for name, middle in (("a", 0.01), ("b", 0.02)))
    np.testing.assert_allclose(data["height"], np.where(there, np.subtract.outer(2.0 * x, y), np.nan), atol=1e-12)


@pytest.mark.parametrize("counts", [(65, 33), (33, 65)])
def test_refinement_finds_what_the_full_lattice_shows(tmp_path, counts):
    full = computed(plan(counts), tmp_path / "full")
    what = plan(counts, refine=3)
    found = computed(what, tmp_path / "refined")
    shown = found["regime"].values == full["regime"].values
    assert 0 < (found["status"].values == 0).sum() < 0.6 * shown.size
    assert shown.all()
    assert np.allclose(found["height"].values, full["height"].values, atol=1e-12)


def test_refinement_does_not_depend_on_what_is_there(tmp_path):
    what = plan((33, 33), refine=3)
    found = computed(what, tmp_path / "one")
    store = Store(tmp_path / "two")
    store.begin(_manifest_of(what))
    Engine(what, store, Here, 1).run(what.order[100:300])  # points of all levels, of which some are not needed
    again = computed(what, tmp_path / "two")
    needed = found["status"].values == 0
    assert (again["status"].values[needed] == 0).all()
    assert np.array_equal(found["regime"].values, again["regime"].values)


def reading(what, truth):
    """Regimes that are known so far, and how more of them become known."""
    known = np.full(what.shape, -1)

    def compute(points):
        known.reshape(-1)[points] = truth.reshape(-1)[points]

    return known, compute, lambda: known.reshape(-1)


def test_the_audit_sees_an_island():
    """A regime smaller than a cell is found where a cell is divided by chance, and its surroundings are then computed."""
    what = plan((129, 129), refine=3)
    island = np.zeros(what.shape, dtype=int)
    known, *how = reading(what, island)
    assert refine(what, 3, *how)[1] == 0
    fresh = np.argwhere((known[0] >= 0) & (np.add.outer(np.arange(129) % 8, np.arange(129) % 8) > 0))
    island[0, *fresh[0]] = 1
    again, *how = reading(what, island)
    assert refine(what, 3, *how)[1] >= 1
    assert (again >= 0).sum() > (known >= 0).sum()


@pytest.fixture
def forked(monkeypatch):
    """Processes of a sweep are copies of this one, which need to import nothing; elsewhere they are spawned."""
    copies = multiprocessing.get_context("fork")
    monkeypatch.setattr(multiprocessing, "get_context", lambda method: copies)
    return copies


copies_processes = pytest.mark.skipif("forkserver" not in multiprocessing.get_all_start_methods(), reason="spawns processes")


@copies_processes
def test_processes_of_all_sweeps_are_copies_of_one_other():
    parents = []
    for _ in range(2):
        with processes(1) as start:
            parents.append(start().submit(os.getppid).result())
    assert parents[0] == parents[1] != os.getpid()


@copies_processes
@pytest.mark.parametrize("is_typed", [False, True])
def test_processes_do_not_run_the_script_of_a_sweep_again(tmp_path, is_typed):
    script = """
import slipwave as sw
axes = {"log10_r": (-2.7, -2.6, 2)}
found = sw.sweep("paper", vary=axes, models="block12", measure="stability", out="map", workers=2).summary
print(found["done"], found["failed"])
"""
    (tmp_path / "script.py").write_text(script)
    words, given = (["-"], script) if is_typed else (["script.py"], None)
    done = subprocess.run([sys.executable, *words], cwd=tmp_path, input=given, text=True, capture_output=True, timeout=300)
    assert (done.returncode, done.stdout, done.stderr) == (0, "2 0\n", "")


@pytest.fixture
def marks(tmp_path, monkeypatch):
    """A folder in which a measure counts its deaths."""
    (tmp_path / "marks").mkdir()
    monkeypatch.setenv("SLIPWAVE_TEST_MARKS", str(tmp_path / "marks"))
    return tmp_path / "marks"


def test_a_killed_worker_is_a_part_done_again(tmp_path, marks, forked):
    axes = [axis_of("a", [0.010, 0.011, 0.012, 0.013, 0.014, 0.015])]
    what = plan_of(Variation(sw.read_scene("paper")), axes, ["delay"], "tests.validation.sweep_measures:deadly")
    data = computed(what, tmp_path / "deadly", executor=None, workers=2)
    assert data["status"].values.tolist() == [0, 0, 3, 0, 0, 0]
    assert "killed 3 times" in str(data["reason"].values[2])
    assert np.allclose(np.delete(data["sum"].values, 2), np.delete(np.array(axes[0].values) + sw.read_scene("paper").law.b, 2))


def test_a_point_that_cannot_be_computed_has_a_reason(tmp_path):
    axes = [axis_of("a", [0.011, 0.012, 0.013])]
    data = computed(
        plan_of(Variation(sw.read_scene("paper")), axes, ["delay"], "tests.validation.sweep_measures:wrong"), tmp_path / "wrong"
    )
    assert data["status"].values.tolist() == [0, 2, 0]
    assert "ZeroDivisionError" in str(data["reason"].values[1])
    rows = tmp_path / "rows.csv"
    rows.write_text("log10_r,model_of_nobody\n-2.5,1\n")
    assert main(["sweep", "paper", "--rows", str(rows), "--measure", DISC, "--out", str(tmp_path / "rows")]) == 0
    assert main(["sweep", str(tmp_path / "rows"), "--gather"]) == 0
    refused = xarray.load_dataset(tmp_path / "rows" / "sweep.nc")
    assert refused["status"].values.tolist() == [1]
    assert "model_of_nobody" in str(refused["reason"].values[0])


@pytest.mark.parametrize("moment", range(5))
def test_a_sweep_killed_at_any_moment_goes_on(tmp_path, moment, forked):
    generator = np.random.default_rng(moment)
    words = ["paper", "--vary", "a=0.001:0.019:10", "b=0.011:0.029:10", "--measure", "tests.validation.sweep_measures:slowly"]
    folder = tmp_path / "killed"
    running = forked.Process(target=main, args=(["sweep", *words, "--workers", "2", "--out", str(folder)],))
    running.start()
    wanted = int(generator.integers(1, 6))
    while running.is_alive() and len(list((folder / "parts").glob("[0-9]*.npz"))) < wanted:
        time.sleep(0.005)
    children = Path(f"/proc/{running.pid}/task/{running.pid}/children")
    victims = [int(word) for word in children.read_text().split()] if running.is_alive() else []
    victim = running.pid if moment % 2 == 0 or not victims else int(generator.choice(victims))
    if victim == running.pid:
        running.kill()
    elif running.is_alive():
        with contextlib.suppress(ProcessLookupError):  # it may end just now
            os.kill(victim, signal.SIGKILL)
    running.join()
    result = sw.sweep(folder, executor=Here(), measure="tests.validation.sweep_measures:slowly")
    x, y = np.linspace(0.001, 0.019, 10), np.linspace(0.011, 0.029, 10)
    assert result.summary["done"] == 100
    assert np.array_equal(result.dataset["sum"].values, x[:, None] + y)


def test_a_full_disk_costs_no_finished_part(tmp_path):
    """Files of more than 6 kB cannot be written: the large parts at the end."""
    what = plan((60, 60))
    copy = os.fork()
    if copy == 0:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (6000, 6000))
        try:
            computed(what, tmp_path)
        except SceneError as error:
            os._exit(2 if "cannot be written" in str(error) else 3)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1]) == 2
    there = {path.name for path in (tmp_path / "parts").iterdir()}
    assert there
    assert all(name.endswith(".npz") and not name.startswith(".") for name in there)
    data = computed(what, tmp_path)
    assert (data["status"].values == 0).all()
    assert there <= {path.name for path in (tmp_path / "parts").iterdir()}
    assert same(data, computed(what, tmp_path / "whole"))


def test_every_late_cycle_of_a_run_is_in_its_brush(tmp_path):
    scene = sw.read("paper-si", {"run.until": 1500.0})
    what = plan_of(Variation(scene), [axis_of("log10_r", [-2.75, -2.6])], ["kelvin-voigt"], "cycles", tol=1e-8)
    data = computed(what, tmp_path / "brush")
    steady, brush = (data.isel(log10_r=k) for k in (0, 1))
    events = sw.run(scene, "kelvin-voigt", tol=1e-8, log10_r=-2.6).done.events
    late = events.period[events.time >= 750.0]
    assert data["cycle_period"].dims == ("log10_r", "cycle")
    assert 5 < late.size < 64
    assert np.array_equal(brush["cycle_period"].values[: late.size], late)
    assert np.isnan(brush["cycle_period"].values[late.size :]).all()
    assert brush["cycle_period_s"].values[0] / late[0] == pytest.approx(brush["period_s"].item() / brush["period"].item())
    assert not (steady["cycle_stress_drop"].values > 0.2).any()
    assert (chart_of_sweep(data).panels[0].traces[0].columns["y"] == brush["cycle_period_s"].values[0]).any()


def test_the_other_side_of_an_axis_has_the_other_units():
    rock = sw.read("rock")
    data = xarray.Dataset(attrs={"scene_toml": sw.show("rock")})
    axis = lambda key, first, unit="1": xarray.DataArray([first], attrs={"long_name": key, "units": unit}, name="axis")  # noqa: E731
    thick, fast = _other_side(data, axis("slab.thickness", 42.0, "cm")), _other_side(data, axis("V", 1e4))
    assert thick is not None
    assert fast is not None
    assert 21.0 * thick.factor == pytest.approx(rock.transit, rel=1e-12)
    assert (fast.label, 1e4 * fast.factor) == ("V / (m/s)", pytest.approx(0.01, rel=1e-12))
    power = _other_side(data, axis("log10_r", -2.0))
    assert power is not None
    assert power.is_power
    assert power.factor == pytest.approx(rock.units.time if rock.units else 0.0, rel=1e-12)
    assert _other_side(data, axis("a", 0.01)) is None


def test_another_sweep_in_the_folder_is_refused(tmp_path, refused):
    out, manifest = str(tmp_path / "out"), tmp_path / "out" / "manifest.json"
    computed(plan((3, 2)), tmp_path / "out")
    words = ["sweep", "paper", "--measure", DISC, "--workers", "1", "--out", out, "--vary", "a=0.01:0.02:3"]
    assert "holds another sweep (axes changed)" in refused(*words)
    changed = json.loads(manifest.read_text())
    changed["program"]["code"] = "another"
    for text, told in ((json.dumps(changed), "program: code changed"), ("{", "damaged")):
        manifest.write_text(text)
        assert told in refused("sweep", out, "--measure", DISC)
    manifest.write_text(json.dumps(changed))
    told = refused("sweep", "rock", "--measure", DISC, "--out", out, "--vary", "a=0.01:0.02:3")
    assert "scene = paper, now rock" in told
    assert len(told) - len(out) < 300


def test_what_a_folder_gives_is_not_asked_for_again(tmp_path, refused):
    computed(plan((3, 2)), tmp_path / "map")
    folder = str(tmp_path / "map")
    for words in (["--until", "10"], ["--tol", "1e-3"], ["--vary", "V=1,2"], ["--models", "fd"], ["--refine", "1"]):
        assert f"slipwave: {words[0]}: leave it out; {folder!r} holds a sweep" in refused("sweep", folder, *words)
    assert "V = '50': leave it out" in refused("sweep", folder, "--set", "V=50")
    assert "V = '50': leave it out" in refused("map", folder, "--set", "V=50")
    with pytest.raises(SceneError, match=r"shwo = 'verdict': leave it out; .*; did you mean show\?"):
        sw.map(folder, shwo="verdict")
    sw.sweep("paper", vary={"V": [90.0, 100.0]}, until=10, workers=1, out=tmp_path / "other")
    assert "--measure: leave it out" in refused("sweep", str(tmp_path / "other"), "--measure", "run")


def test_models_are_a_list_or_a_text():
    axis = {"log10_r": [-2.75, -2.65]}
    listed, written = (
        sw.sweep("paper", vary=axis, models=m, measure="stability", workers=1) for m in (["block8", "delay"], "block8,delay")
    )
    assert listed.summary["models"] == ["block8", "delay"]
    assert listed.dataset["stable"].equals(written.dataset["stable"])
    with pytest.raises(SceneError, match=r"^models = \[\]: must be one name or more"):
        sw.sweep("paper", vary=axis, models=[])


def test_a_dry_sweep_computes_nothing(tmp_path, answer, monkeypatch):
    monkeypatch.setattr("validation.sweep.engine.time.perf_counter", itertools.count(0.0, 0.25).__next__)
    told = answer("sweep", "paper", "--vary", "a=0.01:0.02:30", "--measure", DISC, "--out", str(tmp_path / "x"), "--dry")
    assert told["expected"]["points"] == 30
    assert (told["expected"]["seconds_per_point"], told["expected"]["seconds"]) == (0.25, 7.5 / told["expected"]["workers"])
    assert not (tmp_path / "x").exists()


def test_difference_of_two_models_in_per_cent_of_the_area():
    kinds = [VERDICTS.index(word) for word in ("steady", "decaying", "periodic", "irregular", "too short")]
    here, there = np.array(list(itertools.product(kinds, kinds))).T
    period = np.linspace(1.0, 2.0, here.size)
    data = xarray.Dataset(
        {
            "verdict": (("model", "a"), np.array([here, there])),
            "status": (("model", "a"), np.zeros((2, here.size), dtype=np.int8)),
            "period": (("model", "a"), np.array([period, 1.1 * period])),
            "stress_drop": (("model", "a"), np.array([period, 0.8 * period])),
        },
        coords={"model": ["delay", "block12"], "a": period},
    )
    row = _difference_rows(_difference(data, "delay"))[0]
    assert row["other_regime_percent"] == pytest.approx(100.0 * 10 / 16)
    assert (row["period"], row["stress_drop"]) == pytest.approx((0.1, -0.2))


def test_a_map_shows_the_boundary_of_stability_within_a_cell(tmp_path):
    axes = [axis_of("log10_r", "-2.75:-2.6:16"), axis_of("V", "10:1000:3:log")]
    what = plan_of(Variation(sw.read_scene("paper")), axes, ["delay"], "stability")
    data = computed(what, tmp_path / "map")
    stable = (data["stable"] == "yes").values
    lines = sw.map(tmp_path / "map").boundaries
    for number, velocity in enumerate(data["drive_velocity"].values):
        row = stable[:, number]
        last = float(data["log10_r"].values[row][-1])
        critical = float(np.interp(velocity, *np.array(sorted(zip(lines[0].up, lines[0].across, strict=True))).T))
        assert last <= critical <= last + 0.0101


def test_a_map_takes_the_result_of_a_sweep_and_says_regimes(tmp_path):
    options = {"models": "kelvin-voigt,quasidynamic", "until": 1500.0, "tol": 1e-6, "workers": 1}
    swept = sw.sweep("paper", out=tmp_path / "out", vary={"log10_r": (-2.75, -2.62, 2)}, **options)
    assert sw.map(swept, against="kelvin-voigt").summary == sw.map(tmp_path / "out", against="kelvin-voigt").summary
    assert sw.map(swept).regimes("kelvin-voigt").tolist() == [0, 1]  # steady sliding, stick-slip that repeats
    with pytest.raises(SceneError, match="model = delay: the sweep has verdicts of kelvin-voigt, quasidynamic"):
        sw.map(swept).regimes("delay")
    with pytest.raises(SceneError, match="SCENE = RunResult: must be the result"):
        sw.map(sw.run("paper", model="quasidynamic", until=20.0))


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("a_word", "returns x = 'word'; must return numbers by name, as {'x': 1.0}"),
        ("a_list", "returns x = array([0., 1., 2.]); must return numbers by name, as {'x': 1.0}"),
        ("a_status", "returns a number called 'status'; its name must be another text"),
        ("a_number", "returns 1.0; must return numbers by name, as {'x': 1.0}"),
        ("two_lines", "RuntimeError: no way"),
    ],
)
def test_a_measure_that_returns_no_numbers_says_so(name, reason):
    """Before, its process died, and was said to have run out of memory."""
    label = f"tests.validation.sweep_measures:{name}"
    found = sw.sweep("paper", vary="b=0.049,0.05", measure=label, executor=Here()).dataset
    wanted = reason if name == "two_lines" else f"--measure = {label!r}: {reason}"
    assert [*found.reason.values.ravel()] == [wanted, wanted]


def test_a_measure_may_return_numbers_of_numpy_and_none():
    found = sw.sweep("paper", vary="a=0.03,0.04", measure="tests.validation.sweep_measures:sizes", executor=Here()).dataset
    assert found["flag"].values.ravel().tolist() == [1.0, 1.0]
    assert found["count"].values.ravel().tolist() == [3.0, 3.0]


def test_a_law_of_a_notebook_is_refused_before_processes_look_for_it(monkeypatch):
    monkeypatch.setattr(LAWS["slip"].parameters, "__module__", "__main__")
    told = r"^friction law 'slip': is registered in the main part of a script or in a notebook, .*: write it to a file, and give"
    with pytest.raises(SceneError, match=told):
        sw.sweep("slip-law", vary="b=0.049,0.05", measure="stability", workers=1)
    assert sw.sweep("slip-law", vary="b=0.049,0.05", measure="stability", executor=Here()).summary["done"] == 2
