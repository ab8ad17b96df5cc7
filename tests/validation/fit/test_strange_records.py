"""Records as strangers write them, made by an integrator of its own, and fits that are killed and go on."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipwave as sw
from slipwave.errors import NumericsError, SceneError
from slipwave.input.assemble import to_toml
from tests.copies import killed
from tests.validation.records import assert_held, written
from validation.commands.cli import main
from validation.data.record_events import slip_events
from validation.data.series import read_series
from validation.fit.least_squares import BestValues
from validation.fit.records import experiment_of, followed

TRUTH = {"interface.a": 0.01, "interface.b": 0.015, "interface.memory_length": 1e-5}
FREE = ["a", "b", "memory_length"]
SAMPLE = {
    "name": "sample",
    "interface": {"law": "ageing", "a_star": 0.6, "a": 0.006, "b": 0.009}
    | {"normal_stress": "5 MPa", "memory_length": "50 um", "reference_velocity": "1 um/s"},
    "slab": {"density": 2700, "shear_modulus": "30 GPa", "thickness": "5 cm"}
    | {"face": {"kind": "grip", "stiffness": "42.857142857 GPa/m", "impedance": 0.0}},
    "drive": {"velocity": "1 um/s"},
}
SPRING = 2e10  # Pa/m, of that sample


def slider(times, steps, spring=SPRING, off=0.0):
    """Friction of a spring-slider with radiation damping under the ageing law, by LSODA: velocity (m/s) from each time on; at the
    start, psi is `off` its steady value."""
    (a, b, length), stress, damping = TRUTH.values(), 5e6, 4.5e6
    y, found = np.array([np.log(steps[0][1] / 1e-6), off - np.log(steps[0][1] / 1e-6)]), np.empty(times.size)
    ends = [*(begin for begin, _ in steps[1:]), times[-1]]
    for (begin, pace), end in zip(steps, ends, strict=True):

        def rates(_, y, pace=pace):
            rate = 1e-6 * np.exp(y[0])
            ageing = (1e-6 * np.exp(-y[1]) - rate) / length
            return [(spring * (pace - rate) - stress * b * ageing) / (stress * a + damping * rate), ageing]

        here = (times >= begin) & (times <= end)
        moments = np.unique(np.append(times[here], end))
        made = solve_ivp(rates, (begin, end), y, "LSODA", moments, rtol=1e-9, atol=1e-10)
        found[here], y = (0.6 + a * made.y[0] + b * made.y[1])[: here.sum()], made.y[:, -1]
    return found


def travelled(times, steps):
    begins, paces = np.array(steps).T
    ends = np.append(begins[1:], np.inf)
    return np.sum([v * (np.clip(times, a, b) - a) for a, b, v in zip(begins, ends, paces, strict=True)], axis=0)


STEPS = [(0.0, 1e-6), (20.0, 1e-5), (45.0, 1e-6)]


def test_sixty_samples_say_where_the_load_point_turned_between_two_of_them(tmp_path):
    times = np.linspace(0.0, 80.0, 60)
    noise = 2e-4 * np.random.default_rng(5).standard_normal(60)
    path = written(
        tmp_path / "few.csv", "seconds,cof,load_point_um", times, slider(times, STEPS) + noise, 1e6 * travelled(times, STEPS)
    )
    found = sw.fit(SAMPLE, data=[path], free=FREE)
    assert_held(found, TRUTH, 0.1)
    assert any("3 velocities, 1e-06, 1e-05, 1e-06" in note for note in found.notes)


def test_a_load_point_in_whole_steps_of_its_gauge_and_its_velocity_give_the_same_drive(tmp_path):
    times, rng = np.arange(0.05, 100.0, 0.1), np.random.default_rng(6)
    friction = np.round(slider(times, STEPS) + 2e-4 * rng.standard_normal(times.size), 4)
    gauge = written(
        tmp_path / "gauge.csv", "time_s,friction,displacement_um", times, friction, np.round(1e6 * travelled(times, STEPS), 1)
    )
    pace = np.select([times < 20.0, times < 45.0], [1.0, 10.0], 1.0)
    rate = written(tmp_path / "rate.csv", "t [s],mu,Load velocity (um/s)", times, friction, pace)
    for path in (gauge, rate):
        found = sw.fit(SAMPLE, data=[path], free=FREE)
        assert_held(found, TRUTH, 0.1)
        assert any("3 velocities" in note for note in found.notes)


def test_a_window_leaves_out_what_the_model_does_not_say(tmp_path):
    steps = [(0.0, 1e-6), (80.0, 1e-5), (140.0, 1e-6)]
    times = np.arange(0.0, 200.0, 0.1)
    friction = np.minimum(slider(times, steps), 0.02 * times**1.2) + 3e-4 * np.random.default_rng(7).standard_normal(times.size)
    path = written(
        tmp_path / "run-in.csv", "time_s,friction,displacement_um", times + 500.0, friction, 1e6 * travelled(times, steps)
    )
    found = sw.fit(SAMPLE, data=[path], free=[*FREE, "level"], window="560s:12min")
    assert_held(found, TRUTH, 0.1)
    assert found.summary["determined"]["level"]  # to 1e-5, though it is 0
    assert found.summary["data"][0]["samples"] == 1400
    for window, told in (("1:2:3", "must be BEGIN:END"), ("1kg:2s", "must be BEGIN:END"), ("9e2:", "holds 0 samples")):
        with pytest.raises(SceneError, match=told):
            sw.fit(SAMPLE, data=[path], free=FREE, window=window)


@pytest.mark.parametrize("far", [{"memory_length": "300 um"}, {"a": 0.02, "b": 0.01}, {"slab.face.stiffness": "20 GPa/m"}])
def test_stick_slip_is_fitted_from_values_that_slide_steadily(far, tmp_path):
    times = np.arange(0.0, 400.0, 0.1)
    friction = slider(times, [(0.0, 1e-5)], 1.2e9, 0.5)[500:] + 1e-3 * np.random.default_rng(8).standard_normal(3500)
    path = written(tmp_path / "stick.csv", "time [s],friction", times[500:], friction)
    start = {"slab.face.stiffness": "2.4096 GPa/m", "drive.velocity": "10 um/s", **far}
    free = [*FREE, "stiffness"] if "slab.face.stiffness" in far else FREE
    assert_held(sw.fit(SAMPLE, data=[path], free=free, settings=[f"{key}={value!r}" for key, value in start.items()]), TRUTH, 0.1)


def sticking():
    """Times and friction of stick-slip with noise."""
    times, rng = np.arange(0.0, 400.0, 0.1), np.random.default_rng(12)
    return times[500:], slider(times, [(0.0, 1e-5)], 1.2e9, 0.5)[500:] + 1e-3 * rng.standard_normal(3500)


def test_stick_slip_with_an_offset_that_drifts_gives_its_values_back(tmp_path):
    """Before, the level was that at the middle of the record, as if it were known to 1e-5."""
    times, friction = sticking()
    path = written(tmp_path / "cycles.csv", "time [s],friction", times, friction + 3e-6 * np.arange(3500))
    start = ["slab.face.stiffness='2.4096 GPa/m'", "drive.velocity='10 um/s'"]
    found = sw.fit(SAMPLE, data=[path], free=FREE, settings=start)
    assert any("its drift by 0.00" in note for note in found.notes)
    assert_held(found, TRUTH, 0.4)


def test_spikes_of_single_samples_are_no_slip_events():
    """Before, 22 events: falls from a spike to the next were more than 40 % of the range of friction."""
    times, friction = sticking()
    spikes = np.zeros(3500)
    spikes[600:3400:300], spikes[660:3400:300] = 0.03, -0.03
    clean, found = slip_events(times, friction).date, slip_events(times, friction + spikes).date
    assert clean.size == 12
    np.testing.assert_allclose(found, clean, atol=0.1)  # a sample


@pytest.mark.parametrize(
    ("moved", "told"),
    [
        (np.full(40, 5.0), "the load point does not move"),
        (np.maximum(np.arange(40.0) - 10.0, 0.0), "the load point begins at rest"),
        (20.0 - np.abs(np.arange(40.0) - 25.0), "the load point turns back"),
        (np.arange(4.0), "has 4 samples: a fit needs 8"),
    ],
)
def test_a_load_point_that_no_model_follows_is_refused_in_one_line(moved, told, tmp_path):
    times = np.arange(float(moved.size))
    path = written(tmp_path / "odd.csv", "time_s,friction,displacement_um", times, 0.6 + 0.001 * np.sin(times), moved)
    with pytest.raises(SceneError, match=told):
        sw.fit(SAMPLE, data=[path], free=FREE)


def test_a_ramp_before_steps_is_followed_by_some_steps(tmp_path):
    ramp = [(20.0 + 0.5 * k, 1e-6 * (1.0 + 0.2 * k)) for k in range(1, 21)]  # to 5 um/s in 10 s
    times, steps = np.arange(0.0, 110.0, 0.2), [(0.0, 1e-6), *ramp, (50.0, 1e-5), (75.0, 1e-6)]
    rng = np.random.default_rng(11)
    friction = slider(times, steps) + 5e-4 * rng.standard_normal(times.size)
    moved = 1e6 * travelled(times, steps) + 0.02 * rng.standard_normal(times.size)
    path = written(tmp_path / "ramp.csv", "seconds,cof,x_lp [um]", times, friction, moved)
    assert_held(sw.fit(SAMPLE, data=[path], free=FREE), TRUTH, 0.1)


@pytest.mark.parametrize(("decimals", "offset"), [(2, 0.0), (3, 4200.0), (6, -500.0)])
def test_holds_between_few_samples_are_found_whatever_the_decimals(decimals, offset):
    steps, parts, begin = [(0.0, 1e-5)], [np.arange(0.0, 20.0, 0.5)], 20.0
    for hold in (3.0, 30.0, 300.0, 3000.0):
        steps += [(begin, 0.0), (begin + hold, 1e-5)]
        parts += [begin + np.geomspace(0.05, hold, 60), begin + hold + np.linspace(0.05, 20.0, 200)]
        begin += hold + 20.0
    times = np.concatenate(parts)
    found = followed(times, 1e-6 * np.round(1e6 * travelled(times, steps) + offset, decimals))
    assert found.velocities[1:-1:2] == pytest.approx([v for _, v in steps][:-1], rel=1e-3)
    assert found.times[1:-1:2] == pytest.approx([t for t, _ in steps][1:], abs=2e-3)


def test_a_clock_that_begins_after_the_scene_s_steps_counts_from_the_first_sample(tmp_path):
    times = np.linspace(0.0, 80.0, 200)
    path = written(tmp_path / "late.csv", "elapsed time [s],friction", times + 81234.5, slider(times, STEPS))
    steps = [["0 s", "1 um/s"], ["20 s", "1 um/s"], ["20 s", "10 um/s"], ["45 s", "10 um/s"], ["45 s", "1 um/s"]]
    scene = SAMPLE | {"drive": {"velocity": steps}}
    assert experiment_of(read_series(path), sw.read_scene(scene)).times[[0, -1]] == pytest.approx([0.0, 80.0])
    found = sw.fit(scene, data=[path], free=FREE)
    assert [row["value"] for row in found.parameters.values()] == pytest.approx([*TRUTH.values()], rel=1e-3)
    assert any("clock begins at 81234.5" in note for note in found.notes)


def test_a_mass_that_a_model_leaves_out_is_said_to_be_undetermined(tmp_path):
    times = np.linspace(0.0, 80.0, 60)
    path = written(tmp_path / "few.csv", "seconds,cof,x_lp [um]", times, slider(times, STEPS), 1e6 * travelled(times, STEPS))
    scene = SAMPLE | {
        "slab": SAMPLE["slab"] | {"face": {"kind": "machine", "stiffness": 42.857142857e9, "impedance": 0, "mass": 50}}
    }
    with pytest.raises(NumericsError, match=r"the data do not determine slab\.face\.mass$") as error:
        sw.fit(scene, "quasidynamic", data=[path], free=["a", "slab.face.mass"], settings=["b=0.015", "memory_length='10 um'"])
    assert error.value.result.notes.count("not determined: slab.face.mass") == 1
    assert error.value.result.notes[0] == "model quasidynamic leaves out the mass on the outer face and waves that return"
    found = sw.fit(scene, data=[path], free=["a"], settings=["b=0.015", "memory_length='10 um'"])
    assert (found.model, found.notes[0]) == ("fitted:0", "model fitted:0 leaves out waves that return")


def test_a_fit_that_is_killed_goes_on_and_refuses_other_data(tmp_path, capsys):
    times = np.linspace(0.0, 80.0, 300)
    friction = slider(times, STEPS) + 2e-4 * np.random.default_rng(9).standard_normal(300)
    path = written(tmp_path / "steps.csv", "seconds,cof,load_point_um", times, friction, 1e6 * travelled(times, STEPS))
    scene, kept = tmp_path / "sample.toml", tmp_path / "kept.json"
    scene.write_text(to_toml(sw.read_scene(SAMPLE)), encoding="utf-8")
    whole = sw.fit(SAMPLE, data=[path], free=FREE)
    at = int(np.random.default_rng(10).integers(3, whole.summary["evaluations"]))
    words = ["fit", str(scene), "--data", path, "--free", ",".join(FREE), "--checkpoint", str(kept)]
    killed(words, BestValues, "see", at + 1)
    done = json.loads(kept.read_text())
    assert 1 <= done["evaluations"] <= at
    assert main([*words, "--json"]) == 0
    after = json.loads(capsys.readouterr().out)
    assert done["evaluations"] < after["evaluations"]
    for key, row in whole.summary["parameters"].items():
        assert after["parameters"][key]["value"] == pytest.approx(row["value"], rel=1e-6)
    assert main([*words, "--window", "0:70"]) == 2
    assert "belongs to another fit (window: None, now '0:70')" in capsys.readouterr().err
    written(Path(path), "seconds,cof,load_point_um", times, friction + 1e-3, 1e6 * travelled(times, STEPS))
    assert main(words) == 2
    assert "belongs to another fit (contents of" in capsys.readouterr().err
    kept.write_text("{", encoding="utf-8")
    assert main(words) == 2
    assert "is no checkpoint of a fit" in capsys.readouterr().err


def test_a_checkpoint_is_refused_if_the_fourth_free_parameter_is_another(tmp_path):
    """The three before are alike, and so are the numbers of parameters."""
    times = np.linspace(0.0, 80.0, 100)
    friction = slider(times, STEPS)
    path = written(tmp_path / "steps.csv", "seconds,cof,load_point_um", times, friction, 1e6 * travelled(times, STEPS))
    call = {"data": [path], "checkpoint": tmp_path / "kept.json"}
    sw.fit(SAMPLE, free=[*FREE, "a_star"], **call)
    with pytest.raises(SceneError, match=r"belongs to another fit \(free: \[.*'a_star'\], now \[.*'level'\]\)"):
        sw.fit(SAMPLE, free=[*FREE, "level"], **call)


def test_friction_that_does_not_change_says_nothing(tmp_path):
    """Before, a and b were 2.5e-6 and L 4.8 nm, with intervals of 3e-4 %, and the exit status 0."""
    times = np.linspace(0.0, 240.0, 400)
    written(tmp_path / "flat.csv", "time [s],friction", times, np.full(times.size, 0.6))
    with pytest.raises(SceneError, match="friction does not change"):
        sw.fit("velocity-steps", data=[tmp_path / "flat.csv"], free=FREE)


def test_a_record_that_says_nothing_of_a_parameter_ends_in_one_line(tmp_path):
    """Before the first step no friction depends on a and b; a record may be given as a path."""
    record = tmp_path / "rest.csv"
    record.write_text("time [s],friction\n" + "".join(f"{0.004 * k},{0.61 + 1e-4 * (k % 2)}\n" for k in range(50)))
    with pytest.raises(NumericsError, match=r"the data do not determine interface\.a and interface\.b") as found:
        sw.fit("velocity-steps", data=record, free="a,b")
    assert found.value.result.data == [{"file": str(record), "samples": 50}]
