"""Stages of a protocol and slip events as users get them: JSON, SI, CSV, and after a resumed run."""

import csv
import io
import math
from contextlib import closing

import numpy as np
import pytest
import xarray

import slipwave
from slipwave.observe.stages import StageFigures
from validation.cli import main
from validation.results.stage_table import stage_rows

SCENE = {
    "slab.thickness": "10 m",
    "drive.velocity": [["0 s", "1 um/s"], ["40 s", "1 um/s"], ["40 s", "3 um/s"], ["90 s", "3 um/s"], ["90 s", "0 um/s"]],
    "run.until": "100 s",
    "slab.shear_modulus": "150 GPa",
}
"""A stiff block whose transits are long, so that few have to be computed."""


def protocol(**options):
    result = slipwave.run("velocity-steps", "quasidynamic", **options, **SCENE)
    found = result.summary["protocol"]
    return found


def test_the_json_has_every_stage_with_si():
    start, step, hold = protocol()
    assert [stage["kind"] for stage in (start, step, hold)] == ["start", "step", "hold"]
    si = step["si"]
    assert (si["start_s"], si["end_s"]) == (pytest.approx(40.0, rel=1e-12), pytest.approx(90.0, rel=1e-12))
    assert si["velocity_m_per_s"] == pytest.approx(3e-6, rel=1e-12)
    for name in ("direct_effect", "evolution", "steady_stress"):
        assert si[f"{name}_Pa"] == pytest.approx(step[name] * 5e6, rel=1e-12)
    assert si["slip_to_recovery_m"] == pytest.approx(step["slip_to_recovery"] * 1e-5, rel=1e-12)
    assert (si["healing_Pa"], step["healing"]) == (None, None)
    assert hold["si"]["relaxation_Pa"] > 0.0


def test_a_file_has_the_stages_of_the_json(tmp_path):
    path = tmp_path / "steps.nc"
    result = slipwave.run("velocity-steps", "quasidynamic", **SCENE)
    result.to_netcdf(path)
    stages = result.summary["protocol"]
    with xarray.open_dataset(path) as data:
        assert (data.attrs["ended"], data.attrs["reasons"]) == ("until", "; ".join(result.reasons))
        assert data["stage_kind"].values.tolist() == ["start", "step", "hold"]
        assert data["stage_stick_slips"].values.tolist() == [0, 0, 0]
        sizes = {"direct_effect": "Pa", "evolution": "Pa", "relaxation": "Pa", "slip_to_recovery": "m", "start": "s", "end": "s"}
        for name, unit in sizes.items():
            plain, twin = (
                [math.nan if one is None else one for one in column]
                for column in ([stage[name] for stage in stages], [stage["si"][f"{name}_{unit}"] for stage in stages])
            )
            np.testing.assert_array_equal(data[f"stage_{name}"], plain)
            np.testing.assert_allclose(data[f"stage_{name}_{unit}"], twin, rtol=1e-15)
        assert data["stage_velocity_m_per_s"].values.tolist() == pytest.approx([1e-6, 3e-6, 0.0], rel=1e-14)


@pytest.mark.parametrize(("name", "options"), [("paper", []), ("paper-si", ["--set", "drive.velocity=2000"])])
def test_slip_events_as_csv(name, options, tmp_path):
    path = tmp_path / "events.csv"
    assert main(["run", name, "--until", "1500", *options, "--events", str(path), "--json"]) == 0
    rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
    scene = slipwave.read(name, options[1:])
    events = slipwave.run(scene, until=1500).done.events
    units = scene.units
    second, pascal, rate = (
        (scene.transit * units.time, units.normal_stress, units.reference_velocity) if units else (1.0, 1.0, 1.0)
    )
    clock, stress, speed = ("s", "Pa", "m/s") if units else ("transits", "normal stress", "V*")
    assert rows[0] == [
        f"time [{clock}]",
        f"period [{clock}]",
        f"stress_drop [{stress}]",
        f"elastic_stress_drop [{stress}]",
        f"v_max [{speed}]",
        f"v_min [{speed}]",
    ]
    assert len(rows) == len(events.time) + 1 > 2
    first = [float(word) for word in rows[1]]
    sizes = (second, second, pascal, pascal, rate, rate)
    assert first == pytest.approx([values[0] * size for values, size in zip(events, sizes, strict=True)], rel=1e-14)


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


@pytest.mark.parametrize("name", ["paper", "paper-si"])
def test_every_column_of_the_table_has_the_figure_that_its_heading_names(name):
    scene = slipwave.read(name)
    units = scene.units
    second, metre, rate = (scene.transit * 0.9, 0.9e-6, 1e-6) if units else (1.0, 1.0, 1.0)
    clock, length, speed = ("s", "m", "m/s") if units else ("transits", "L", "V*")
    stage = StageFigures("step", 10.0, 20.0, 3.0, 0.61, 0.012, 0.017, 1.3, 0.021, 0.026)
    heading, rows = stage_rows([stage], scene)
    told = dict(zip(heading[1:], map(float, rows[0][1:]), strict=True))
    assert (heading[0], rows[0][0]) == ("stage", "step")
    assert told == pytest.approx(
        {
            f"from [{clock}]": 10.0 * second,
            f"V [{speed}]": 3.0 * rate,
            "steady": 0.61,
            "direct": 0.012,
            "evolution": 0.017,
            f"slip to 1/e [{length}]": 1.3 * metre,
            "relaxation": 0.021,
            "healing": 0.026,
        },
        rel=1e-5,
    )


def test_a_figure_that_is_missing_has_a_reason(printed):
    """V changes to 90 at t = 10 and the sample is not steady when a hold begins at t = 30."""
    drive = "drive.velocity=[[0, 100], [10, 100], [10, 90], [30, 90], [30, 0], [40, 0], [40, 100]]"
    assert printed("run", "paper", "--set", drive, "--until", "60").split("\n\n")[1].splitlines()[-2:] == [
        "no relaxation of the hold from 30 transits on: the step before it is not settled, so there is no steady stress to "
        "compare with",
        "no healing of the slide from 40 transits on: its hold has no relaxation",
    ]


def test_a_stage_shorter_than_a_step_leaves_the_others(answer, printed):
    """Steps of the grid are longer than the hold from 1.001 to 1.002."""
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


def test_a_protocol_is_not_prolonged_past_a_knot(tmp_path, refused):
    words = ["run", "paper", "--set", "drive.velocity=[[0, 100], [8, 100], [8, 120]]", "--model", "block8"]
    words += ["--checkpoint", str(tmp_path / "c.npz"), "--checkpoint-every", "3"]
    assert main([*words, "--until", "7"]) == 0
    assert "a run with 1 stages of the drive, this one has 2: a protocol is not prolonged past a knot" in refused(
        *words, "--until", "12"
    )
