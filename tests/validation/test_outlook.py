"""What is expected of a scene before it is run, against what it then does."""

import math

import pytest

import slipwave
from reduced.stability import characteristic, leading_roots
from slipwave.observe import EventObserver
from slipwave.solve import follow
from tests.granite import GRANITE
from validation.registry.build import build
from validation.run.outlook import outlook, stress_released


@pytest.mark.parametrize("name", ["paper", "paper-2.3", "rock", "grip", "layered", "unlike-irrational"])
def test_the_period_is_expected_within_a_factor_of_two_and_a_half(name):
    scene = slipwave.read(name)
    solver = build("delay", scene, tolerance=1e-6)
    watch = EventObserver(scene, solver.nodes)
    follow(solver, 1500.0, [watch])
    period = float(watch.events(750.0).period.mean())
    assert 0.4 < outlook(scene, "delay").period / period < 2.5


def test_the_stress_that_an_event_of_granite_releases():
    """D = 2 w ln(1 + T v) with w = b - a = 0.005, T = D/(k V), v = D/(2 Z), by hand: k = epsilon/r = 3e-3 per L/V* (plain alike
    slabs, epsilon = 1.8e-6, r = 6e-4) and Z = epsilon/2."""
    found = stress_released(slipwave.read(GRANITE))
    assert found == pytest.approx(0.01 * math.log(1.0 + found / 3e-3 * found / 1.8e-6), rel=1e-9)
    assert found == pytest.approx(0.153, abs=0.001)
    assert outlook(slipwave.read(GRANITE), "delay").period == pytest.approx(found / 1.8e-6, rel=1e-9)


def test_near_the_onset_the_period_is_that_of_the_critical_frequency():
    """omega_c = V sqrt((b - a)/a), with b so close to a that hardly any stress is released."""
    scene = slipwave.read("paper", ["interface.b=0.035", "slab.r=1"])
    assert outlook(scene, "delay").period == pytest.approx(2.0 * math.pi / (100.0 * math.sqrt(1e-4 / 0.0349)), rel=1e-9)


def test_whether_steady_sliding_holds_and_how_fast_it_returns():
    thin = slipwave.read(GRANITE, ["slab.thickness=0.2"])
    found = outlook(thin, "delay")
    assert found.stable is True
    assert found.rate == pytest.approx(thin.transit * leading_roots(characteristic(thin, "delay"))[0].real, rel=1e-12)
    assert outlook(slipwave.read(GRANITE), "delay").stable is False
    strengthening = outlook(slipwave.read("paper", ["interface.b=0.01"]), "delay")
    assert strengthening.stable is True
    assert math.isfinite(strengthening.period)


def test_it_is_that_of_the_velocity_with_which_the_drive_ends():
    ramp = slipwave.read("paper", ["drive.velocity=[[0, 100], [10, 2000]]"])
    assert outlook(ramp, "delay") == outlook(slipwave.read("paper", ["drive.velocity=2000"]), "delay")
    hold = outlook(slipwave.read("paper", ["drive.velocity=[[0, 100], [10, 0]]"]), "delay")
    assert (hold.stable, hold.rate, hold.period) == (None, 0.0, math.inf)
