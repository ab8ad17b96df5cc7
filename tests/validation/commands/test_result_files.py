"""Results as Datasets and netCDF files: values, units, stages of protocols, and that they can be computed again."""

import csv
import io
import json
import math
import re
import tomllib
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import xarray

import slipwave
import slipwave as sw
from slipwave.errors import SceneError
from slipwave.friction.law import LAWS
from slipwave.friction.own import LAW_FILES
from slipwave.input.assemble import gallery_names
from validation.commands.cli import INPUT_WRONG, main
from validation.models.provenance import provenance

ROOT = Path(__file__).resolve().parents[3]
SHORT = {"drive.velocity": 2000, "slab.thickness": 0.0335}
"""Cycles of four transits of `paper-si`."""
WORDS = ("--set", "drive.velocity=2000", "slab.thickness=0.0335")


@pytest.fixture
def again(answer):
    """The JSON of a command but for its run time."""
    return lambda *words: {key: value for key, value in answer(*words).items() if key != "wall_s"}


def test_links_that_lead_nowhere_are_one_line(tmp_path, monkeypatch, capsys):
    """Before, a link was suggested for itself, and rings of links ended in tracebacks."""
    monkeypatch.chdir(tmp_path)
    links = {
        "dangling.toml": "nowhere",
        "ring.py": "other.py",
        "other.py": "ring.py",
        "ring.nc": "other.nc",
        "other.nc": "ring.nc",
    }
    for name, target in links.items():
        (tmp_path / name).symlink_to(target)
    assert main(["run", "dangling.toml"]) == INPUT_WRONG
    assert capsys.readouterr().err == "slipwave: SCENE = 'dangling.toml': no such file\n"
    assert main(["show", "paper", "--family", "ring.py"]) == INPUT_WRONG
    assert re.fullmatch(r"slipwave: --family = '.*ring\.py': no such file\n", capsys.readouterr().err)
    run = ["run", "paper", "--model", "block8", "--until", "20", "--out"]
    assert main([*run, "ring.nc"]) == 0  # a file takes its place in the ring
    assert (tmp_path / "ring.nc").is_file()
    for name, target in {"later.nc": "kept.nc", "lost.nc": "nowhere/x.nc", "ring": "ring"}.items():
        (tmp_path / name).symlink_to(target)
    assert main([*run, "later.nc"]) == 0
    assert ((tmp_path / "later.nc").is_symlink(), (tmp_path / "kept.nc").is_file()) == (
        True,
        True,
    )  # before, it took the link's place
    capsys.readouterr()
    assert main([*run, "lost.nc"]) == INPUT_WRONG
    assert re.fullmatch(r"slipwave: --out = 'lost\.nc': the folder '.*nowhere' does not exist\n", capsys.readouterr().err)
    assert main(["sweep", "paper", "--vary", "V=1,2", "--out", "ring"]) == INPUT_WRONG
    assert "slipwave: 'ring/manifest.json' cannot be read: too many levels of symbolic links" in capsys.readouterr().err


def test_a_run_as_a_dataset_has_its_cycles_in_both_units(tmp_path):
    result = sw.run("paper-si", "kelvin-voigt", until=200, interface=True, **SHORT)
    data, scene = result.dataset, result.done.solver.scene
    assert scene.units is not None
    half = data["event_time"] >= 100.0
    assert float(data["period"][half].mean()) == result.summary["period"]["mean"]
    transit = scene.transit * 9e-7 / 1e-6  # in L / V*
    sizes = {"period_s": transit, "stress_drop_Pa": 1000.0, "v_max_m_per_s": 1e-6, "event_time_s": transit}
    for (name, size), plain in zip(sizes.items(), ("period", "stress_drop", "v_max", "event_time"), strict=True):
        np.testing.assert_allclose(data[name], data[plain] * size, rtol=1e-14)
        assert (data[plain].attrs["si_factor"], data[plain].attrs["units"]) == (pytest.approx(size, rel=1e-14), "1")
    assert {data[name].attrs["units"] for name in sizes} == {"s", "Pa", "m s-1"}
    assert set(data.coords) == {"time", "time_s", "event_time", "event_time_s"}
    assert float(data["time_s"][-1]) == pytest.approx(200.0 * transit, rel=1e-12)
    assert float(data["interface_psi"][-1]) == result.summary["final"]["psi"]
    result.to_netcdf(tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc") as stored:
        xarray.testing.assert_identical(stored.drop_attrs(), data.drop_attrs())
        assert {name: stored[name].attrs for name in stored.variables} == {name: data[name].attrs for name in data.variables}


def test_what_is_given_goes_before_what_the_file_holds(tmp_path):
    """The model, the length, a key of the scene, an option; what is not given is the file's: then all numbers are the same
    (`test_twice`)."""
    sw.run("paper", "kelvin-voigt", until=20, tol=1e-4, **{"slab.log10_r": -2.6}).to_netcdf(tmp_path / "x.nc")
    with xarray.open_dataset(tmp_path / "x.nc") as file:
        assert (file.attrs["model"], file.attrs["schema"], json.loads(file.attrs["options"])["tol"]) == ("kelvin-voigt", 1, 1e-4)
    assert sw.read(tmp_path / "x.nc").digest == sw.read("paper", {"slab.log10_r": -2.6, "run.until": 20.0}).digest
    same, other = sw.run(tmp_path / "x.nc"), sw.run(tmp_path / "x.nc", "block8", until=12, tol=1e-5, **{"slab.r": 0.002})
    facts = [(one.done.solver.model, one.done.until, one.options["tol"], one.done.solver.scene.transit) for one in (same, other)]
    assert facts == [("kelvin-voigt", 20.0, 1e-4, 10.0**-2.6), ("block8", 12.0, 1e-5, 0.002)]


def test_thinning_and_window_keep_what_they_say(tmp_path):
    whole = sw.run("paper", "block8", until=60, interface=True).dataset
    part = sw.run("paper", "block8", until=60, every=7, window=(20.0, 45.5)).dataset
    inside = whole.isel(time=(whole["time"] >= 20.0) & (whole["time"] <= 45.5)).isel(time=slice(None, None, 7))
    assert part["time"].size > 20
    xarray.testing.assert_equal(part, inside)
    text = sw.run("paper", "block8", until=60, every=7, window="2e1:45.5").dataset
    xarray.testing.assert_equal(part, text)
    for window, inside in (("20:", whole["time"] >= 20.0), (":45.5", whole["time"] <= 45.5)):
        xarray.testing.assert_equal(sw.run("paper", "block8", until=60, window=window).dataset, whole.isel(time=inside))
    none = sw.run("paper", "block8", until=20, window=(30.0, 40.0))
    assert none.dataset["interface_psi"].size == 0
    assert none.notes == ["nothing is kept: the window begins at t = 30, the run ended at t = 20 transits"]
    with pytest.raises(SceneError, match="rate = '5GHz': needs a scene in SI"):
        sw.run("paper", "block8", until=20, rate="5GHz")


@pytest.mark.parametrize(
    "kept",
    [
        {"every": 7},
        {"every": 1, "window": (5.0, 25.0)},  # the checkpoint, at t = 30, lies behind it, within it, before it
        *({"every": every, "window": (20.3, 45.6)} for every in (2, 7)),
        {"every": 3, "window": (40.0, 55.0)},
        {"rate": 13, "window": (20.3, 45.6)},
    ],
)
def test_a_run_that_goes_on_keeps_the_same_samples(tmp_path, kept):
    saving = {"checkpoint": str(tmp_path / "run.npz"), "checkpoint_every": 10.0} | kept
    sw.run("paper", "block8", until=30, **saving)
    resumed = sw.run("paper", "block8", until=60, **saving).dataset
    xarray.testing.assert_equal(resumed, sw.run("paper", "block8", until=60, **kept).dataset)
    assert resumed["time"].size > 20
    with pytest.raises(sw.SceneError, match=r"keeps one in \d samples.* from t = .*; this run asks for one in 5 samples"):
        sw.run("paper", "block8", until=90, **saving | {"every": 5, "rate": None})


@pytest.mark.parametrize("name", gallery_names())
def test_show_prints_a_scene_that_is_read_as_the_same(name, tmp_path, printed):
    text = printed("show", name)
    assert set(tomllib.loads(text)) >= {"name", "interface", "drive", "start", "run"}
    (tmp_path / "mine.toml").write_text(text)
    mine, own = sw.read(tmp_path / "mine.toml"), sw.read(name)
    assert (mine, mine.digest, mine.name) == (own, own.digest, name)


def test_an_orbit_is_one_period_with_its_multipliers(tmp_path, again, refused):
    result = sw.orbit("paper", "kelvin-voigt", tol=1e-6, **{"drive.velocity": 2000})
    data, facts = result.dataset, result.summary
    time, stress = data["time"].values, data["interface_stress"].values
    assert (np.diff(time) > 0.0).all()
    assert (time[0], time[-1]) == (pytest.approx(0.0, abs=0.05), pytest.approx(facts["period"], rel=1e-12))
    assert np.ptp(stress) == pytest.approx(facts["stress_drop"], rel=1e-3)
    assert np.log(data["interface_slip_rate"].values.max()) == pytest.approx(np.log(facts["v_max"]), abs=1e-2)
    pairs = np.stack([data["multiplier_real"], data["multiplier_imaginary"]], axis=1)
    assert pairs.tolist() == facts["multipliers"]
    assert float(data["period_error"]) == facts["error_estimate"]["period"]
    result.to_netcdf(tmp_path / "orbit.nc")
    assert again("orbit", str(tmp_path / "orbit.nc")) == {key: value for key, value in facts.items() if key != "wall_s"}
    assert "is a result of slipwave orbit, not of slipwave run" in refused("run", str(tmp_path / "orbit.nc"))


def test_an_orbit_of_the_delay_system_ends_with_its_period_and_its_errors_have_units():
    """Before, its last transit was whole, 0.01 to 0.5 transits beyond the period, and errors in transits and V* had no unit."""
    data = sw.orbit("paper-si", "delay", tol=1e-6, **SHORT).dataset
    time, rate, psi = (data[name].values for name in ("time", "interface_slip_rate", "interface_psi"))
    assert (time[-1], time[-2] < time[-1]) == (float(data["period"]), True)
    assert (rate[-1], psi[-1]) == pytest.approx((rate[0], psi[0]), rel=1e-2)  # the first sample is not quite at 0
    assert np.trapezoid(rate, time) / (time[-1] - time[0]) == pytest.approx(2000.0, rel=1e-3)
    told = [data[f"{name}_error"].attrs["in_units_of"] for name in ("period", "stress_drop", "v_max")]
    assert told == ["transit", "normal stress", "V*"]
    for twin, size in {"period_error_s": float(data.attrs["transit_s"]), "v_max_error_m_per_s": 1e-6}.items():
        plain = data[twin.partition("_error")[0] + "_error"]
        assert (float(data[twin]), plain.attrs["si_factor"]) == pytest.approx((size * float(plain), size), rel=1e-12)


def test_a_file_has_the_numbers_of_every_slab():
    """Those of the scenes unlike and paper-si: one transit is 2 thickness/c, L/V* = 0.9 s."""
    facts = provenance("run", sw.read("unlike"), "delay", {})
    wanted = {"epsilon_upper": 2.8e-5, "epsilon_lower": 8.4e-5, "r_upper": 0.00244, "r_lower": 0.00488, "V": 100.0}
    numbers = {name: facts[name] for name in facts if name.partition("_")[0] in ("epsilon", "r", "V", "transit")}
    assert numbers == wanted | {"transit_in_friction_time": 0.00244}
    facts = provenance("run", sw.read("paper-si"), "delay", {})
    transit = 2.0 * 0.03357797353158276 / (1e6 / 784.0) ** 0.5
    wanted = {"V": 100.0, "transit_s": transit, "r": transit / 0.9, "transit_in_friction_time": transit / 0.9}
    wanted |= {"memory_length_m": 0.9e-6, "reference_velocity_m_per_s": 1e-6, "normal_stress_Pa": 1e3}
    wanted["epsilon"] = (784.0 * 1e6) ** 0.5 * 1e-6 / 1e3
    assert {name: facts[name] for name in wanted} == pytest.approx(wanted, rel=1e-12)


LAW = ROOT / "examples" / "own_law.py"


def test_a_law_by_file_is_recorded_and_asked_for(tmp_path, again, refused, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ("--model", "block8", "--set", "interface.law=cutoff", "interface.cutoff=1e-4", "--until", "20")
    LAWS.pop("cutoff", None)
    refused("run", "paper", *words)
    first = again("run", "paper", *words, "--law", str(LAW), "--out", "run.nc")
    assert again("run", "run.nc", "--law", str(LAW)) == first
    assert again("run", "paper", "--model", "block8", "--until", "20")["final"] != first["final"]
    Path("other.py").write_text(LAW.read_text().replace("cutoff: float = 1e-3", "cutoff: float = 2e-3"))
    assert "was computed with another friction law 'cutoff': digest" in refused("run", "run.nc", "--law", "other.py")
    LAWS.pop("cutoff")
    assert "needs the friction law 'cutoff' of the file own_law.py" in refused("run", "run.nc")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("x = 1.py", "registers no friction law"),
        ("1 % 0.py", "ZeroDivisionError"),
        ("none", "no such file"),
        ("x = 1.txt", "must be a Python file"),
    ],
)
def test_a_file_without_a_law_is_refused(name, told, tmp_path, refused):
    path = tmp_path / name
    if path.suffix:
        path.write_text(path.stem)
    assert told in refused("run", "paper", "--law", str(path))
    assert path.resolve() not in LAW_FILES  # else every process of a later sweep would refuse it once more


@pytest.mark.parametrize("content", [b"", b"no netCDF"])
def test_a_file_that_holds_no_scene_is_refused(content, tmp_path):
    (tmp_path / "x.nc").write_bytes(content)
    with pytest.raises(sw.SceneError, match=r"SCENE = .*x\.nc': holds no scene that can be computed again"):
        sw.run(tmp_path / "x.nc")
    with pytest.raises(sw.SceneError, match="no such file"):
        sw.run(tmp_path / "y.nc")


@pytest.mark.parametrize("value", [None, 3, "", "garbage", "3"])
def test_a_file_with_a_damaged_attribute_is_refused_in_one_line(tmp_path, refused, value):
    """A model is a word, so that only its absence can be told; any word is a model's or a command's name that is unknown."""
    import netCDF4

    path = tmp_path / "x.nc"
    sw.run("paper", "block8", until=2).to_netcdf(path)
    for name in ("command", "model", "scene_toml", "options"):
        damaged = tmp_path / f"{name}.nc"
        damaged.write_bytes(path.read_bytes())
        with netCDF4.Dataset(damaged, "a") as file:
            file.delncattr(name) if value is None else file.setncattr(name, value)
        err = refused("run", str(damaged), "--until", "2")
        if value in (None, 3):
            assert (
                f"holds no scene that can be computed again: its attribute {name} is {'no text' if value else 'missing'}" in err
            )


SCENE = {
    "slab.thickness": "10 m",
    "drive.velocity": [["0 s", "1 um/s"], ["40 s", "1 um/s"], ["40 s", "3 um/s"], ["90 s", "3 um/s"], ["90 s", "0 um/s"]],
    "run.until": "100 s",
    "slab.shear_modulus": "150 GPa",
}
"""A stiff block whose transits are long, so that few have to be computed."""


@pytest.mark.parametrize(("name", "options"), [("paper", []), ("paper-si", ["--set", "drive.velocity=2000"])])
def test_slip_events_as_csv(name, options, tmp_path):
    path = tmp_path / "events.csv"
    assert main(["run", name, "--until", "1500", *options, "--events", str(path), "--json"]) == 0
    heading, *rows = csv.reader(path.read_text(encoding="utf-8").splitlines())
    scene = slipwave.read(name, options[1:])
    events, units = slipwave.run(scene, until=1500).done.events, scene.units
    sizes = (scene.transit * units.time, units.normal_stress, units.reference_velocity) if units else (1.0, 1.0, 1.0)
    names = ("s", "Pa", "m/s") if units else ("transits", "normal stress", "V*")
    columns = {"time": 0, "period": 0, "stress_drop": 1, "elastic_stress_drop": 1, "v_max": 2, "v_min": 2}
    assert heading == [f"{column} [{names[k]}]" for column, k in columns.items()]
    assert len(rows) == len(events.time) > 1
    first = [values[0] * sizes[k] for values, k in zip(events, columns.values(), strict=True)]
    assert [float(word) for word in rows[0]] == pytest.approx(first, rel=1e-14)


def test_the_figure_is_friction_against_time_and_slip():
    with closing(slipwave.run("velocity-steps", "quasidynamic", interface=True, **SCENE)) as result:
        above, below = result.plot().axes
    time, friction = above.lines[-1].get_data()
    slip, again = below.lines[-1].get_data()
    assert (float(time[-1]), float(friction[0])) == (pytest.approx(100.0, abs=0.1), pytest.approx(0.6, abs=1e-9))
    assert (again[0], again.max()) == (friction[0], friction.max())
    assert again[-1] == pytest.approx(friction[-1], abs=1e-4)
    above.figure.savefig(io.BytesIO())  # second axes take their limits when they are drawn
    for axes in (above, below):
        (pascals,) = axes.child_axes
        assert pascals.get_ylabel() == "friction stress / MPa"
        assert pascals.get_ylim() == pytest.approx([5.0 * limit for limit in axes.get_ylim()], rel=1e-12)
    assert [line.get_xdata()[0] for line in above.lines[:-2]] == pytest.approx([40.0, 90.0], abs=0.01)
    unloaded = 1e6 * 0.005 * math.log(3.0) * 5e6 / 7.5e9  # um by which the weaker interface lets the blocks unload
    slipped = 40.0 + 150.0 + unloaded
    assert [line.get_xdata()[0] for line in below.lines[:-2]] == pytest.approx([40.0, slipped], abs=0.05)  # 0.007 measured
    assert slipped < float(slip[-1]) < slipped + 20.0  # in the hold friction relaxes


def test_a_stage_shorter_than_a_step_leaves_the_others(answer, printed):
    drive = "drive.velocity=[[0, 100], [1.001, 100], [1.001, 0], [1.002, 0], [1.002, 100]]"
    words = ["run", "paper", "--set", drive, "--until", "6", "--model", "fd", "--cells", "16"]
    start, hold, slide = answer(*words)["protocol"]
    assert [stage["kind"] for stage in (start, hold, slide)] == ["start", "hold", "slide"]
    assert (hold["start"], hold["end"], hold["velocity"]) == (1.001, 1.002, 0.0)
    figures = ("steady_stress", "direct_effect", "evolution", "slip_to_recovery", "relaxation", "healing")
    assert {hold[name] for name in figures} == {None}
    assert start["steady_stress"] == pytest.approx(slipwave.read("paper").steady_stress, abs=1e-6)
    assert (slide["start"], slide["end"], slide["healing"]) == (1.002, 6.0, None)
    rows = [line.split() for line in printed(*words).split("\n\n")[1].splitlines()]
    assert (rows[2], rows[3][:3]) == (["hold", "1.001", "0", *"------"], ["slide", "1.002", "100"])
    assert " ".join(rows[4]) == "no relaxation of the hold from 1.001 transits on: no time step of the model lies within it"


@pytest.mark.parametrize("thickness", ["20 m", "40 m"])
def test_healing_is_none_before_friction_falls_from_its_peak(thickness, answer, printed):
    """Before, it was the stress at which the run ended (40 m: 0.0229), or the rise to the peak was stick-slip (20 m)."""
    words = ["run", "hold", "--model", "quasidynamic", "--set", f"slab.thickness='{thickness}'"]
    *_, slide = answer(*words)["protocol"]
    assert (slide["healing"], slide["stick_slips"]) == (None, False)
    text = printed(*words)
    assert "3 stages, 1 settled, 1 hold, 1 not settled" in text
    assert "transits on: friction has not reached its peak in it" in text


def test_a_protocol_is_not_prolonged_past_a_knot(tmp_path, refused):
    words = ["run", "paper", "--set", "drive.velocity=[[0, 100], [8, 100], [8, 120]]", "--model", "block8"]
    words += ["--checkpoint", str(tmp_path / "c.npz"), "--checkpoint-every", "3"]
    assert main([*words, "--until", "7"]) == 0
    assert "a run with 1 stages of the drive, this one has 2: a protocol is not prolonged past a knot" in refused(
        *words, "--until", "12"
    )


def test_a_protocol_whose_last_stage_is_prolonged_is_judged_as_one_that_was_not_stopped(tmp_path, answer, refused):
    words = ["run", "paper", "--set", "drive.velocity=[[0, 100], [8, 100], [8, 200]]", "--model", "kelvin-voigt"]
    words += ["--set", "slab.log10_r=-2.74", "--set", "start.size=0"]
    kept = ["--checkpoint", str(tmp_path / "c.npz"), "--checkpoint-every", "59"]
    answer(*words, *kept, "--until", "60")
    continued, whole = (answer(*words, *more, "--until", "800")["protocol"] for more in (kept, []))
    assert continued == whole
    assert whole[1]["steady_stress"] == pytest.approx(0.369 + (0.0349 - 0.0489) * math.log(200.0), abs=1e-3)
    assert not whole[1]["stick_slips"]


def test_the_last_stage_of_a_run_whose_length_was_not_given_is_judged_as_of_one_to_its_end():
    scene = {key: value for key, value in slipwave.read("paper").tables.items() if key != "run"}
    scene |= {"slab": {"epsilon": 2.8e-5, "log10_r": -2.8}, "drive": {"velocity": [[0, 100], [8, 100], [8, 200]]}}
    found = slipwave.run(scene, "kelvin-voigt").facts
    again = slipwave.run(scene, "kelvin-voigt", until=found["until"]).facts
    assert found["ended"] == "settled"
    last, given = found["protocol"][-1], again["protocol"][-1]
    assert (last["end"], last["stick_slips"]) == (found["until"], False)
    assert [last["steady_stress"], last["slip_to_recovery"]] == pytest.approx(
        [given["steady_stress"], given["slip_to_recovery"]], rel=1e-4
    )
    cycles = slipwave.run(scene, "kelvin-voigt", cycles=10, slab={"log10_r": -2.5}).facts
    assert cycles["protocol"][-1]["stick_slips"]


def test_figures_of_a_curve_in_si_are_those_of_each_points_own_scene(tmp_path):
    """A transit is 2 H/c, and the normal stress is varied too; before, the factors of the first scene held for all points."""
    varied = {"over": ("slab.thickness", 0.02, 0.06), "along": ("interface.normal_stress", 900.0, 2000.0)}
    found = sw.curve("paper-si", of="HB", model="kelvin-voigt", **varied)
    found.to_netcdf(tmp_path / "hb.nc")
    with xarray.open_dataset(tmp_path / "hb.nc") as data:
        thickness, stress = data["slab_thickness"].values, data["interface_normal_stress"].values
        seconds = data["period"].values * 2.0 * thickness / math.sqrt(1e6 / 784.0)
        assert np.ptp(thickness) > 0.01
        assert data["period_s"].values == pytest.approx(seconds, rel=1e-12)
        assert data["v_max_m_per_s"].values == pytest.approx(1e-6 * data["v_max"].values, rel=1e-12)
        assert data["stress_drop_Pa"].values == pytest.approx(stress * data["stress_drop"].values)
        told = [data[name].attrs for name in ("period", "v_max", "slab_thickness", "interface_normal_stress")]
    assert [one.get("si_factor") for one in told] == [None, 1e-6, None, None]
    assert [one["units"] for one in told] == ["1", "1", "m", "Pa"]


@pytest.mark.parametrize("what", ["branch", "curve"])
def test_a_branch_and_a_curve_say_in_which_units_they_are(what, tmp_path):
    over, how = ("slab.thickness", 0.03, 0.04), {"model": "kelvin-voigt", "tol": 1e-4, "most_points": 3}
    if what == "branch":
        found = sw.branch("paper-si", over=over, **how)
        names = ("point_value", "slab_thickness", "special_value", "special_bracket")
    else:
        found = sw.curve("paper-si", of="LP", over=over, along=("interface.normal_stress", 1000.0, 1100.0), **how)
        names = ("slab_thickness", "bracket")
    assert [found.dataset[name].attrs["units"] for name in (*names, "period_s")] == ["m"] * len(names) + ["s"]
    found.to_netcdf(tmp_path / "x.nc")
    with xarray.open_dataset(tmp_path / "x.nc") as file:
        columns = ("point_value", "special_bracket") if what == "branch" else ("point_first", "point_bracket", "point_second")
        assert [file[name].attrs["units"] for name in columns] == ["m", "m", "Pa"][: len(columns)]
        told = [file[f"point_{name}"].attrs for name in ("period", "stress_drop", "v_max")]
    assert [(one["in_units_of"], one["si_units"], one["units"]) for one in told] == [
        ("transit", "s", "1"),
        ("normal stress", "Pa", "1"),
        ("V*", "m s-1", "1"),
    ]
