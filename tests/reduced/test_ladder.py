"""The ladder of ODE reductions against independent values, an independent integrator, and runs that must fail clearly."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from reduced.impedance.reduction import reduction
from reduced.ode.march import ReducedModel
from slipwave import read
from slipwave.errors import NumericsError
from slipwave.observe import EventObserver, summarise
from slipwave.solve import follow


def cycle(model, log10_r=-2.68, tolerance=1e-10, until=6000):
    scene = read("paper", [f"slab.log10_r={log10_r}"])
    solver = ReducedModel(scene, reduction(model), tolerance=tolerance)
    observer = EventObserver(scene, solver.nodes)
    follow(solver, until, [observer])
    assert solver.failures == 0
    return summarise(observer.events(0.8 * until))


@pytest.mark.parametrize(
    ("model", "log10_r", "period", "relative"),
    [
        ("kelvin-voigt", -2.68, 70.732344990, 1e-9),
        ("kelvin-voigt", -2.60, 78.904160018, 1e-9),
        ("block8", -2.68, 76.610299635, 2e-9),
        ("block8", -2.50, 109.43283211, 2e-9),
        ("block12", -2.68, 77.868569398, 2e-9),
        ("block12", -2.50, 111.39298540, 2e-9),
        ("modal:1", -2.68, 73.5148, 1e-6),
        ("modal:2", -2.68, 73.4717, 1e-6),
        ("modal:8", -2.68, 73.4721, 1e-6),
    ],
)
def test_period_of_the_independent_programs(model, log10_r, period, relative):
    assert cycle(model, log10_r).period.mean == pytest.approx(period, rel=relative)


def test_figures_of_the_kelvin_voigt_orbit():
    found = cycle("kelvin-voigt")
    assert found.stress_drop.mean == pytest.approx(0.167306295, rel=1e-8)
    assert found.elastic_stress_drop.mean == pytest.approx(0.144893007, rel=1e-8)
    assert found.v_max == pytest.approx(3448.5993, rel=1e-7)
    assert found.v_min == pytest.approx(3.3360505, rel=1e-7)


def test_kelvin_voigt_follows_the_paper_s_own_form_of_the_equations():
    """(41) integrated by scipy in the variables y, mu, w, v, psi: another form, another integrator."""
    scene = read("paper", ["slab.log10_r=-2.6"])
    r, epsilon, v0 = scene.transit, scene.upper.epsilon, scene.velocity
    a, b = scene.law.a, scene.law.b

    def rate(t, x):
        y, mu, w, ln_v, psi = x
        v = np.exp(ln_v)
        psi_rate = r * (np.exp(-psi) - v) + 0.5 * np.exp(-((t - 6.0) ** 2))
        v_rate = v / a * (w - b * psi_rate)
        return [epsilon * (v0 - v), w, 24 * (y - mu) - 3 * epsilon * v_rate, v_rate / v, psi_rate]

    start = [scene.steady_stress, scene.steady_stress, 0.0, np.log(v0), scene.steady_psi]
    witness = solve_ivp(rate, (0, 150), start, method="Radau", rtol=1e-9, atol=1e-11).y[:, -1]
    final = follow(ReducedModel(scene, reduction("kelvin-voigt"), tolerance=1e-10), 150)
    assert final.psi == pytest.approx(witness[4], abs=2e-6)
    assert final.mu == pytest.approx(witness[1], abs=2e-7)


def test_modal_0_is_the_block_of_mass_a_twelfth():
    assert cycle("modal:0", until=2000).period.mean == cycle("block12", until=2000).period.mean


def test_quasistatic_runs_away_and_says_so():
    with pytest.raises(NumericsError, match=r"quasistatic: no step is short enough at t = .*runs away"):
        follow(ReducedModel(read("paper", ["slab.log10_r=-2.5"]), reduction("quasistatic")), 6000)


def test_jump_start_is_taken():
    scene = read("paper", ['start.kind="jump"', "start.size=0.05"])
    final = follow(ReducedModel(scene, reduction("kelvin-voigt")), 30.0)
    tighter = follow(ReducedModel(scene, reduction("kelvin-voigt"), tolerance=1e-12), 30.0)
    assert final.psi == pytest.approx(tighter.psi, abs=1e-9)
