"""The leapfrog below cfl 1 against discontinuous Galerkin: different bulk, different time stepping, different interface.

What they share is the scene, the friction law and the scalar interface solve.
"""

import dataclasses

import pytest

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_difference import Leapfrog
from slipwave.scene.slab import GripFace, KelvinVoigtViscosity, Layer, MachineFace, ReflectingFace, StandardLinearViscosity
from slipwave.solve import follow
from validation.measure.order_fit import extrapolated

PAPER = slipwave.read("paper")
ROUND_TRIP = PAPER.transit
SLABS = {
    "unlike": [{}, {"epsilon": 8.4e-5, "round_trip": 2**0.5 * ROUND_TRIP}],
    "layers-and-grip": [{"layers": (Layer(0.3, 1.0), Layer(0.7, 3.0)), "face": GripFace(2.0, 1.0)}],
    "grip-and-loss-below": [
        {},
        {
            "epsilon": 5.6e-5,
            "round_trip": 1.5 * ROUND_TRIP,
            "face": GripFace(2.0, 1.5),
            "viscosity": StandardLinearViscosity(0.5 * ROUND_TRIP, 0.7),
        },
    ],
    "machine-and-creep-below": [
        {},
        {"face": MachineFace(2.0, 0.5, 0.4), "viscosity": KelvinVoigtViscosity(0.02 * ROUND_TRIP)},
    ],
    "standard-linear": [{"viscosity": StandardLinearViscosity(3 * ROUND_TRIP, 0.5)}],
    "reflection": [{"face": ReflectingFace(0.5)}, {}],
}


@pytest.mark.parametrize("name", SLABS)
def test_two_discretisations_agree_to_ten_digits(name):
    upper, lower = (dataclasses.replace(PAPER.upper, **changes) for changes in (SLABS[name][0], SLABS[name][-1]))
    chosen = dataclasses.replace(PAPER, upper=upper, lower=lower)
    coarse, fine = (follow(Leapfrog(chosen, cells, 0.9), 60.0) for cells in (320, 640))
    witness = follow(DiscontinuousGalerkin(chosen, number=7, cells=8, time="explicit"), 60.0)
    for quantity in ("psi", "ln_v", "mu"):
        ours = extrapolated(getattr(coarse, quantity), getattr(fine, quantity), 2)
        assert ours == pytest.approx(getattr(witness, quantity), abs=2e-10), quantity
