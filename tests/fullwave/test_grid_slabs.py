"""The tables of the exact march: breaks that steps end on, what is kept of them and what is forgotten, their threads, and the
refusals of step and of grid."""

from types import SimpleNamespace

import numpy as np
import pytest

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.lines import grid_slabs, march
from slipwave.errors import NumericsError, SceneError
from slipwave.solve import follow

FAR_RAMP = "drive.velocity=[[0.0, 100.0], [105.3, 100.0], [1211.17, 200.0]]"
PAPER = slipwave.read("paper")


@pytest.mark.parametrize("name", ["unlike", "unlike-irrational"])
def test_steps_end_on_breaks_far_apart_and_none_is_tiny(name):
    """The longest step between two breaks is no round number, and a break is a thousand steps away. Measured: at most 1e-13."""
    solver = DiscontinuousGalerkin(slipwave.read(name, [FAR_RAMP]), 5, 2, time="exact")
    ends, shortest = [], np.inf
    while solver.time < 1230.0:
        pieces = solver.advance(1230.0)
        ends.extend(pieces.time + pieces.length)
        shortest = min(shortest, pieces.length.min())
    travels = [0.5 * slab.round_trip / solver.scene.transit for slab in (solver.scene.upper, solver.scene.lower)]
    for arrival in (knot + delay for knot in (105.3, 1211.17) for delay in (0.0, *travels)):
        assert np.abs(np.array(ends) - arrival).min() < 2e-12
    assert shortest > 0.01


def test_a_motion_too_fast_for_every_step_is_refused(monkeypatch):
    monkeypatch.setattr(grid_slabs, "LEVELS", 3)
    solver = DiscontinuousGalerkin(slipwave.read("paper", ["start.kind=jump", "start.size=3.0"]), 3, 2, time="exact")
    with pytest.raises(
        NumericsError, match=r"^dg:3: no step is short enough at t = 0 transits, v = .*, psi = [-.\d]+ \(scene 'paper'"
    ):
        follow(solver, 1.0)


@pytest.mark.parametrize(("gallery", "about"), [("paper", 121), ("viscous", 60), ("unlike", 45), ("layered", 121)])
def test_the_advised_number_of_cells_fits(gallery, about, monkeypatch):
    monkeypatch.setattr(march, "ExactMarch", lambda *arguments: SimpleNamespace(nodes=None, bookkeeping=None))
    scene = slipwave.read(gallery)
    for asked in (10_000, about + about // 10):
        with pytest.raises(SceneError) as refusal:
            DiscontinuousGalerkin(scene, 7, asked, time="exact")
        advised = int(str(refusal.value).partition("at most some ")[2].split()[0])
        assert advised == pytest.approx(about, rel=0.12)
        DiscontinuousGalerkin(scene, 7, advised, time="exact")
