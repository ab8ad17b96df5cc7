"""Grids over one period as a differentiable map: its derivative against differences of the motion, the motion against the run
that it continues, and the full wave's own orbit against that of the delay system."""

import numpy as np
import pytest

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from slipwave.solve import follow
from tests.closing import difference, largest

STRONG = ["slab.epsilon=2e-3"]
"""Settings with which the motion of slabs acts on friction within a few transits."""

SCENES = {
    "alike": ("paper", STRONG),
    "unlike": ("unlike", []),
    "kelvin-voigt": ("viscous", STRONG),
    "standard linear": ("paper", [*STRONG, 'slab.viscosity={kind="standard-linear", time=0.002, ratio=0.5}']),
    "machine": ("machine", []),
    "layered": ("layered", []),
}


def moving(name, period=4.0):
    """The flow over `period` and the state of a run, moved a little in every direction."""
    solver = DiscontinuousGalerkin(slipwave.read(*SCENES[name]), number=7, cells=2, time="exact")
    follow(solver, 20.0)
    flow, state = solver.flow(period, 1e-10)
    state = state + 1e-4 * np.sin(np.arange(1, state.size + 1))
    return flow.remeshed(flow.march(flow.steady, period)._replace(start=state), 1.0)


@pytest.mark.parametrize("name", SCENES)
def test_the_tangent_is_the_derivative_of_the_march(name):
    flow, state = moving(name)
    found = flow.tangent(flow.march(state, 4.0))
    expected = difference(lambda change: flow.march(state + change, 4.0).end, flow.size)
    assert largest(found - expected) < 1e-7 * largest(expected)
    frozen_psi = flow.frozen_tangent(flow.march(state, 4.0))
    assert not frozen_psi[-1].any()
    assert largest(frozen_psi[:-1, -1]) == 0.0


MEMBERS = {
    "dg:5": lambda scene: DiscontinuousGalerkin(scene, number=5, cells=3, time="exact", resolution=1e-11),
    "sbp:4": lambda scene: SummationByParts(scene, number=4, cells=12, time="exact", resolution=1e-11),
    "fem:4": lambda scene: FiniteElement(scene, number=4, cells=3, time="exact", resolution=1e-11),
}


@pytest.mark.parametrize("member", MEMBERS)
@pytest.mark.parametrize("name", ["alike", "unlike", "kelvin-voigt"])
def test_the_flow_continues_the_run(member, name):
    """From the state of a run to that of the same run later. Steady sliding stays."""
    solver = MEMBERS[member](slipwave.read(*SCENES[name]))
    follow(solver, 20.0)
    begun, (flow, state) = solver.time, solver.flow(8.0, 1e-11)
    follow(solver, 28.0)
    period, later = solver.time - begun, solver.flow(8.0, 1e-9)[1]
    assert largest(flow.march(state, period).end - later) < 1e-8
    assert largest(flow.march(flow.steady, period).end - flow.steady) < 1e-12


def test_another_scene_has_the_same_mesh_and_states():
    """A state is in units of stress, so that it is the same for another impedance."""
    flow, state = moving("alike")
    other = slipwave.read("paper", ["slab.epsilon=2.2e-3", "slab.log10_r=-2.6", "interface.a=0.036"])
    direct = DiscontinuousGalerkin(other, number=7, cells=2, time="exact").flow(4.0, 1e-11)[0]
    direct, _ = direct.remeshed(direct.march(direct.steady, 4.0)._replace(start=state), 1.0)
    assert largest(flow.of(other).march(state, 4.0).end - direct.march(state, 4.0).end) < 1e-9
