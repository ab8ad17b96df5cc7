"""The elastic stress of every model on every kind of pair: y = mu_ss + K (drive - slip), K by hand, the slip by quadrature."""

import dataclasses

import numpy as np
import pytest

import slipwave
from slipwave.scene.drive import Drive, Start, StartKind
from slipwave.scene.slab import GripFace, Layer, Slab, StandardLinearViscosity
from slipwave.solve import follow
from validation.models.build import build

PAPER = slipwave.read("paper")
E, R = PAPER.upper.epsilon, PAPER.upper.round_trip
MU_SS = 0.369 - 0.014 * np.log(100.0)
RAMP = Drive((0.0, 4.25, 9.5, 12.0), (100.0, 100.0, 160.0, 70.0))
THICK = Slab(3.0 * E, 1.7 * R)
LAYERED = Slab(E, R, layers=(Layer(0.4, 1.0), Layer(0.6, 2.0)))


def of(upper, lower, drive=PAPER.drive):
    return dataclasses.replace(PAPER, upper=upper, lower=lower, drive=drive)


# thickness over modulus of a slab is r/(2 eps); K is per transit of the upper slab
SCENES = {
    "alike": (of(PAPER.upper, PAPER.upper, RAMP), E),
    "unlike": (of(PAPER.upper, THICK, RAMP), R / (R / (2 * E) + 1.7 * R / (6 * E))),
    "layered": (of(THICK, LAYERED, RAMP), 1.7 * R / (1.7 * R / (6 * E) + 0.4 * R / (2 * E) + 0.6 * R / (4 * E))),
    "grip below": (of(PAPER.upper, Slab(E, R, GripFace(2.0, 1.0)), RAMP), R / (R / (2 * E) + R / (2 * E) + R / (2 * E))),
}
VISCOUS = Slab(E, R, viscosity=StandardLinearViscosity(0.5 * R, 0.6))
RELAXED = (of(VISCOUS, THICK, RAMP), R / (1.6 * R / (2 * E) + 1.7 * R / (6 * E)))


class Slip:
    """Time and elastic stress at the ends of pieces, and the slip by Gauss's rule on each piece's own polynomial."""

    def __init__(self, nodes):
        points, weights = np.polynomial.legendre.leggauss(12)
        basis = np.linalg.inv(np.polynomial.legendre.legvander(2.0 * nodes - 1.0, nodes.size - 1))
        self.rows = np.polynomial.legendre.legvander(points, nodes.size - 1) @ basis
        self.weights = 0.5 * weights
        self.time, self.slip, self.elastic = [0.0], [0.0], [MU_SS]

    def scan(self, pieces):
        for time, length, z, elastic in zip(pieces.time, pieces.length, pieces.z, pieces.y, strict=True):
            self.time.append(time + length)
            self.slip.append(self.slip[-1] + length * self.weights @ np.exp(self.rows @ z))
            self.elastic.append(elastic[-1])


def driven(drive, time):
    """What the drive has moved by `time`: trapezoids between its knots."""
    knots = [0.0, *(t for t in drive.times if 0.0 < t < time), time]
    rates = np.interp(knots, drive.times, drive.velocities)
    return float(np.trapezoid(rates, knots))


def apart(chosen, stiffness, model, **options):
    """Largest difference between y and mu_ss + K (drive - slip), relative to how far y moves."""
    solver = build(model, chosen, **options)
    watch = Slip(solver.nodes)
    follow(solver, 20.0, [watch])
    moved = np.array([driven(chosen.drive, time) for time in watch.time])
    expected = MU_SS + stiffness * (moved - watch.slip)
    return float(np.abs(expected - watch.elastic).max() / np.ptp(expected))


WAVES = {"fd": 96, "sbp:6": 48, "fem:6": 4, "dg:7": 4}

GRIDLESS = [(name, model) for name in SCENES for model in ("delay", "quasidynamic", "block12", "modal:2")]
NEED_RIGID_FACES = [("grip below", "block12"), ("grip below", "modal:2")]


@pytest.mark.parametrize(("name", "model"), [case for case in GRIDLESS if case not in NEED_RIGID_FACES])
def test_gridless_models_load_by_the_stiffness_of_the_pair(name, model):
    assert apart(*SCENES[name], model) < 1e-12  # measured: 5e-14


@pytest.mark.parametrize("model", WAVES)
@pytest.mark.parametrize("name", SCENES)
def test_full_waves_load_by_the_stiffness_of_the_pair(name, model):
    assert apart(*SCENES[name], model, cells=WAVES[model]) < 5e-5  # measured: 4.8e-6, the slip between samples


@pytest.mark.parametrize("name", SCENES)
def test_an_explicit_march_loads_by_the_stiffness_of_the_pair(name):
    assert apart(*SCENES[name], "dg:7", cells=WAVES["dg:7"], time="explicit") < 5e-5


def test_a_standard_linear_slab_loads_relaxed():
    assert apart(*RELAXED, "fitted:2") < 1e-12
    assert max(apart(*RELAXED, model, cells=WAVES[model]) for model in ("fd", "dg:7")) < 5e-6  # measured: 2.4e-7


@pytest.mark.parametrize("name", ["alike", "unlike"])
def test_after_a_jump_the_delay_system_loads_alike(name):
    chosen, stiffness = SCENES[name]
    jump = dataclasses.replace(chosen, start=Start(StartKind.JUMP, 0.1), drive=PAPER.drive)
    assert apart(jump, stiffness, "delay") < 1e-11  # measured: 5e-13


@pytest.mark.parametrize("model", ["delay", "fitted:2"])
def test_the_drop_of_an_orbit_behind_faces_without_a_spring_is_that_of_a_run_wherever_its_period_begins(model):
    """The elastic stress rises there by a tenth of its drop in each cycle; in branches periods begin elsewhere than in orbits."""
    face = {"kind": "reflection", "coefficient": 0.95}
    scene = slipwave.read_scene("paper", slab={"log10_r": -2.45, "face": face}, run={"until": 4000})
    run, orbit = slipwave.run(scene, model).facts, slipwave.orbit(scene, model).facts
    point = slipwave.branch(scene, over=("V", 100.0, 100.5), model=model, most_points=1).facts["points"][0]
    assert orbit["elastic_stress_drop"] == pytest.approx(run["elastic_stress_drop"]["mean"], rel=1e-7)
    assert point["elastic_stress_drop"] == pytest.approx(orbit["elastic_stress_drop"], rel=1e-7)
