"""The error told for a default grid: that of the march that ran, against the same march on two thirds of the cells."""

import numpy as np
import pytest

import slipwave as sw
from fullwave.adapt import difference_of, probe
from slipwave.solve import follow
from validation.registry.build import build

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
