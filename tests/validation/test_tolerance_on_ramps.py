"""A full wave's own choice of grid on drives that change: the error of the whole run against the delay system."""

import numpy as np
import pytest

import slipwave
from slipwave.observe import EventObserver
from slipwave.solve import follow
from validation.registry.build import build, prepare

STEEP = "drive.velocity=[[0.0,100.0],[120.0,100.0],[123.0,1000.0]]"
LATE = "drive.velocity=[[0.0,100.0],[500.0,100.0],[510.0,1000.0]]"

SLOW = "drive.velocity=[[0.0,100.0],[450.0,100.0],[550.0,200.0]]"


def cycles(solver, until):
    watch = EventObserver(solver.scene, solver.nodes)
    follow(solver, until, [watch])
    return np.concatenate((watch.events().period, watch.events().stress_drop))


def error_and_estimate(chosen, tolerance):
    exact = cycles(build("delay", chosen, tolerance=1e-12), chosen.until)
    built = prepare("dg", chosen, tolerance=tolerance)
    assert built.choice is not None
    return float(np.abs(cycles(built.solver, chosen.until) / exact - 1.0).max()), built.choice.error_estimate


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, pytest.param(1e-6, marks=pytest.mark.slow)])
def test_a_ramp_beyond_the_probe_of_a_constant_drive_is_seen(monkeypatch, tolerance):
    """Three cells are enough up to the ramp, whatever the tolerance; they err by 5e-6 after it."""
    monkeypatch.setattr("fullwave.adapt.PROBE", 110.0)
    error, estimate = error_and_estimate(slipwave.read("paper", [STEEP, "run.until=200"]), tolerance)
    assert error <= 2.0 * estimate
    assert error <= tolerance
    assert estimate <= tolerance


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "settings", "tolerance"),
    [("paper", [LATE, "run.until=650"], 1e-7), ("paper", [LATE, "run.until=650"], 1e-8), ("ramp", [SLOW, "run.until=700"], 1e-9)],
)
def test_ramps_of_long_runs(name, settings, tolerance):
    error, estimate = error_and_estimate(slipwave.read(name, settings), tolerance)
    assert error <= 2.0 * estimate
    assert error <= tolerance
