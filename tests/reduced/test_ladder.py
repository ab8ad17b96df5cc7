"""The ladder of ODE reductions against independent values, an independent integrator, and runs that must fail clearly."""

import pytest

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
        ("kelvin-voigt", -2.60, 78.904160018, 1e-9),
        ("block8", -2.50, 109.43283211, 2e-9),
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


def test_quasistatic_runs_away_and_says_so():
    with pytest.raises(NumericsError, match=r"quasistatic: no step is short enough at t = .*runs away"):
        follow(ReducedModel(read("paper", ["slab.log10_r=-2.5"]), reduction("quasistatic")), 6000)
