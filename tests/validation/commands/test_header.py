"""What a command prints first and what it notes: numbers by hand, rounding, grids that are too coarse."""

import json

import pytest

import slipwave
from slipwave.solve import follow
from validation.commands.cli import main
from validation.commands.wording import header
from validation.models.build import build
from validation.models.outlook import amplified_rounding

UNITS = {"interface.normal_stress": "5 MPa", "interface.memory_length": "10 um", "interface.reference_velocity": "1 um/s"}
SLAB = {"density": "2.7 g/cm3", "shear_modulus": "30 GPa", "thickness": "10 m"}
GRANITE = UNITS | {f"slab.{key}": value for key, value in SLAB.items()} | {"drive.velocity": "1 um/s"}


@pytest.mark.parametrize(
    ("name", "changes", "line", "end"),
    [
        (
            "rock",
            GRANITE | {"slab.viscosity": {"kind": "standard-linear", "time": "1 ms", "ratio": 0.5}},
            "slabs: standard-linear: time 0.0001, ratio 0.5 (0.001 s)",
            "",
        ),
        (
            "rock",
            GRANITE | {"slab.face": {"kind": "machine", "stiffness": "3 GPa/m", "impedance": "9 MPa s/m", "mass": "27 t/m2"}},
            "slabs: machine: stiffness 2, impedance 1, mass 0.5 (3e+09 Pa/m, 9e+06 Pa s/m, 27000 kg/m2)",
            ", R = 1 for fast waves",
        ),
        (
            "rock",
            GRANITE | {"slab.face": {"kind": "grip", "stiffness": 2.0, "impedance": 0.5}},
            "slabs: grip: stiffness 2, impedance 0.5 ",
            ", R = -0.3333 for fast waves",
        ),
        (
            "unlike",
            {"upper.face": {"kind": "grip", "stiffness": 2.0, "impedance": 0.0}},
            "upper: grip: stiffness 2, impedance 0",
            ", R = -1 for fast waves",
        ),
    ],
)
def test_faces_viscosity_and_layers_are_shown_with_their_values(name, changes, line, end):
    (found,) = (shown for shown in header(slipwave.read(name, changes)) if shown.startswith(line[:10]) and "epsilon" not in shown)
    assert (found[: len(line)], found[len(found) - len(end) :]) == (line, end)


@pytest.mark.parametrize("command", ["run --until 1", "stability", "compare --models quasidynamic --until 1"])
def test_a_doubt_is_a_note_on_stderr_and_in_the_json(command, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, *options = command.split()
    words = [name, "paper-si", *options, "--set", "slab.shear_modulus=30", "--set", "slab.density=30 g/cm3", "--json"]
    assert main(words) == 0
    printed = capsys.readouterr()
    told = [line for line in json.loads(printed.out)["notes"] if line.startswith("slab.")]
    assert [line.partition(" (")[0] for line in told] == ["slab.density = 3e+04 kg/m3", "slab.shear_modulus = 30 Pa"]
    assert [line for line in printed.err.splitlines() if line.startswith("note: slab.")] == [f"note: {one}" for one in told]


STIFF = ["interface.a=0.0296", "interface.b=0.0591", "drive.velocity=80", "slab.epsilon=7.2e-5", "slab.r=0.0124"]
"""Thirty-two cells of sbp:6 end at ln v = -6.27 after 60 transits where the delay system has -5.31."""


def parted(r, model, at):
    """Relative difference, at `at` transits, of two departures from steady sliding whose psi(0) differ by one rounding."""
    scene = slipwave.read("paper", [f"slab.r={r}"])
    left = []
    for rounding in (0.0, 2.0**-52):
        solver = build(model, scene, tolerance=1e-11)
        state = solver.state()
        state["now"][1] *= 1.0 + rounding
        solver.restore(state)
        left.append(follow(solver, at).psi - scene.steady_psi)
    return abs(left[1] - left[0]) / max(map(abs, left))


@pytest.mark.parametrize("model", ["delay", "kelvin-voigt"])
@pytest.mark.parametrize(("r", "at"), [(0.1, 5.0), (0.2, 4.0), (0.3, 2.5), (0.5, 1.5)])
def test_the_share_of_rounding_is_what_two_runs_differ_by(model, r, at):
    found = amplified_rounding(slipwave.read("paper", [f"slab.r={r}"]), model, 40.0)
    assert found is not None
    ratio = parted(r, model, at) / min(found.share, 1.0)
    assert 1.0 / 30.0 < ratio < 10.0


def test_a_scene_that_is_determined_says_nothing():
    for name in ("paper", "paper-2.3", "rock", "unlike", "ramp", "jump", "grip", "slip-law"):
        assert amplified_rounding(slipwave.read(name), "delay", 4000.0) is None
    jump = ['start.kind="jump"', "start.size=0.1", "slab.r=1"]
    assert amplified_rounding(slipwave.read("paper", jump), "delay", 40.0) is None
    assert amplified_rounding(slipwave.read("paper", ["slab.r=0.5"]), "delay", 0.3) is None  # rounding has not grown yet


def test_a_run_that_rounding_decides_says_so():
    """`printed.txt` has a run in which its share is small."""
    (note,) = slipwave.run("paper", "quasidynamic", until=10, r=0.5).notes
    assert note.startswith("not determined: steady sliding is unstable, disturbances grow at 17.1 per transit")
    assert 10.0 < float(note.split("outgrows the start ")[1].split(" times")[0]) < 500.0
    assert slipwave.run("paper", until=10).notes == []


@pytest.mark.parametrize("model", ["sbp:6", "dg:7"])
def test_a_default_grid_that_is_too_coarse_says_so(model):
    result = slipwave.run("paper", model, until=60, settings=STIFF).summary
    exact = follow(build("delay", slipwave.read("paper", STIFF), tolerance=1e-10), 60.0)
    error = max(abs(result["final"][name] / getattr(exact, name) - 1.0) for name in ("ln_v", "psi"))
    cells, estimate = result["grid"]["cells"], result["grid"]["error_estimate"]
    assert error < 2.0 * estimate < 30.0 * error
    assert f"the default grid of {cells} cells is too coarse for this scene: estimated error {estimate:.1e}" in result["notes"][0]


@pytest.mark.parametrize(
    ("model", "jump", "options", "told"),
    [
        ("fd", 1.0, {"cells": 8}, []),
        ("fd", 1.01, {"cells": 8}, ["steps"]),
        ("dg:3", 1.01, {"cells": 2, "time": "explicit"}, ["steps"]),  # late steps cost as the front
        ("dg:3", 1.01, {"cells": 2}, ["no"]),
        ("dg:3", 0.0, {"cells": 2}, []),
        ("delay", 1.01, {}, []),
        ("block8", 1.01, {}, []),
    ],
)
def test_what_a_step_of_the_drive_costs_is_told(model, jump, options, told):
    """How much it is: tests/verification/test_velocity_steps.py."""
    drive = [[0.0, 100.0], [jump, 100.0], [jump, 120.0]] if jump else [[0.0, 100.0], [1.0, 120.0]]
    found = slipwave.run("paper", model, until=2, **options, **{"drive.velocity": drive})
    lines = {"steps": "steps of V are placed to within one time step (", "no": "no grid resolves the front of a step of V: "}
    assert [word for word, line in lines.items() for note in found.notes if note.startswith(line)] == told
