"""Numbers with units: what they become, and doubts where they can hardly be meant."""

import dataclasses

import pytest

import slipwave
from slipwave.input.quantity import looks_measured, quantity
from slipwave.input.source import gallery_names
from slipwave.scene.doubts import doubts
from tests.granite import GRANITE as BARE

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
    scene = slipwave.read(
        GRANITE,
        {
            "drive.velocity": [["0 s", "1 um/s"], ["100 s", "10 um/s"], [1e6, 3.0]],
            "run.until": "60 s",
            "slab.viscosity": {"kind": "kelvin-voigt", "time": "1 ms"},
        },
    )
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
