"""Orbits of the semi-discrete full wave by Newton's method, on a ladder of grids, against those of the delay system."""

from functools import partial

import numpy as np
import pytest

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from reduced.delay.network import DelayNetwork
from reduced.orbit import periodic_orbit
from reduced.orbit.approach import approach
from reduced.orbit.closing import close
from reduced.orbit.figures import cycle_figures
from slipwave import read
from slipwave.observe import EventObserver
from slipwave.solve import follow
from validation.measure.order_fit import fit_order, shortfall
from validation.registry.build import build
from validation.registry.orbit_start import BEGIN, state_on
from validation.study.memo import own_orbit

PERIOD, DROP = 73.4721449443, 0.1739634131
"""At log10 r = -2.68, by lifted shooting; the period to 1e-10."""


def closed_orbit(solver):
    """The orbit of a grid, closed from a run."""
    guess = approach(solver, 1e-10)
    return close(*guess[:3])


@pytest.mark.parametrize(
    ("make", "grids", "order", "finest"),
    [
        (partial(SummationByParts, number=6), (16, 24, 32, 40), 6, 5.2e-8),
        (partial(FiniteElement, number=4), (4, 5, 6, 8), 8, 1.8e-9),
        (partial(DiscontinuousGalerkin, number=3), (4, 6, 8, 12), 7, 3.1e-7),
    ],
    ids=["sbp:6", "fem:4", "dg:3"],
)
def test_the_period_converges(make, grids, order, finest):
    """At the declared order P of differences; of elements at the order of what passes their faces, 2 P and 2 P + 1."""
    periods = [closed_orbit(make(read("paper"), cells=cells, time="exact")).cycle.period for cells in grids]
    errors = np.abs(np.array(periods) - PERIOD)
    assert shortfall(fit_order(np.array(grids), errors), order, tolerance=0.5, at_least=True) == ""
    assert errors[-1] < 3.0 * finest


def test_the_orbit_of_unlike_slabs_is_that_of_the_delay_system():
    """Whose round trips are 1 : 2. Measured: 1e-14 in the period, 2e-11 in v."""
    scene = read("unlike")
    guess = approach(DelayNetwork(scene, tolerance=1e-6), 1e-6)
    expected = periodic_orbit(*guess[:3], 1e-10)
    orbit = closed_orbit(DiscontinuousGalerkin(scene, number=7, cells=3, time="exact"))
    found = cycle_figures(scene.law, orbit.cycle, orbit.flow.nodes)
    for name, value in found.items():
        assert value == pytest.approx(getattr(expected.orbit, name).value, rel=1e-9), name
    values = np.linalg.eigvals(orbit.monodromy)
    for multiplier in expected.multipliers.values[:2]:
        assert np.abs(values - multiplier).min() < 1e-7
    assert abs(expected.multipliers.values[0]) == pytest.approx(0.87496, abs=1e-4)
    assert expected.multipliers.stable


@pytest.mark.parametrize("name", ["grip", "layered", pytest.param("unlike-irrational", marks=pytest.mark.slow)])
def test_orbits_of_other_scenes_are_those_of_the_delay_system(name):
    """Measured: 1e-13 in the period, 3e-10 in v_min of layered slabs, 5e-11 and less in the others."""
    exact, wave = (own_orbit(model, read(name), 1e-10, cells) for model, cells in (("delay", None), ("dg:7", 4)))
    assert wave.orbit.values() == pytest.approx(exact.orbit.values(), rel=1e-9)
    assert wave.orbit.period.value == pytest.approx(exact.orbit.period.value, rel=3e-12)
    assert exact.multipliers.stable is (None if name == "unlike-irrational" else True)


@pytest.mark.parametrize(
    ("model", "cells", "cfl", "within"), [("sbp:6", 24, 0.45, 1e-9), ("fem:4", 5, 0.45, 2e-10), ("dg:7", 3, 0.375, 2e-12)]
)
def test_the_explicit_march_goes_round_on_the_same_orbit(model, cells, cfl, within):
    """It shares no step with the flow. Measured in two cycles from the orbit's own state on: 6e-11, 1e-11 and 7e-14 of T, the
    error of Runge-Kutta steps of half the usual length."""
    scene = read("paper")
    closed = own_orbit(model, scene, 1e-10, cells).closed
    solver = build(model, scene, cells=cells, time="explicit", cfl=cfl)
    solver.restore(state_on(solver, closed))
    observer = EventObserver(scene, solver.nodes)
    follow(solver, BEGIN + 3.6 * closed.cycle.period, [observer])
    assert observer.events(BEGIN).period == pytest.approx([closed.cycle.period] * 2, rel=within)
