"""Scenes that are right are read right: gallery, files, dictionaries, SI, overrides."""

import copy
import math

import pytest

import slipwave
from slipwave.errors import SceneError
from slipwave.input.source import gallery_names, gallery_titles
from slipwave.scene.drive import Start, StartKind
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, ReflectingFace, RigidFace, StandardLinearViscosity

INTERFACE = {"law": "ageing", "a_star": 0.369, "a": 0.0349, "b": 0.0489}
PLAIN = {"interface": INTERFACE, "slab": {"epsilon": 2.8e-5, "r": 0.002}, "drive": {"velocity": 100}}


def with_slab(**slab):
    return PLAIN | {"slab": {"epsilon": 2.8e-5, "r": 0.002} | slab}


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


@pytest.mark.parametrize(
    ("face", "expected"),
    [
        ({}, RigidFace()),
        ({"kind": "rigid"}, RigidFace()),
        ({"kind": "grip", "stiffness": 10, "impedance": 0}, GripFace(10.0, 0.0)),
        ({"kind": "reflection", "coefficient": -1}, ReflectingFace(-1.0)),
        ({"kind": "reflection", "coefficient": 1}, RigidFace()),
    ],
)
def test_faces(face, expected):
    assert slipwave.read(with_slab(face=face)).upper.face == expected


def test_viscosity_and_layers():
    assert slipwave.read(with_slab(viscosity={"kind": "kelvin-voigt", "time": 1e-5})).upper.viscosity == KelvinVoigtViscosity(
        1e-5
    )
    zener = slipwave.read(with_slab(viscosity={"kind": "standard-linear", "time": 1, "ratio": 0.5}))
    assert zener.upper.viscosity == StandardLinearViscosity(1.0, 0.5)
    layers = [{"fraction": 0.25, "impedance": 2}, {"fraction": 0.75, "impedance": 1}]
    assert slipwave.read(with_slab(layers=layers)).upper.layers == (Layer(0.25, 2.0), Layer(0.75, 1.0))


def test_ramps_and_starts():
    ramp = slipwave.read(PLAIN | {"drive": {"velocity": [[0, 100], [10, 0.0], [20.5, 7]]}})
    assert (ramp.velocity, ramp.drive.at(5.0), ramp.drive.at(15.25), ramp.drive.at(99.0)) == (100.0, 50.0, 3.5, 7.0)
    assert slipwave.read(PLAIN | {"start": {"kind": "jump"}}).start == Start(StartKind.JUMP, 0.05)
    assert slipwave.read(PLAIN | {"start": {"kind": "orbit", "size": 1}}).start.kind is StartKind.ORBIT
    assert slipwave.read(PLAIN | {"run": {"until": 5, "record": ["events", "interface"]}}).record == {"events", "interface"}


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


def test_an_override_replaces_its_sibling():
    assert slipwave.read("paper", ["slab.r=0.003"]).upper.round_trip == 0.003
    assert slipwave.read(PLAIN, ["slab.log10_r=-2.3"]).upper.round_trip == 10**-2.3
    assert slipwave.read("paper-si", {"slab.log10_r": -2.3}).upper.round_trip == 10**-2.3
    assert slipwave.read("paper", ["slab.r=0.003", "slab.log10_r=-2"]).upper.round_trip == 1e-2


def test_an_override_takes_bare_words_and_new_kinds():
    assert type(slipwave.read("paper", ["interface.law=slip"]).law).__name__ == "Slip"
    assert slipwave.read("grip", ["slab.face.coefficient=0.5", "slab.face.kind=reflection"]).upper.face == ReflectingFace(0.5)
    assert slipwave.read("paper", ["name = other", "run.until = 10"]).name == "other"
    assert slipwave.read("paper", "drive.velocity=[[0, 1], [1, 2]]").drive.velocities == (1.0, 2.0)


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


def test_the_last_word_of_a_key_of_the_scenes_law_is_enough():
    cutoff = slipwave.read("paper", ["interface.law=ageing-cutoff", "interface.cutoff_velocity=40"])
    assert slipwave.read(cutoff, ["cutoff_velocity=50"]).law.cutoff_velocity == 50.0
