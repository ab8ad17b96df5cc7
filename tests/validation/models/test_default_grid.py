"""The error told for a grid that is chosen: that of the march that ran, on drives that change too."""

import numpy as np
import pytest

import slipwave
import slipwave as sw
from fullwave.adapt import difference_of, probe
from slipwave.solve import follow
from validation.models.build import build, prepare
from validation.models.cycle import watch

SCENE = sw.read("paper", {"drive.velocity": 2000, "run.until": 9.0})
"""Too short for cycles, so that the state at its end is compared."""


@pytest.mark.parametrize(
    ("model", "options"),
    [
        ("fd", {}),
        ("fd", {"cfl": 0.5}),
        ("dg:3", {}),
        ("dg:3", {"time": "explicit"}),
        ("dg:3", {"time": "exact"}),
        ("sbp:4", {"cfl": 0.4, "time": "explicit"}),
    ],
)
def test_the_estimate_is_that_of_the_march_that_ran(model, options):
    grid = sw.run(SCENE, model, **options).summary["grid"]
    fine = build(model, SCENE, **options)
    assert (grid["cells"], grid["step"]) == (fine.cells, fine.step)  # type: ignore[attr-defined]
    fewer = build(model, SCENE, cells=int(grid["cells"] / 1.5), **options)
    ends = [follow(solver, 9.0) for solver in (fine, fewer)]
    now, before = (np.array([end.ln_v, end.psi]) for end in ends)
    assert grid["quantity"] == "final state"
    assert grid["error_estimate"] == pytest.approx(1.5 * np.abs((now - before) / now).max(), rel=1e-6, abs=2e-11)


def test_a_grid_that_cannot_be_coarser_is_judged_by_a_finer_one():
    """Layers of 16 cells, the fewest of `sbp:6`, are the same with fewer cells asked for: that difference is none."""
    layers = [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": 1.5}]
    layered = sw.read("paper", {"drive.velocity": 2000, "run.until": 15.0, "slab.layers": layers})
    grid = sw.run(layered, "sbp:6").summary["grid"]
    error = difference_of(probe(build("sbp:6", layered, cells=128)), probe(build("sbp:6", layered)))
    assert grid["quantity"] == "cycles"
    assert 1e-8 < error < grid["error_estimate"] < 5.0 * error


STEEP = "drive.velocity=[[0.0,100.0],[120.0,100.0],[123.0,1000.0]]"


def cycles(solver, until):
    found = watch(solver, until).events()
    return np.concatenate((found.period, found.stress_drop))


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, pytest.param(1e-6, marks=pytest.mark.slow)])
def test_a_ramp_beyond_the_probe_of_a_constant_drive_is_seen(monkeypatch, tolerance):
    """Three cells are enough up to the ramp, whatever the tolerance; they err by 5e-6 after it."""
    monkeypatch.setattr("fullwave.adapt.PROBE", 110.0)
    chosen = slipwave.read("paper", [STEEP, "run.until=200"])
    exact = cycles(build("delay", chosen, tolerance=1e-12), chosen.until)
    built = prepare("dg", chosen, tolerance=tolerance)
    assert built.choice is not None
    error, estimate = float(np.abs(cycles(built.solver, chosen.until) / exact - 1.0).max()), built.choice.error_estimate
    assert error <= 2.0 * estimate
    assert error <= tolerance
    assert estimate <= tolerance
