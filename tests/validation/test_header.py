"""What a command prints first, in numbers that follow from the scene by hand; doubts reach stderr, the page and the JSON."""

import json
import math

import pytest

import slipwave
from validation.cli import main
from validation.results.wording import header

UNITS = {"interface.normal_stress": "5 MPa", "interface.memory_length": "10 um", "interface.reference_velocity": "1 um/s"}
GRANITE = UNITS | {
    "slab.density": "2.7 g/cm3",
    "slab.shear_modulus": "30 GPa",
    "slab.thickness": "10 m",
    "drive.velocity": "1 um/s",
}


def test_a_scene_in_si_has_thickness_wave_speed_impedance_and_one_transit():
    lines = header(slipwave.read("rock", GRANITE))
    speed = math.sqrt(3e10 / 2700)
    assert lines[2:] == [
        f"slabs: thickness 10 m, wave speed {speed:.6g} m/s, impedance {2700 * speed:.6g} Pa s/m",
        "units: L = 1e-05 m, V* = 1e-06 m/s, sigma = 5e+06 Pa",
        f"one transit = {20 / speed:.6g} s; V = 1e-06 m/s; stiffness of slabs and faces in series {3e10 / 20:.6g} Pa/m",
    ]


def test_unlike_slabs_in_si_have_a_round_trip_each():
    upper = {key.partition(".")[2]: value for key, value in GRANITE.items() if key.startswith("slab.")}
    tables = {key: value for key, value in (slipwave.read("rock", GRANITE).tables or {}).items() if key != "slab"}
    scene = slipwave.read({**tables, "upper": upper, "lower": upper | {"thickness": "5 m"}})
    speed = math.sqrt(3e10 / 2700)
    ends = [line.rpartition(", ")[2] for line in header(scene) if "thickness" in line]
    assert ends == [f"round trip {20 / speed:.6g} s", f"round trip {10 / speed:.6g} s"]


@pytest.mark.parametrize(
    ("name", "changes", "line"),
    [
        ("grip", {}, "slabs: grip: stiffness 10, impedance 3"),
        ("machine", {}, "slabs: machine: stiffness 10, impedance 0.5, mass 0.5"),
        ("reflection", {}, "slabs: reflection: coefficient 0.999"),
        ("viscous", {}, "slabs: kelvin-voigt: time 2e-05"),
        ("layered", {}, "slabs: layers from the interface outwards: 0.5 of impedance 1, 0.5 of impedance 2"),
        (
            "rock",
            GRANITE | {"slab.viscosity": {"kind": "standard-linear", "time": "1 ms", "ratio": 0.5}},
            "slabs: standard-linear: time 0.0001, ratio 0.5 (0.001 s)",
        ),
        (
            "rock",
            GRANITE | {"slab.face": {"kind": "machine", "stiffness": "3 GPa/m", "impedance": "9 MPa s/m", "mass": "27 t/m2"}},
            "slabs: machine: stiffness 2, impedance 1, mass 0.5 (3e+09 Pa/m, 9e+06 Pa s/m, 27000 kg/m2)",
        ),
        (
            "rock",
            GRANITE | {"slab.face": {"kind": "grip", "stiffness": 2.0, "impedance": 0.5}},
            "slabs: grip: stiffness 2, impedance 0.5 ",
        ),
    ],
)
def test_faces_viscosity_and_layers_are_shown_with_their_values(name, changes, line):
    (found,) = (shown for shown in header(slipwave.read(name, changes)) if shown.startswith(line[:10]) and "epsilon" not in shown)
    assert found.startswith(line)


def test_a_drive_that_changes_says_so():
    assert ", V = 100 at first, then 3 knots up to t = 1500 transits, " in header(slipwave.read("ramp"))[0]


@pytest.mark.parametrize("command", ["run --until 1", "stability", "compare --models quasidynamic --until 1"])
def test_a_doubt_is_a_note_on_stderr_and_in_the_json(command, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(str(tmp_path))
    name, *options = command.split()
    words = [name, "paper-si", *options, "--set", "slab.shear_modulus=30", "--set", "slab.density=30 g/cm3", "--json"]
    assert main(words) == 0
    printed = capsys.readouterr()
    modulus = "slab.shear_modulus = 30 Pa (wave speed 0.0316 m/s): solids have 1 kPa to 600 GPa; did you mean 30 GPa?"
    density = "slab.density = 3e+04 kg/m3 (wave speed 0.0316 m/s): solids have 100 kg/m3 to 23 g/cm3"
    assert [line for line in json.loads(printed.out)["notes"] if line.startswith("slab.")] == [density, modulus]
    assert [line for line in printed.err.splitlines() if line.startswith("note: slab.")] == [
        f"note: {density}",
        f"note: {modulus}",
    ]
