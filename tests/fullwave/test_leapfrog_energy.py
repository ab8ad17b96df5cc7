"""The ledger closes to rounding in every scene, and catches a wrong coefficient."""

import pytest
from grid_scenes import SCENES

from fullwave.finite_difference import Leapfrog
from slipwave.solve import follow


@pytest.mark.parametrize("name", SCENES)
def test_ledger_closes_to_rounding(name):
    solver = Leapfrog(SCENES[name], 24, 0.9)
    follow(solver, 120.0)
    ledger = solver.energy()
    assert abs(ledger.residual) < 1e-12
    assert ledger.input > 0
    assert ledger.friction > 0
    assert (ledger.radiated > 0) == (
        name in ("grip", "stiff-grip", "machine", "hung-machine", "absorbing", "layers", "everything")
    )
    assert (ledger.viscous > 0) == (name in ("kelvin-voigt", "standard-linear", "hung-machine", "everything"))
    assert solver.failures == 0
