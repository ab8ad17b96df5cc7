"""The leapfrog against itself in equivalent forms and at its limits, and its ledger."""

import pytest
from grid_scenes import PAPER, SCENES, SLAB, of

from fullwave.finite_difference import Leapfrog
from slipwave.errors import NumericsError, SceneError
from slipwave.solve import follow


def test_a_layer_thinner_than_a_cell_is_refused():
    scene = SCENES["layers"]
    with pytest.raises(SceneError, match="layer 1 is thinner than a cell; use at least 4"):
        Leapfrog(scene, cells=3)
    Leapfrog(scene, cells=4)


def test_one_slab_stands_for_two():
    together = of({}, {"round_trip": SLAB.round_trip * (1.0 + 4e-16)})
    assert together.equivalent is None
    one, two = Leapfrog(PAPER, 32, 0.9), Leapfrog(together, 32, 0.9)
    assert two.total_cells == 2 * one.total_cells
    finals = [follow(solver, 150.0) for solver in (one, two)]
    assert finals[0].ln_v == pytest.approx(finals[1].ln_v, abs=1e-8)
    assert one.energy().input == pytest.approx(two.energy().input, rel=1e-10)


def test_numbers_without_bound_end_the_run_with_the_time():
    solver = Leapfrog(PAPER, 16)
    follow(solver, 5.0)
    state = solver.state()
    state["upper.stress"][3] = 1e308
    solver.restore(state)
    with pytest.raises(NumericsError, match=r"stopped being finite between t = 5"):
        follow(solver, 10.0)


def test_too_coarse_a_step_ends_the_run():
    """A round trip of many state relaxations: eight cells cannot follow psi through an event, 512 can."""
    scene = of({"epsilon": 1e-3, "round_trip": 1.0})
    with pytest.raises(NumericsError, match=r"did not converge by t = .*, the first at t = "):
        follow(Leapfrog(scene, 8), 100.0)
    solver = Leapfrog(scene, 512)
    follow(solver, 100.0)
    assert solver.failures == 0


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
