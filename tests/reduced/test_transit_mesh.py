"""Steps of the delay system with cuts at the drive's kinks: the mesh itself, and what it is for."""

import numpy as np
import pytest
from scipy.special import roots_jacobi

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from reduced.delay.alike import Delay
from reduced.delay.break_points import DelayBreaks
from reduced.delay.system import delay_system
from slipwave.observe import EventObserver
from slipwave.solve import follow
from slipwave.step.collocation import radau_nodes

ODD = ["drive.velocity=[[0.0, 100.0], [20.3, 100.0], [41.17, 200.0]]"]


@pytest.mark.parametrize("stages", range(2, 13))
def test_radau_nodes_are_the_roots_of_a_jacobi_polynomial(stages):
    nodes = radau_nodes(stages)
    assert nodes[-1] == 1.0
    assert np.abs(nodes[:-1] - 0.5 * (roots_jacobi(stages - 1, 1.0, 0.0)[0] + 1.0)).max() < 4e-16


def outputs(solver, until=120.0):
    events = EventObserver(solver.scene, solver.nodes)
    final = follow(solver, until, [events])
    return np.array([final.psi, events.events().period[-1], events.events().elastic_stress_drop[-1]])


def test_a_ramp_with_knots_anywhere_converges():
    """With steps across the kinks psi was off by 1.4e-6 at every tolerance."""
    ramp = slipwave.read("paper", ODD)
    best = outputs(Delay(ramp, tolerance=1e-12))
    for tolerance in (1e-8, 1e-10):
        assert outputs(Delay(ramp, tolerance=tolerance)) == pytest.approx(best, abs=30 * tolerance)
    assert outputs(DiscontinuousGalerkin(ramp, number=7, cells=40, time="explicit")) == pytest.approx(best, abs=3e-8)


@pytest.mark.parametrize("name", ["unlike", "grip"])
def test_a_ramp_of_other_slabs_is_followed_along_its_kinks(name):
    ramp = slipwave.read(name, ODD)
    solver = delay_system(ramp, tolerance=1e-9)
    assert isinstance(solver, DelayBreaks)
    final = follow(solver, 80.0)
    witness = follow(DiscontinuousGalerkin(ramp, number=7, cells=24, time="explicit"), 80.0)
    assert (final.psi, final.ln_v) == (pytest.approx(witness.psi, abs=3e-9), pytest.approx(witness.ln_v, abs=3e-9))
