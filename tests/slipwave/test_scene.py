"""What every solver takes from the scene: impedance, stiffness, faces as numbers, and a digest that misses nothing."""

import dataclasses
import math
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Annotated, Literal

import pytest

import slipwave
from slipwave.errors import SceneError
from slipwave.friction.ageing import Ageing
from slipwave.friction.slip import Slip
from slipwave.input import assemble
from slipwave.input.schema import RELAXATION, KeyTable, Measured, Numbers
from slipwave.scene import Scene
from slipwave.scene.drive import Drive, Start, StartKind, steady_drive
from slipwave.scene.slab import (
    Face,
    GripFace,
    KelvinVoigtViscosity,
    Layer,
    MachineFace,
    Material,
    ReflectingFace,
    Rheology,
    RigidFace,
    Slab,
    StandardLinearViscosity,
    Termination,
)
from slipwave.scene.units import Units

ELASTIC = Slab(2.0, 3.0)
LAYERED = (Layer(0.25, 0.5), Layer(0.75, 4.0))


def of(upper, lower, velocity=7.0):
    return Scene("test", Ageing(0.5, 0.01, 0.03), upper, lower, steady_drive(velocity))


def test_laws_of_the_same_numbers_make_other_scenes():
    """Before, caches gave a scene the roots of the same one with another law, and a sweep over laws and V was that of one law."""
    one, other = (dataclasses.replace(of(ELASTIC, ELASTIC), law=law(0.5, 0.01, 0.03)) for law in (Ageing, Slip))
    assert one != other
    assert len({one, other}) == 2
    assert len({one, of(ELASTIC, ELASTIC)}) == 1


# A slab of impedance e = rho c and one-way travel time T = H/c has G = e c, hence H/G = T/e: compliance per unit shear stress.
# Round trips are 2 T. Stiffness per transit is the upper slab's round trip over the sum of both slabs' H/G.
COMPLIANCES = [
    (ELASTIC, 1.5 / 2.0),
    (Slab(2.0, 3.0, layers=LAYERED), 0.25 * 1.5 / 1.0 + 0.75 * 1.5 / 8.0),
    (Slab(2.0, 3.0, GripFace(0.5, 9.0)), 0.75 + 3.0 / (0.5 * 2.0)),  # a spring of K e/r in series
    (Slab(2.0, 3.0, MachineFace(0.5, 9.0, 3.0)), 0.75 + 3.0 / (0.5 * 2.0)),
    (Slab(2.0, 3.0, MachineFace(0.0, 9.0, 3.0)), 0.75),  # a dead load adds none
    (Slab(2.0, 3.0, viscosity=KelvinVoigtViscosity(0.3)), 0.75),  # a creep that ends does not soften
    (Slab(2.0, 3.0, viscosity=StandardLinearViscosity(0.3, 0.6)), 0.75 * 1.6),  # relaxed modulus G/(1 + ratio)
    (Slab(2.0, 3.0, GripFace(0.5, 9.0), StandardLinearViscosity(0.3, 0.6), LAYERED), 1.6 * (0.375 + 1.125 / 8.0) + 3.0),
]


@pytest.mark.parametrize(("upper", "soft"), COMPLIANCES)
@pytest.mark.parametrize(("lower", "below"), [*COMPLIANCES, (Slab(0.4, 11.0), 5.5 / 0.4)])
def test_slabs_in_series_yield_the_sum_of_their_compliances(upper, soft, lower, below):
    assert of(upper, lower).stiffness == pytest.approx(3.0 / (soft + below), rel=1e-14)


def test_impedance_is_that_of_both_layers_at_the_interface_in_series():
    assert of(ELASTIC, ELASTIC).impedance == 1.0
    assert of(ELASTIC, Slab(6.0, 1.0)).impedance == pytest.approx(1.5, rel=1e-15)
    assert of(Slab(2.0, 3.0, layers=LAYERED), Slab(3.0, 1.0)).impedance == pytest.approx(0.75, rel=1e-15)  # 1 and 3
    assert of(Slab(3.0, 3.0), Slab(2.0, 3.0, layers=LAYERED)).impedance == pytest.approx(0.75, rel=1e-15)


@pytest.mark.parametrize("velocity", [1e-3, 1.0, 7.0])
@pytest.mark.parametrize("law", [Ageing(0.5, 0.01, 0.03), Slip(0.5, 0.01, 0.03)])
def test_steady_sliding_is_at_the_drive_before_the_run(law, velocity):
    chosen = dataclasses.replace(of(ELASTIC, ELASTIC), law=law, drive=Drive((0.0, 5.0), (velocity, 100.0)))
    assert (chosen.velocity, chosen.steady_psi) == (velocity, pytest.approx(-math.log(velocity), abs=1e-15))
    assert chosen.steady_stress == pytest.approx(0.5 - 0.02 * math.log(velocity), rel=1e-15)


NOT_PHYSICS = {"name", "record", "units", "tables", "material", "own"}
"""What a scene is called, which of its quantities are kept, the names of its units, how it was written, what slabs of known
impedance are made of and which numbers of their faces were in SI change no number."""

FULL = Slab(2.0, 3.0, GripFace(0.5, 9.0), StandardLinearViscosity(0.3, 0.6), LAYERED)
BASE = Scene("test", Ageing(0.5, 0.01, 0.03), FULL, FULL, Drive((0.0, 5.0), (7.0, 8.0)), Start(StartKind.JUMP, 0.5), 40.0)


def changed(value):
    """Every way to change one fact in `value`, by hand of its type: dataclasses, laws and tuples field by field."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        is_told = isinstance(value, Scene | Slab | Face)
        names = [field.name for field in dataclasses.fields(value) if not (is_told and field.name in NOT_PHYSICS)]
        return [dataclasses.replace(value, **{name: other}) for name in names for other in changed(getattr(value, name))]
    if hasattr(value, "_fields"):
        return [value._replace(**{name: other}) for name in value._fields for other in changed(getattr(value, name))]
    if isinstance(value, tuple):
        return [(*value[:i], other, *value[i + 1 :]) for i in range(len(value)) for other in changed(value[i])]
    if isinstance(value, StartKind):
        return [kind for kind in StartKind if kind is not value]
    return [math.nextafter(value, math.inf)]


def test_every_fact_of_a_scene_changes_its_digest():
    others = changed(BASE)
    others += [dataclasses.replace(BASE, law=Slip(*BASE.law))]
    others += [
        dataclasses.replace(BASE, upper=dataclasses.replace(FULL, **change))
        for change in (
            {"face": RigidFace()},
            {"face": ReflectingFace(0.5)},
            {"face": ReflectingFace(0.25)},
            {"viscosity": None},
            {"viscosity": KelvinVoigtViscosity(0.3)},
            {"viscosity": KelvinVoigtViscosity(0.2)},
            {"layers": LAYERED[::-1]},
        )
    ]
    assert len(others) == 3 + 10 + 10 + 4 + 3 + 1 + 8  # law, slabs, drive, start, until, and the kinds above
    digests = [BASE.digest, *(other.digest for other in others)]
    assert len(set(digests)) == len(digests)
    assert all(len(digest) == 12 and int(digest, 16) >= 0 for digest in digests)


def test_what_is_no_physics_leaves_the_digest_alone():
    units = slipwave.read("paper-si").units
    same = [{"name": "other"}, {"record": frozenset({"fields"})}, {"units": units}]
    assert {dataclasses.replace(BASE, **change).digest for change in same} == {BASE.digest}
    own = dataclasses.replace(FULL.face, own=frozenset(["stiffness"]))
    told = dataclasses.replace(BASE, upper=dataclasses.replace(FULL, material=Material(2700.0, 3e10), face=own))
    assert (told.digest, told) == (BASE.digest, BASE)
    assert {field.name for kind in (Scene, Slab, Face) for field in dataclasses.fields(kind)} >= NOT_PHYSICS


EPSILON, ROUND_TRIP, OUTERMOST = 3e-5, 0.002, 2.0
TWO_LAYERS = (Layer(0.4, 1.0), Layer(0.6, OUTERMOST))
RIGID = Termination(0.0, math.inf, 0.0)


def held(face):
    return Slab(EPSILON, ROUND_TRIP, face, layers=TWO_LAYERS).termination


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


@pytest.mark.parametrize("numbers", [(0.3, 0.2, 1.0), (0.3, 0.3, 1e-8), (0.0, 0.2, 0.0), (0.3, 0.0, 1.0), (0.0, 0.0, 1.0)])
def test_a_solid_that_no_full_wave_computes_as_the_impedance_has_it_is_refused(numbers):
    with pytest.raises(
        SceneError, match=r"Rheology\(retardation=.*\): the retardation must be relaxation \* \(1 \+ ratio\), or "
    ):
        Rheology(*numbers)
    assert StandardLinearViscosity(0.2, 1.0).rheology == Rheology(0.4, 0.2, 1.0)


@dataclass(frozen=True)
class FadingViscosity:
    """A viscosity of the user's own that may be none."""

    rheology: Rheology


@pytest.mark.parametrize("numbers", [(0.0, 0.0, 0.0), (0.3, 0.3, 0.0)])
def test_a_viscosity_of_no_effect_is_none(numbers):
    """Before, `auto` took the delay system, which refused the slabs as viscous, and fitted:N said that nothing damps waves."""
    slab = dataclasses.replace(ELASTIC, viscosity=FadingViscosity(Rheology(*numbers)))
    assert slab == ELASTIC
    assert slab.is_plain
    viscous = FadingViscosity(Rheology(0.3))
    assert dataclasses.replace(slab, viscosity=viscous).viscosity is viscous


@pytest.mark.parametrize("numbers", [(1e-3, 3e-3, -2.0 / 3.0), (-1.0, 0.0, 0.0), (0.0, 0.0, math.nan)])
def test_a_solid_that_feeds_its_waves_is_refused(numbers):
    """Before, one whose retardation was below its relaxation ended as too many roots of the stability."""
    with pytest.raises(SceneError, match=r"^Rheology\(retardation=.*\): must be 0 or more$"):
        Rheology(*numbers)


@dataclass(frozen=True)
class MatchedFace(Face):
    """A dashpot as the slab's end, beside a spring that relaxes with it over a time of its own."""

    time: float

    def termination(self, epsilon, round_trip, outermost):
        return Termination(outermost / self.time, outermost)


def test_a_face_that_does_not_scale_with_its_slab_is_refused():
    """Before, the critical r was that of another face, and fitted:4 was fitted to one of a time as a share of the transit."""
    with pytest.raises(SceneError, match=r"^MatchedFace\(time=0.5\): its spring must be proportional to epsilon/round_trip, its"):
        Slab(2.8e-5, 2e-3, MatchedFace(0.5))


class BoltTable(KeyTable):
    """Of a face of the user's own."""

    kind: Literal["bolt"] = "bolt"
    spring: Annotated[Measured, Numbers(0.0, 1e15, ("Pa/m",))]


class CreepTable(KeyTable):
    """Of a viscosity of the user's own."""

    kind: Literal["creep"] = "creep"
    time: Annotated[Measured, RELAXATION]
    later: Annotated[Measured, RELAXATION]
    yield_stress: Annotated[Measured, Numbers(0.0, 1e9, ("Pa",))] = 0.5


def test_units_of_own_kinds_of_face_and_viscosity_are_converted_or_refused(monkeypatch):
    """Before, a KeyError; a viscosity got what was read of the text instead of a number."""
    monkeypatch.setitem(assemble.FACES, "bolt", GripFace)
    monkeypatch.setitem(assemble.VISCOSITIES, "creep", dict)
    units = Units(1e-6, 2e-6, 1e6)
    with pytest.raises(SceneError, match=r'^slab\.face\.spring = "2 MPa/m": must be a number; of a face, only stiffness, imp'):
        assemble._outer_face("slab.face", BoltTable(spring="2 MPa/m"), None, 1.0, 1.0)
    creep = {"time": "2 s", "later": "1 min"}
    read = assemble._viscosity("slab", SimpleNamespace(viscosity=CreepTable(**creep)), units)
    assert read == {"time": pytest.approx(4.0), "later": pytest.approx(120.0), "yield_stress": 0.5}
    with pytest.raises(
        SceneError, match=r'^slab\.viscosity\.yield_stress = "1 MPa": must be a number; only times and velocities'
    ):
        assemble._viscosity("slab", SimpleNamespace(viscosity=CreepTable(**creep, yield_stress="1 MPa")), units)


@dataclass(frozen=True)
class PadFace(Face):
    """A dashpot on a share `area` of the face."""

    area: float

    def termination(self, epsilon, round_trip, outermost):
        return Termination(0.0, self.area * outermost)


class PadTable(KeyTable):
    kind: Literal["pad"] = "pad"
    area: Annotated[float, Numbers(0.0, 1.0)]


@pytest.mark.parametrize("units", [None, Units(1e-6, 2e-6, 1e6)])
def test_the_area_of_an_own_kind_of_face_is_its_own(units, monkeypatch):
    """Before, refused for want of units, and with them a TypeError: only a machine's is that of contact."""
    monkeypatch.setitem(assemble.FACES, "pad", PadFace)
    assert assemble._outer_face("slab.face", PadTable(area=0.25), units, 2.0, 3.0) == PadFace(0.25)
