"""Outer faces in every model: limits that must coincide, no growth at the longest step, and a kind that no model knows."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

import slipwave
from fullwave.lines.matrix import motion_matrix
from fullwave.lines.runge_kutta import stability_polynomial
from slipwave.scene.slab import GripFace, MachineFace, Termination
from slipwave.solve import follow
from validation.models.build import build

PAPER = slipwave.read("paper")
SLAB = PAPER.upper
GRIDS = {"fd": 16, "sbp:4": 16, "fem:3": 3, "dg:4": 2}
SPRUNG = ("delay", "quasidynamic", "fitted:3", *GRIDS)
MACHINE = MachineFace(2.0, 0.5, 0.4)


def of(upper, lower=None, **changes):
    """The paper's scene with an outer face, the lower slab like the upper unless given."""
    slab = replace(SLAB, face=upper)
    return replace(PAPER, upper=slab, lower=lower or slab, **changes)


def end(model, scene):
    return follow(build(model, scene, cells=GRIDS.get(model)), 20.0)


def values(final):
    return final.ln_v, final.psi, final.mu


@pytest.mark.parametrize("model", ["delay", "fd", "sbp:4", "fem:3", "dg:4"])
@pytest.mark.parametrize(
    ("masses", "limit"),
    [((1e-2, 1e-3), GripFace(2.0, 0.5)), ((1e3, 1e4), MachineFace(0.0, math.inf, 1.0))],
    ids=["light", "heavy"],
)
def test_a_light_mass_is_no_mass_and_a_heavy_one_a_rigid_face(model, masses, limit):
    """At first order: the difference falls by ten as the mass, or its inverse, does. No drive changes, so what is heavy stays."""
    faces = (limit, *(MachineFace(2.0, 0.5, mass) for mass in masses))
    wanted, *found = (follow(build(model, of(face), cells=GRIDS.get(model)), 10.0).psi for face in faces)
    apart = np.array(found) - wanted
    assert apart[0] / apart[1] == pytest.approx(10.0, rel=0.15)
    assert abs(apart[1]) < 1e-3


@dataclass(frozen=True)
class Bolt:
    """A kind of outer face that no model knows: a stiff spring and a mass, both fixed."""

    def termination(self, epsilon, round_trip, outermost):
        return Termination(2.0 * epsilon / round_trip, 0.5 * epsilon, 0.4 * epsilon * round_trip)


@pytest.mark.parametrize("model", SPRUNG)
def test_every_model_takes_a_face_that_it_has_never_heard_of(model):
    assert values(end(model, of(Bolt()))) == values(end(model, of(MACHINE)))


@pytest.mark.parametrize("model", ["sbp:4", "fem:2", "dg:3"])
@pytest.mark.parametrize(
    "face", [MachineFace(2.0, 0.5, mass) for mass in (1e-3, 1e-2, 0.3, 10.0)] + [MachineFace(1e3, 0.0, 0.01)]
)
def test_no_mode_grows_at_the_longest_step(model, face):
    """The whole grid's spectrum, locked and free; the limit itself is found on a slab cut short."""
    solver = build(model, of(face), cells=24, cfl=1.0)
    amplification = np.polynomial.Polynomial(stability_polynomial(solver.method))
    for locked in (True, False):
        spectrum = np.linalg.eigvals(motion_matrix(solver.system, locked)).astype(complex)
        assert np.abs(amplification(solver.step * spectrum)).max() < 1.0 + 1e-9
