"""What outer faces do is said: |R| against closed forms, in the head, the JSON and the figure of each command."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

import slipwave
from reduced.impedance import impedance
from reduced.impedance.transmission_line import Jet, slab_ratio
from slipwave.friction.law import friction_slopes
from slipwave.scene.slab import VISCOSITIES, Layer, Rheology
from tests.granite import GRANITE
from validation.commands.wording import header

R = 0.0018
GRIP = {"kind": "grip", "stiffness": 10.0, "impedance": 3.0}
UNITS = {"interface.normal_stress": "5 MPa", "interface.memory_length": "10 um", "interface.reference_velocity": "1 um/s"}


@pytest.mark.parametrize(
    ("face", "viscosity", "fast", "rate"),
    [
        ({"kind": "machine", "stiffness": 10.0, "impedance": 0.5, "mass": 0.5}, {}, 1.0, math.sqrt(20.0) / R),
        ({"kind": "machine", "stiffness": 10.0, "impedance": 9.0, "mass": 0.5}, {}, 1.0, 10.0 / (9.0 * R)),
        ({"kind": "grip", "stiffness": 2.0, "impedance": 0.0}, {}, -1.0, math.inf),
        ({"kind": "reflection", "coefficient": -0.25}, {}, -0.25, 0.0),
        (GRIP, {"kind": "kelvin-voigt", "time": 2e-5}, -1.0, 10.0 / (3.0 * R)),
        (GRIP, {"kind": "standard-linear", "time": 2e-5, "ratio": 0.5}, 0.5, 10.0 / (3.0 * R)),
    ],
)
def test_fast_waves_and_the_reach_of_the_spring(face, viscosity, fast, rate):
    changes = {"slab.r": R, "slab.face": face} | ({"slab.viscosity": viscosity} if viscosity else {})
    slab = slipwave.read("paper", changes).upper
    assert slab.fast_reflection == pytest.approx(fast, rel=1e-14)
    assert slab.reflection(1e16j).real == pytest.approx(fast, abs=1e-4)
    assert slab.termination.spring_rate == pytest.approx(rate, rel=1e-14)


@dataclass(frozen=True)
class Creep:
    """A viscosity of the user's own, whose one time is the sum of two."""

    early: float
    late: float

    @property
    def rheology(self):
        return Rheology(self.early + self.late)


def test_a_viscosity_without_a_key_time_has_its_time_in_si(monkeypatch):
    """Before, an AttributeError, or the seconds of a part of it."""
    monkeypatch.setitem(VISCOSITIES, "creep", Creep)
    scene = slipwave.read("paper-si")
    slab = replace(scene.upper, viscosity=Creep(1.0, 3.0))
    assert "slabs: creep: early 1, late 3 (3.6 s)" in header(replace(scene, upper=slab, lower=slab))


@pytest.mark.parametrize("scene", ["grip", "machine", "reflection", "viscous"])
@pytest.mark.parametrize("impedance", [1.0, 2.0])
def test_the_reflection_is_that_of_the_one_port(scene, impedance):
    """A slab of one layer Z_c moves by w Z_c = stress (1 - R E)/(1 + R E), E the round trip of a wave through it."""
    slab = slipwave.read(scene, {"slab.face": GRIP} if scene == "viscous" else {}).upper
    slab = replace(slab, layers=(Layer(1.0, impedance),))
    s = np.array([3.0 + 70.0j, 1900.0j, 20.0 + 8000.0j])
    p, q = slab_ratio(slab, Jet.variable(s))
    root = slab.rheology.modulus(s) ** 0.5
    echo = slab.reflection(s) * np.exp(-s * slab.round_trip / root)
    assert p.value / q.value * slab.epsilon * impedance * root == pytest.approx((1.0 - echo) / (1.0 + echo), rel=1e-10)


def test_commands_say_what_faces_do(answer, printed):
    """`run` judges at omega_c of friction, `stability` at its leading root; both in the head, the JSON and as attributes."""
    scene = slipwave.read("grip")
    omega = friction_slopes(scene.law, 100.0).omega_c
    ran, told = slipwave.run("grip", until=20.0).faces, answer("run", "grip", "--until", "20")["faces"]
    squares = [one**2 + (10.0 / (R * omega)) ** 2 for one in (2.0, 4.0)]
    numbers = {"omega": omega, "reflection": math.sqrt(squares[0] / squares[1]), "fast_reflection": 0.5}
    near = {name: pytest.approx(one) for name, one in (numbers | {"spring_rate": 10.0 / (3.0 * R)}).items()}
    assert told == ran == [{"slab": "slab", "kind": "grip"} | near]
    found = slipwave.stability("grip")
    (face,) = found.faces
    assert face.omega == found.leading_roots[0].imag != pytest.approx(omega, rel=0.01)
    assert face.reflection == pytest.approx(abs(scene.upper.reflection(1j * face.omega)), rel=1e-14)
    line = "at omega = {:.4g} V*/L it reflects |R| = {:.6g}; below K/Z_g = 1852 V*/L it is its spring"
    assert f"slabs: {line.format(face.omega, face.reflection)}" in printed("stability", "grip").splitlines()
    assert f"# slabs: {line.format(omega, told[0]['reflection'])}" in printed("show", "grip").splitlines()


def test_rates_are_told_in_si_too(answer, printed):
    """A block of rock, L/V* = 10 s, between grips."""
    slab = {"density": "2.7 g/cm3", "shear_modulus": "30 GPa", "thickness": "10 m", "face": GRIP}
    changes = UNITS | {"slab." + key: value for key, value in slab.items()} | {"drive.velocity": "1 um/s"}
    (face,) = slipwave.stability("rock", **changes).faces
    assert (face.omega / face.omega_per_s, face.spring_rate / face.spring_rate_per_s) == pytest.approx((10.0, 10.0), rel=1e-13)


def test_where_friction_strengthens_only_fast_waves_are_judged():
    (face,) = slipwave.run("grip", until=5.0, **{"interface.b": 0.02}).faces
    assert (face.omega, face.reflection, face.fast_reflection) == (None, None, pytest.approx(0.5))


@pytest.mark.parametrize(("scene", "model"), [("grip", "fitted:4"), ("paper", "delay"), ("steel-on-pmma", "delay")])
def test_the_figure_shows_impedance_and_reflection_over_frequency(scene, model):
    found = slipwave.stability(scene, model)
    roots, pair, *faces = found.chart().panels
    slabs = [slab for slab in (found.scene.upper, found.scene.lower) if not slab.termination.is_rigid]
    assert len(faces) == min(len(slabs), 1)
    exact = pair.traces[0]
    assert exact.name == ("delay" if model == "delay" else "exact")
    wanted = np.abs(impedance(found.scene, 1j * exact.x)) / found.scene.impedance
    assert np.asarray(exact.y) == pytest.approx(wanted, rel=1e-12)
    assert [trace.x[0] for trace in pair.traces if trace.name == "leading root"] == [found.leading_roots[0].imag]
    for panel in faces:
        assert np.asarray(panel.traces[0].y) == pytest.approx(np.abs(slabs[0].reflection(1j * panel.traces[0].x)), rel=1e-12)
        assert [mark.x[0] for mark in panel.traces if "spring" in mark.name] == [slabs[0].termination.spring_rate]
    assert roots.traces[0].y == pytest.approx(found.leading_roots.imag)


@pytest.mark.parametrize("scene", ["paper", "unlike", "grip", "viscous", "slip-law", "layered"])
@pytest.mark.parametrize("model", ["delay", "quasidynamic", "fitted:3"])
def test_a_root_on_the_axis_is_neutral_and_no_verdict(scene, model):
    critical = float(10.0 ** slipwave.stability(scene, model).summary["log10_r_c"])
    for share in (1e-9, -1e-9, 0.0):
        r = critical * (1.0 + share)
        changes = {"upper.r": r, "lower.r": 2.0 * r} if scene == "unlike" else {"slab.r": r}
        found = slipwave.stability(scene, model, **changes).summary
        assert abs(found["leading_roots"][0][0]) < 1e-9 * 1e3 * found["omega_c"]
        assert (found["stable"], found["unstable_roots"]) == (None, 0)
        assert ["neutral within rounding" in note for note in found["notes"]] == [True]


def test_figures_that_do_not_exist_have_a_reason(answer):
    """Quasi-dynamic slabs on a machine whose onset lies beyond every thickness, and friction that strengthens."""
    face = {"kind": "machine", "stiffness": 1e11, "impedance": 1e6, "mass": 400.0}
    changes = {"slab.thickness": 1.0, "slab.face": face, "drive.velocity": 1e6}
    found = slipwave.stability(GRANITE, "quasidynamic", **changes).summary
    reach = "between 9.5e-07 and 1024 times the present one"
    assert (found["log10_r_c"], found["omega_c"], found["si"]["critical_thickness_m"]) == (None, None, None)
    assert found["epsilon_c"] > 0.0
    assert found["notes"] == [
        f"no critical r: steady sliding loses its stability at no r {reach}",
        f"no critical thickness: steady sliding loses its stability at none {reach}",
    ]
    found = answer("stability", "paper", "--set", "interface.b=0.01")
    assert [found[name] for name in ("stable", "omega_c", "log10_r_c", "epsilon_c")] == [True, None, None, None]
    assert found["notes"] == [
        f"infinitely many roots accumulate at Re s = {found['essential_abscissa']:.6g} V*/L, right of all that are listed: "
        "no finite list holds those that decay most slowly",
        "no critical values: friction does not weaken with the slip rate, so that steady sliding is always stable",
    ]


@pytest.mark.parametrize(
    ("scene", "held", "told"),
    [
        ("paper-si", {"slab.face": {"kind": "grip", "stiffness": "0.2 GPa/m", "impedance": 3.0}}, True),
        ("paper-si", {"slab.face": {"kind": "machine", "stiffness": 2e8, "impedance": 0.0, "mass": 0.0}}, True),
        ("paper-si", {"slab.face": {"kind": "grip", "stiffness": 10.0, "impedance": 3.0}}, False),
        ("paper", {"slab.face": {"kind": "machine", "stiffness": 10.0, "impedance": 0.0, "mass": 0.0}}, False),
        ("paper", {"machine.k": 0.005}, True),  # before, nothing was said of it
    ],
)
def test_critical_values_say_where_a_setting_does_not_lead_to_them(scene, held, told):
    """They are those of faces that change with the slabs; one in units of its own does not when a key of its slab is set."""
    found = slipwave.stability(scene, **held)
    there = slipwave.stability(scene, **held, log10_r=found.log10_r_c)
    assert bool(abs(there.leading_roots[0].real) > 1e-6) is told
    assert any("a face in units of its own" in note for note in found.notes) is told


@pytest.mark.parametrize(
    ("face", "told"),
    [
        ({"kind": "rigid"}, "in series 1.48907e+07 Pa/m"),
        ({"kind": "reflection", "coefficient": 1.0}, "in series 1.48907e+07 Pa/m"),
        (
            {"kind": "reflection", "coefficient": 0.5},
            "in series 0, since a face has no spring, without that face 1.48907e+07 Pa/m",
        ),
    ],
)
def test_slabs_behind_a_face_without_a_spring_have_no_stiffness(face, told):
    """That of the slabs is G/(2 h). The drive does not load the interface through such a face, however stiff slabs are."""
    scene = slipwave.read("paper-si", {"slab.face": face})
    assert f"stiffness of slabs and faces {told}" in "\n".join(header(scene))
