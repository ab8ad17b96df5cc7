"""The leapfrog against itself in equivalent forms and at its limits, its ledger, and its friction over one step: a known root is
found from any start, by Newton's method from a near one."""

from typing import NamedTuple

import numpy as np
import pytest
from grid_scenes import PAPER, SCENES, SLAB, of

from fullwave.finite_difference import Leapfrog
from fullwave.leapfrog import kernel
from fullwave.leapfrog.friction import solve_friction
from slipwave.compiled import njit
from slipwave.errors import NumericsError, SceneError
from slipwave.friction import LAWS, Law, respond, steady_state, unknown_of
from slipwave.solve import follow


def test_a_layer_thinner_than_a_cell_is_refused():
    scene = SCENES["layers"]
    with pytest.raises(SceneError, match="layer 1 is thinner than a cell; use at least 4"):
        Leapfrog(scene, cells=3)
    Leapfrog(scene, cells=4)


def test_one_slab_stands_for_two():
    together = of({}, {"epsilon": SLAB.epsilon * (1.0 + 4e-16)})
    assert not together.alike
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


LAW_NAMES = ("ageing", "slip", "ageing-regularised", "slip-regularised")


class Step(NamedTuple):
    """The data of a step, and its root."""

    law: Law
    impedance: float
    incoming: float
    old: float
    half: float
    push: float
    z: float
    psi: float
    v: float

    def solved(self, off):
        return solve_friction(*self[:6], self.z + off, self.psi - 0.5 * off)


def step(name, rate, half, lag=0.3, push=1e-3):
    """That ends at `rate` with psi above its steady value by `lag`."""
    law = LAWS[name].parameters(0.369, 0.0349, 0.0489)
    z, psi, impedance = unknown_of(law, rate), steady_state(law, rate) + lag, 1.4e-5
    v, _, mu, _, _, psi_rate, *_ = respond(law, z, psi)
    return Step(law, impedance, mu + impedance * v, psi - half * psi_rate - push, half, push, z, psi, v)


def steps(name):
    """With steps of up to a tenth of the time in which the state evolves."""
    return [step(name, rate, share / rate, lag) for rate in (1e-2, 1.0, 1e2, 1e4) for share in (1e-3, 0.1) for lag in (-0.5, 0.3)]


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("off", [0.0, 1e-3, 0.3, -0.3, 3.0, -3.0, 20.0, -20.0, 300.0, -300.0])
def test_the_root_is_found_from_anywhere(name, off):
    for one in steps(name):
        z, psi, v, converged = one.solved(off)
        assert converged
        assert (z, psi) == pytest.approx((one.z, one.psi), abs=2e-12)
        assert v == pytest.approx(one.v, rel=1e-11)


@njit
def extrapolated(memory, slot):
    """As the kernel compiles it."""
    return kernel._extrapolated(memory, slot)


def test_newtons_start_is_exact_for_a_quartic():
    memory = np.zeros(16)
    quartic = np.array([0.3, -1.0, 2.0, 0.5, 4.0])
    memory[6:11] = np.polyval(quartic, -np.arange(5.0))
    assert extrapolated(memory, 6) == pytest.approx(np.polyval(quartic, 1.0), rel=1e-12)
