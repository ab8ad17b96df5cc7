"""Every kind of outer face as numbers, by hand; units, clocks, limits and refusals."""

import math

import pytest

from slipwave.errors import SceneError
from slipwave.scene.slab import GripFace, Layer, MachineFace, ReflectingFace, RigidFace, Slab, Termination

EPSILON, ROUND_TRIP, OUTERMOST = 3e-5, 0.002, 2.0
LAYERS = (Layer(0.4, 1.0), Layer(0.6, OUTERMOST))
RIGID = Termination(0.0, math.inf, 0.0)


def held(face):
    return Slab(EPSILON, ROUND_TRIP, face, layers=LAYERS).termination


@pytest.mark.parametrize(
    ("face", "spring", "dashpot", "mass"),
    [
        (GripFace(2.0, 0.5), 0.03, 1.5e-5, 0.0),  # relative to epsilon/r and epsilon, whatever the layers
        (GripFace(2.0, 0.0), 0.03, 0.0, 0.0),
        (MachineFace(2.0, 0.5, 4.0), 0.03, 1.5e-5, 2.4e-7),  # mass relative to epsilon r
        (MachineFace(0.0, 0.0, 0.0), 0.0, 0.0, 0.0),
        (ReflectingFace(0.5), 0.0, 3.0 * 6e-5, 0.0),  # (1 + R)/(1 - R) of the outermost layer's impedance
        (ReflectingFace(0.0), 0.0, 6e-5, 0.0),
        (ReflectingFace(-1.0), 0.0, 0.0, 0.0),
    ],
)
def test_numbers_of_every_face(face, spring, dashpot, mass):
    found = held(face)
    assert (found.spring, found.dashpot, found.mass) == pytest.approx((spring, dashpot, mass), rel=1e-14)
    assert not found.is_rigid
    assert found.has_dead_load == (spring == 0.0)


UNMOVED = [GripFace(math.inf, 0.5), GripFace(2.0, math.inf), MachineFace(math.inf, 0.0, 4.0), MachineFace(0.0, math.inf, 4.0)]


@pytest.mark.parametrize("face", [RigidFace(), ReflectingFace(1.0), *UNMOVED])
def test_what_cannot_move_against_the_drive_is_rigid_by_whatever_name(face):
    assert held(face) == RIGID
    assert held(face).is_rigid
    assert not held(face).has_dead_load
    assert Slab(EPSILON, ROUND_TRIP, face) == Slab(EPSILON, ROUND_TRIP)
    assert Slab(EPSILON, ROUND_TRIP, face).is_plain


def test_time_in_transits():
    """Over a transit of 0.002 a spring builds up 0.002 times what it does in a unit of L/V*."""
    found = held(MachineFace(2.0, 0.5, 4.0)).in_transits(ROUND_TRIP)
    assert (found.spring, found.dashpot, found.mass) == pytest.approx((2.0 * EPSILON, 0.5 * EPSILON, 4.0 * EPSILON), rel=1e-14)
    assert RIGID.in_transits(ROUND_TRIP) == RIGID


@pytest.mark.parametrize(
    "numbers", [(-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (1.0, 1.0, -1.0), (1.0, 1.0, math.inf), (math.nan, 1.0, 1.0)]
)
def test_what_no_face_can_be_is_refused(numbers):
    with pytest.raises(SceneError, match=r"outer face: spring = .*, dashpot = .*, mass = .*: must be 0 or more, the mass finite"):
        Termination(*numbers)
