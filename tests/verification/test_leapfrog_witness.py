"""The leapfrog below cfl 1 against discontinuous Galerkin: different bulk, different time stepping, different interface.

What they share is the scene, the friction law and the scalar interface solve.
"""

import pytest

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_difference import Leapfrog
from slipwave.scene.slab import GripFace, StandardLinearViscosity
from slipwave.solve import follow
from tests.fullwave.grid_scenes import ROUND_TRIP, SCENES, of
from validation.measure.order_fit import extrapolated

LOSSY = {
    "epsilon": 5.6e-5,
    "round_trip": 1.5 * ROUND_TRIP,
    "face": GripFace(2.0, 1.5),
    "viscosity": StandardLinearViscosity(0.5 * ROUND_TRIP, 0.7),
}
SOME = ("unlike", "layers", "machine", "hung-machine", "kelvin-voigt", "standard-linear", "absorbing")
CASES = {name: SCENES[name] for name in SOME} | {"grip-and-loss-below": of({}, LOSSY)}


@pytest.mark.parametrize("name", CASES)
def test_two_discretisations_agree_to_ten_digits(name):
    coarse, fine = (follow(Leapfrog(CASES[name], cells, 0.9), 60.0) for cells in (320, 640))
    witness = follow(DiscontinuousGalerkin(CASES[name], number=7, cells=8, time="explicit"), 60.0)
    for quantity in ("psi", "ln_v", "mu"):
        ours = extrapolated(getattr(coarse, quantity), getattr(fine, quantity), 2)
        assert ours == pytest.approx(getattr(witness, quantity), abs=2e-10), quantity
