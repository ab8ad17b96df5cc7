"""Scenes and solvers that between them reach every branch of the leapfrog's kernel and of the explicit march of lines."""

import dataclasses
from functools import partial

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from slipwave.scene.drive import Drive
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, MachineFace, ReflectingFace, StandardLinearViscosity

PAPER = slipwave.read("paper")
SLAB = PAPER.upper
ROUND_TRIP = SLAB.round_trip
STEEPER = Drive((0.0, 20.0, 40.0), (100.0, 100.0, 200.0))


def of(upper=None, lower=None, **changes):
    """The paper's scene with slabs changed; the lower like the upper unless given."""
    upper = SLAB if upper is None else dataclasses.replace(SLAB, **upper)
    lower = upper if lower is None else dataclasses.replace(SLAB, **lower)
    return dataclasses.replace(PAPER, upper=upper, lower=lower, **changes)


TWO_LAYERS = (Layer(0.3, 1.0), Layer(0.7, 3.0))
SCENES = {
    "alike": PAPER,
    "unlike": of({}, {"epsilon": 3 * SLAB.epsilon, "round_trip": ROUND_TRIP * 2**0.5}),
    "grip": of({"face": GripFace(2.0, 1.0)}),
    "stiff-grip": of({"face": GripFace(1e4, 1e3)}),
    "machine": of({"face": MachineFace(2.0, 0.5, 0.4)}),
    "hung-machine": of({"face": MachineFace(0.0, 1.0, 0.05), "viscosity": StandardLinearViscosity(3.0 * ROUND_TRIP, 0.5)}, {}),
    "absorbing": of({"face": ReflectingFace(0.0)}),
    "free-above": of({"face": ReflectingFace(-1.0)}, {}),
    "layers": of({"layers": TWO_LAYERS, "face": GripFace(2.0, 1.0)}),
    "kelvin-voigt": of({"viscosity": KelvinVoigtViscosity(0.02 * ROUND_TRIP)}),
    "standard-linear": of({"viscosity": StandardLinearViscosity(3.0 * ROUND_TRIP, 0.5)}),
    "everything": of(
        {"face": GripFace(2.0, 1.0), "viscosity": KelvinVoigtViscosity(0.02 * ROUND_TRIP)}, {"layers": TWO_LAYERS}, drive=STEEPER
    ),
}

FAMILIES = {
    "dg:5": partial(DiscontinuousGalerkin, number=5, cells=3, time="explicit"),
    "fem:4": partial(FiniteElement, number=4, cells=4, time="explicit"),
    "sbp:6": partial(SummationByParts, number=6, cells=16, time="explicit"),
}
PAIRS = [(family, scene) for family in FAMILIES for scene in SCENES]
