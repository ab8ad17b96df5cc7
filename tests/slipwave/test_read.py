"""Scenes that are right are read right: gallery, files, dictionaries, overrides, SI, numbers with units; what is doubted."""

import copy
import dataclasses
import math

import pytest

import slipwave
from slipwave.errors import SceneError
from slipwave.input.assemble import gallery_names, gallery_titles
from slipwave.input.quantity import looks_measured, quantity
from slipwave.scene.drive import Drive, Start, StartKind
from slipwave.scene.scene import doubts
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, ReflectingFace, RigidFace, StandardLinearViscosity
from tests.granite import GRANITE as BARE

INTERFACE = {"law": "ageing", "a_star": 0.369, "a": 0.0349, "b": 0.0489}
PLAIN = {"interface": INTERFACE, "slab": {"epsilon": 2.8e-5, "r": 0.002}, "drive": {"velocity": 100}}


def test_every_scene_of_the_gallery_reads_and_has_a_title():
    assert {"paper", "paper-si", "paper-2.6", "paper-2.3", "rock", "yardstick"} <= set(gallery_names())
    for name, title in gallery_titles().items():
        assert slipwave.read(name).name == name
        assert 10 < len(title) < 120


def test_the_paper_scene_is_the_papers():
    paper = slipwave.read("paper")
    assert tuple(paper.law) == (0.369, 0.0349, 0.0489)
    assert (paper.upper.epsilon, paper.upper.round_trip, paper.velocity) == (2.8e-5, 10**-2.68, 100.0)
    assert paper.alike
    assert paper.upper.is_plain
    assert paper.start == Start(StartKind.NUDGE, 0.5)
    assert paper.steady_stress == pytest.approx(0.369 + (0.0349 - 0.0489) * math.log(100.0), rel=1e-14)


def test_a_sample_is_as_stiff_over_its_normal_stress_as_its_machine_says():
    units = {"normal_stress": "5 MPa", "memory_length": "10 um", "reference_velocity": "1 um/s"}
    hard, soft = ({"density": 2700, "shear_modulus": f"{modulus} GPa", "thickness": "1 cm"} for modulus in (30, 10))
    data = {
        "interface": INTERFACE | units,
        "upper": hard,
        "lower": soft,
        "drive": {"velocity": 1.0},
        "machine": {"k": "2e-3 /um"},
    }
    scene = slipwave.read(data)
    assert scene.stiffness / scene.transit / 10.0 == pytest.approx(2e-3, rel=1e-13)
    springs = [slab.termination.spring for slab in scene.slabs]
    assert springs[0] == pytest.approx(springs[1], rel=1e-13)
    assert springs[0] * 5e6 / 10e-6 == pytest.approx(2.0 / (1.0 / 1e10 - 0.01 / 30e9 - 0.01 / 10e9), rel=1e-12)
    for same in (2e3, "2000 1/m", "0.002 um^-1", "2 / mm"):
        assert slipwave.read(data, {"machine.k": same}).digest == scene.digest
    own = slipwave.read(PLAIN | {"machine": {"k": 1e-3}})
    assert own.stiffness / own.transit == pytest.approx(1e-3, rel=1e-13)
    for wrong, line in (
        ({"machine.k": "0.16 /um"}, r'machine.k = "0.16 /um": must be below 150000 1/m, the stiffness of the slabs alone'),
        ({"machine.k": "5 MPa"}, "must have a unit of stiffness over normal stress"),
        ({"upper.face": {"kind": "rigid"}}, "upper.face: must not be given together with machine.k"),
    ):
        with pytest.raises(SceneError, match=line):
            slipwave.read(data, wrong)


def test_si_gives_the_same_numbers():
    paper, si = slipwave.read("paper"), slipwave.read("paper-si")
    assert si.upper.epsilon == pytest.approx(paper.upper.epsilon, rel=1e-12)
    assert si.upper.round_trip == pytest.approx(paper.upper.round_trip, rel=1e-12)
    assert si.units.time == pytest.approx(0.9)
    table_1 = slipwave.read("paper-si", ["slab.density=800"])
    assert table_1.upper.epsilon == pytest.approx(2.828427e-5, rel=1e-6)


def test_round_trip_of_a_slab_in_metres():
    rock = slipwave.read("rock")
    speed = math.sqrt(1e10 / 2500)
    assert rock.upper.round_trip == pytest.approx(2 * 0.21 / speed / 20.0, rel=1e-14)
    assert rock.upper.epsilon == pytest.approx(2500 * speed * 1e-6 / 1e8, rel=1e-14)


LAYERS = [{"fraction": 0.25, "impedance": 2}, {"fraction": 0.75, "impedance": 1}]


@pytest.mark.parametrize(
    ("slab", "part", "expected"),
    [
        ({}, "face", RigidFace()),
        ({"face": {}}, "face", RigidFace()),
        ({"face": {"kind": "rigid"}}, "face", RigidFace()),
        ({"face": {"kind": "grip", "stiffness": 10, "impedance": 0}}, "face", GripFace(10.0, 0.0)),
        ({"face": {"kind": "reflection", "coefficient": -1}}, "face", ReflectingFace(-1.0)),
        ({"face": {"kind": "reflection", "coefficient": 1}}, "face", RigidFace()),
        ({"viscosity": {"kind": "kelvin-voigt", "time": 1e-5}}, "viscosity", KelvinVoigtViscosity(1e-5)),
        ({"viscosity": {"kind": "standard-linear", "time": 1, "ratio": 0.5}}, "viscosity", StandardLinearViscosity(1.0, 0.5)),
        ({"layers": LAYERS}, "layers", (Layer(0.25, 2.0), Layer(0.75, 1.0))),
    ],
)
def test_parts_of_a_slab(slab, part, expected):
    assert getattr(slipwave.read(PLAIN | {"slab": PLAIN["slab"] | slab}).upper, part) == expected


@pytest.mark.parametrize(
    ("tables", "part", "expected"),
    [
        ({"drive": {"velocity": [[0, 100], [10, 0.0], [20.5, 7]]}}, "drive", Drive((0.0, 10.0, 20.5), (100.0, 0.0, 7.0))),
        ({"start": {"kind": "jump"}}, "start", Start(StartKind.JUMP, 0.05)),
        ({"start": {"kind": "orbit", "size": 1}}, "start", Start(StartKind.ORBIT, 1.0)),
        ({"run": {"until": 5, "record": ["events", "interface"]}}, "record", {"events", "interface"}),
    ],
)
def test_parts_of_a_scene(tables, part, expected):
    assert getattr(slipwave.read(PLAIN | tables), part) == expected


def test_a_file_is_the_same_as_its_dictionary(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(  # with the byte order mark and an end of line of another system
        '\ufeff[interface]\r\nlaw = "ageing"\na_star = 0.369\na = 0.0349\nb = 0.0489\n'
        "[slab]\nepsilon = 2.8e-5\nr = 0.002\n[drive]\nvelocity = 100\n"
    )
    assert slipwave.read(path) == slipwave.read(str(path)) == slipwave.read(PLAIN | {"name": "mine"})
    assert slipwave.read(path).digest == slipwave.read(PLAIN).digest


def test_reading_leaves_the_dictionary_alone():
    before = copy.deepcopy(PLAIN)
    slipwave.read(PLAIN, ["slab.log10_r=-2", "slab.face.kind=grip", "slab.face.stiffness=1", "slab.face.impedance=1"])
    assert before == PLAIN


def test_reading_a_scene_again_leaves_it_alone():
    scene = slipwave.read("grip")
    before = copy.deepcopy(scene.tables)
    changed = slipwave.read(scene, ["upper.face.kind=rigid", "lower.face.stiffness=7", "lower.log10_r=-2"])
    assert scene.tables == before
    assert changed.tables["upper"]["face"] == {"kind": "rigid"}
    assert changed.tables["lower"]["face"] == {**before["slab"]["face"], "stiffness": 7}


def test_an_override_replaces_its_sibling_and_takes_bare_words_and_new_kinds():
    assert slipwave.read("paper", ["slab.r=0.003"]).upper.round_trip == 0.003
    assert slipwave.read(PLAIN, ["slab.log10_r=-2.3"]).upper.round_trip == 10**-2.3
    assert slipwave.read("paper-si", {"slab.log10_r": -2.3}).upper.round_trip == 10**-2.3
    assert slipwave.read("paper", ["slab.r=0.003", "slab.log10_r=-2"]).upper.round_trip == 1e-2
    assert type(slipwave.read("paper", ["interface.law=slip"]).law).__name__ == "Slip"
    assert slipwave.read("grip", ["slab.face.coefficient=0.5", "slab.face.kind=reflection"]).upper.face == ReflectingFace(0.5)
    assert slipwave.read("paper", ["name = other", "run.until = 10"]).name == "other"
    assert slipwave.read("paper", "drive.velocity=[[0, 1], [1, 2]]").drive.velocities == (1.0, 2.0)
    cutoff = slipwave.read("paper", ["interface.law=ageing-cutoff", "interface.cutoff_velocity=40"])
    assert slipwave.read(cutoff, ["cutoff_velocity=50"]).law.cutoff_velocity == 50.0  # the last word of a key is enough


def test_an_override_of_slab_is_refused_where_slabs_differ():
    with pytest.raises(SceneError, match=r"slab\.r.*upper\.r or lower\.r"):
        slipwave.read("unlike", ["slab.r=1e-3"])


CHANGES = {
    "face.stiffness": ("grip", 3.0),
    "face.mass": ("machine", 3.0),
    "face.kind": ("grip", "rigid"),
    "viscosity.time": ("viscous", 1e-6),
    "layers": ("layered", [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": 2.5}]),
    "log10_r": ("paper", -2.5),
}


@pytest.mark.parametrize("key", CHANGES)
@pytest.mark.parametrize("side", ["upper", "lower"])
def test_an_override_of_one_slab_leaves_the_other_as_it_was(key, side):
    name, value = CHANGES[key]
    before, after = slipwave.read(name), slipwave.read(name, {f"{side}.{key}": value})
    other = "lower" if side == "upper" else "upper"
    assert getattr(after, other) == getattr(before, other)
    assert getattr(after, side) != getattr(before, side)


GRANITE = {
    "interface": BARE["interface"] | {"normal_stress": "5 MPa", "memory_length": "10 um", "reference_velocity": "1 um/s"},
    "slab": {"density": "2.7 g/cm3", "shear_modulus": "30 GPa", "thickness": "10 m"},
    "drive": {"velocity": "1 um/s"},
}
ROUND_TRIP = 2 * 10 / (3e10 / 2700) ** 0.5
"""In seconds."""


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("5 MPa", "Pa", 5e6),
        ("10um", "m", 1e-5),
        ("2.7 g cm-3", "kg/m3", 2700.0),
        ("2.7 g/cm³", "kg/m3", 2700.0),
        ("-1e-3 m**2", "m2", -1e-3),
        ("36 mm/h", "m/s", 1e-5),
        ("2 MPa·s/m", "Pa s/m", 2e6),
        (" .5 hours ", "s", 1800.0),
    ],
)
def test_a_quantity_is_converted_without_rounding(text, unit, value):
    assert looks_measured(text)
    assert quantity(text, unit).value == value


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("5 Mpa", '"Mpa" is not a unit; must have a unit of stress, as in "5 MPa"; did you mean "5 MPa"?'),
        ("7 gpa", '"gpa" is not a unit; must have a unit of stress, as in "5 MPa"; did you mean "7 GPa"?'),
        ("5 m", 'must have a unit of stress, as in "5 MPa", not "m"'),
        ("5", 'must have a unit of stress, as in "5 MPa"'),
        ("9**9**9 Pa", 'must have a unit of stress, as in "5 MPa"'),
        ("__import__('os') Pa", 'must have a unit of stress, as in "5 MPa"'),
    ],
)
def test_another_text_is_refused_with_the_likely_unit(text, reason):
    with pytest.raises(ValueError, match="unit") as caught:
        quantity(text, "Pa")
    assert str(caught.value) == reason


def test_a_scene_with_units_is_the_scene_in_bare_numbers():
    read = slipwave.read(GRANITE)
    assert read == slipwave.read(BARE)
    assert tuple(vars(read.upper.material).values()) == (2700.0, 3e10)
    assert read.upper.material.wave_speed == pytest.approx(10 / 0.003, rel=1e-12)


def test_times_and_velocities_become_transits_and_reference_velocities():
    changes = {"run.until": "60 s", "slab.viscosity": {"kind": "kelvin-voigt", "time": "1 ms"}}
    scene = slipwave.read(GRANITE, changes | {"drive.velocity": [["0 s", "1 um/s"], ["100 s", "10 um/s"], [1e6, 3.0]]})
    assert scene.drive.times == pytest.approx((0.0, 100 / ROUND_TRIP, 1e6), rel=1e-14)
    assert scene.drive.velocities == pytest.approx((1.0, 10.0, 3.0), rel=1e-15)
    assert scene.until == pytest.approx(60 / ROUND_TRIP, rel=1e-14)
    assert scene.upper.viscosity.time == pytest.approx(1e-4, rel=1e-14)  # L/V* is 10 s


@pytest.mark.parametrize(
    ("given", "one", "wanted"),
    [("10 um/s", "1 um/s", 10.0), ("3 um/s", "1 um/s", 3.0), ("7 mm/s", "0.7 mm/s", 10.0), ("1 um/s", "3 um/s", 1.0 / 3.0)],
)
def test_a_velocity_in_units_is_the_exact_multiple_of_the_reference(given, one, wanted):
    """1e-5/1e-6 is 10.000000000000002 in binary."""
    assert slipwave.read(GRANITE, {"interface.reference_velocity": one, "drive.velocity": given}).velocity == wanted


def test_set_takes_units_without_quotes_and_a_scene_is_read_again():
    scene = slipwave.read(GRANITE, ["interface.normal_stress=10 MPa", "run.until=60s", 'drive.velocity=[["0 s", "2 um/s"]]'])
    assert (scene.units.normal_stress, scene.velocity) == (1e7, 2.0)
    assert (scene.until, scene.tables["run"]["until"]) == (pytest.approx(60 / ROUND_TRIP, rel=1e-14), "60s")
    assert slipwave.read(scene, {"name": "again"}).until == scene.until


@pytest.mark.parametrize(
    ("key", "value", "one"),
    [
        ("stiffness", "1 GPa/m", 2700 * 30e9 / 10 / 2700 / 2),  # epsilon/r in SI: G / (2 thickness)
        ("impedance", "1 MPa s/m", (2700 * 30e9) ** 0.5),
        ("mass", "400 kg/m2", 2 * 2700 * 10),
    ],
)
def test_a_machine_is_relative_to_the_slab_per_area_or_with_an_area(key, value, one):
    quiet = {"kind": "machine", "stiffness": 1e9, "impedance": 0.0, "mass": 0.0}
    number, _, unit = value.partition(" ")
    whole = {"GPa/m": "GN/m", "MPa s/m": "MN s/m", "kg/m2": "kg"}[unit]
    expected = quantity(value, {"GPa/m": "Pa/m", "MPa s/m": "Pa s/m", "kg/m2": "kg/m2"}[unit]).value
    for face in (
        quiet | {key: value},
        quiet | {key: expected},
        quiet | {"area": "25 cm2", key: f"{float(number) * 0.0025} {whole}"},
        quiet | {"area": 0.0025, key: expected * 0.0025},
        quiet | {"area": 0.0025, key: value},
    ):
        found = slipwave.read(GRANITE, {"slab.face": face}).upper.face
        assert getattr(found, key) == pytest.approx(expected / one, rel=1e-12)


def test_a_grip_takes_units_and_its_bare_numbers_stay_relative():
    grip = slipwave.read(GRANITE, {"slab.face": {"kind": "grip", "stiffness": "3 GPa/m", "impedance": 0.5}}).upper.face
    assert (grip.stiffness, grip.impedance) == (pytest.approx(2.0, rel=1e-12), 0.5)


SLAB = {"slab.shear_modulus": "30 GPa", "slab.density": "2.7 g/cm3", "slab.thickness": "5 m"}
ROCK = SLAB | {"interface.normal_stress": "5 MPa"}


@pytest.mark.parametrize("name", gallery_names())
def test_no_scene_of_the_gallery_is_doubted(name):
    assert doubts(slipwave.read(name)) == []


@pytest.mark.parametrize(
    ("key", "value", "line"),
    [
        ("slab.shear_modulus", 30, " = 30 Pa (wave speed 0.105 m/s): solids have 1 kPa to 600 GPa; did you mean 30 GPa?"),
        ("interface.normal_stress", 5, " = 5 Pa: sliding samples have 50 Pa to 5 GPa; did you mean 5 MPa?"),
        ("slab.thickness", 1e4, " = 1e+04 m: slabs of a laboratory have 100 um to 1000 m; did you mean 10000 mm?"),
        ("drive.velocity", "1 km/s", " = 1000 m/s: drives have 1e-06 um/s to 10 m/s; did you mean 1000 um/s?"),
        ("slab.density", "100 kg/m3", "slab.wave speed = 1.732e+04 m/s: shear waves have 500 mm/s to 13000 m/s"),
    ],
)
def test_a_value_that_can_hardly_be_meant(key, value, line):
    assert doubts(slipwave.read("rock", ROCK)) == []
    (found,) = doubts(slipwave.read("rock", ROCK | {key: value}))
    assert found.startswith(key + line if line.startswith(" ") else line)


def test_a_soft_machine_is_doubted_and_a_free_face_is_not():
    face = {"kind": "machine", "stiffness": 1.0, "impedance": 0.0, "mass": 0.0}
    (line,) = doubts(slipwave.read("rock", ROCK | {"upper.face": face}))
    assert line == "upper.face.stiffness = 1 Pa/m: testing machines have 1 kPa/m to 100 TPa/m; did you mean 1 GPa/m?"
    assert doubts(slipwave.read("rock", ROCK | {"slab.face": face | {"stiffness": 0.0}})) == []


def test_a_scene_without_units_is_never_doubted():
    odd = slipwave.read("rock", {"interface.normal_stress": 5})
    assert doubts(odd) != []
    assert doubts(dataclasses.replace(odd, units=None)) == []
