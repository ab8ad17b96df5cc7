"""The titles of the gallery's scenes are true."""

import math

import pytest

import slipwave
from reduced.impedance import impedance
from reduced.stability import critical_round_trip, essential_abscissa
from slipwave.input.source import gallery_titles
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, ReflectingFace

TITLES = gallery_titles()
DOUBLING = -2.595727667
"""log10 r of the Kelvin-Voigt system's first period doubling in the paper's material, by AUTO-07p."""


def log10_r(name: str) -> float:
    return math.log10(slipwave.read(name).transit)


def test_the_papers_scenes_lie_on_the_side_of_the_period_doubling_that_they_name() -> None:
    assert log10_r("paper-2.6") < DOUBLING < log10_r("paper-2.59")
    assert f"short of the ODE's first period doubling at 10^{DOUBLING:.4f}" in TITLES["paper-2.6"]
    assert "beyond the ODE's first period doubling" in TITLES["paper-2.59"]


@pytest.mark.parametrize("name", ["paper", "paper-2.3", "paper-2.59", "paper-2.6"])
def test_a_title_names_its_own_round_trip(name: str) -> None:
    assert f"r = 10^{log10_r(name):.4g}" in TITLES[name]


def test_the_height_of_the_jumps_echo() -> None:
    jump = slipwave.read("jump")
    left = math.exp(essential_abscissa(jump) * jump.transit)
    assert f"{100.0 * left:.0f} per cent of the height of the one before" in TITLES["jump"]


def test_the_height_of_a_wave_in_viscous_slabs() -> None:
    viscous = slipwave.read("viscous")
    viscosity = viscous.upper.viscosity
    assert isinstance(viscosity, KelvinVoigtViscosity)
    s = 2j * math.pi / viscous.transit
    left = abs(complex(math.e) ** (-s * viscous.transit / (1.0 + s * viscosity.time) ** 0.5))
    assert f"loses {100.0 * (1.0 - left):.0f} per cent" in TITLES["viscous"]


def test_how_far_the_rock_lies_beyond_the_onset() -> None:
    rock = slipwave.read("rock")
    assert rock.transit / critical_round_trip(rock, "delay")[0] == pytest.approx(1.05, abs=0.005)
    assert "five per cent beyond the onset" in TITLES["rock"]
    assert rock.units is not None
    assert rock.velocity * rock.units.reference_velocity == pytest.approx(0.01)
    assert "1 cm/s" in TITLES["rock"]


def test_what_the_faces_do_to_a_wave_and_to_the_load() -> None:
    grip, leak = slipwave.read("grip"), slipwave.read("reflection").upper.face
    assert isinstance(grip.upper.face, GripFace)
    assert (grip.upper.face.impedance - 1.0) / (grip.upper.face.impedance + 1.0) == 0.5
    assert "reflect half of every wave but keep the load" in TITLES["grip"]
    slow = 1e-6j / grip.transit
    assert abs(impedance(grip, slow) * slow) == pytest.approx(grip.stiffness / grip.transit, rel=1e-9)
    assert isinstance(leak, ReflectingFace)
    assert leak.coefficient**1000 == pytest.approx(math.exp(-1.0), rel=1e-3)
    assert "to 1/e in 1000 transits" in TITLES["reflection"]
    slab = slipwave.read("machine").upper
    assert slab.termination.mass == pytest.approx(0.5 * slab.epsilon * slab.round_trip, rel=1e-14)  # rho h/2 over sigma L/V*^2
    assert "a mass of the slab's own" in TITLES["machine"]


def test_ratios_of_unlike_slabs_and_layers_and_of_the_ramp() -> None:
    unlike, irrational, ramp = (slipwave.read(name) for name in ("unlike", "unlike-irrational", "ramp"))
    assert unlike.lower.round_trip / unlike.upper.round_trip == pytest.approx(2.0, rel=1e-14)
    assert unlike.lower.epsilon / unlike.upper.epsilon == pytest.approx(3.0, rel=1e-14)
    assert "twice the round trip and three times the impedance" in TITLES["unlike"]
    assert irrational.lower.round_trip / irrational.upper.round_trip == pytest.approx(math.sqrt(2.0), rel=1e-14)
    assert [(layer.fraction, layer.impedance) for layer in slipwave.read("layered").upper.layers] == [(0.5, 1.0), (0.5, 2.0)]
    assert [ramp.drive.at(time) for time in (999.0, 1250.0, 1501.0)] == [100.0, 150.0, 200.0]
