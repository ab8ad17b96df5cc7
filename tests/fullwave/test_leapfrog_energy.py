"""The ledger closes to rounding in every scene, and catches a wrong coefficient."""

import pytest
from leapfrog_scenes import SCENES

from fullwave.finite_difference import Leapfrog
from fullwave.leapfrog.viscous import steady_side
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


def test_ledger_sees_a_wrong_stiffness(monkeypatch):
    def wrong(scene, slab, grid):
        side = steady_side(scene, slab, grid)
        return side._replace(medium=side.medium._replace(stiffness=1.001 * side.medium.stiffness))

    monkeypatch.setattr("fullwave.finite_difference.steady_side", wrong)
    solver = Leapfrog(SCENES["alike"], 24, 0.9)
    follow(solver, 120.0)
    assert abs(solver.energy().residual) > 1e-7
