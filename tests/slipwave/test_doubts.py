"""Values that can hardly be meant are doubted, each with the unit that is likely; none of the gallery is."""

import dataclasses

import pytest

import slipwave
from slipwave.input.source import gallery_names
from slipwave.scene.doubts import doubts

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
