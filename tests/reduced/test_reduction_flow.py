"""ODE reductions over one period as a differentiable map: its derivative against differences of the motion, the motion against
the run that it continues, and orbits against those of AUTO-07p."""

import dataclasses

import numpy as np
import pytest

import slipwave
from reduced.impedance import reduction_of
from reduced.impedance.reduction import Reduction
from reduced.ode.march import STAGES, ReducedModel
from reduced.ode.slabs import ReducedSlabs
from slipwave.errors import NumericsError
from slipwave.observe import EventObserver
from slipwave.solve import follow
from slipwave.step.port_flow import PortFlow
from tests.closing import closed, difference, largest

EVERY_TERM = Reduction(
    "made up",
    mass=0.02,
    damping=0.1,
    frequencies=(5.0, 9.0),
    residues=(1.5, 0.5),
    decays=(0.2, 0.7),
    offsets=(0.4, -0.3),
    relaxations=((0.3, 0.4), (0.2, 2.0)),
    spring=0.8,
)
STRONG = ["slab.epsilon=2e-3"]
"""Settings with which the motion of slabs acts on friction within a few transits."""

CASES = {
    "kelvin-voigt": ("paper", STRONG),
    "modal:2": ("unlike", []),
    "block12": ("paper", STRONG),
    "quasidynamic": ("paper", STRONG),
    "fitted:3": ("viscous", ["slab.epsilon=2e-3"]),
    "fitted:4": ("machine", []),
}


def solver_of(name):
    if name == "made up":
        return ReducedModel(slipwave.read("paper", STRONG), EVERY_TERM, 1e-11)
    scene = slipwave.read(*CASES[name])
    return ReducedModel(scene, reduction_of(scene, name), 1e-11)


def moving(name, period=5.0):
    """The flow over `period` and the state of a run, moved a little in every direction."""
    solver = solver_of(name)
    follow(solver, 9.0)
    flow, state = solver.flow(period, 1e-11)
    state = state + 1e-3 * np.sin(np.arange(1, state.size + 1))
    return flow.remeshed(flow.march(state, period), 1.0)


EVERY = [*CASES, "made up"]


@pytest.mark.parametrize("name", EVERY)
def test_the_tangent_is_the_derivative_of_the_march(name):
    flow, state = moving(name)
    found = flow.tangent(flow.march(state, 5.0))
    expected = difference(lambda change: flow.march(state + change, 5.0).end, flow.size)
    assert largest(found - expected) < 1e-7 * largest(expected)


@pytest.mark.parametrize("name", EVERY)
def test_the_frozen_tangent_holds_psi(name):
    """Where a transit is so short on the clock of friction that psi does not change within the period by itself."""
    flow, state = moving(name)
    assert not flow.frozen_tangent(flow.march(state, 5.0))[-1].any()
    scene, reduction = flow.scene, solver_of(name).reduction
    upper, lower = (dataclasses.replace(slab, round_trip=1e-14 * slab.round_trip) for slab in (scene.upper, scene.lower))
    response = ReducedSlabs(dataclasses.replace(scene, upper=upper, lower=lower), lambda _: reduction, STAGES)
    still = PortFlow(response, flow.mesh)
    found = still.frozen_tangent(still.march(state, 5.0))[:-1, :-1]
    expected = difference(lambda change: still.march(state + np.append(change, 0.0), 5.0).end[:-1], flow.size - 1)
    assert largest(found - expected) < 1e-7 * largest(expected)


@pytest.mark.parametrize("name", EVERY)
def test_the_flow_continues_the_run(name):
    """From the state of a run to that of the same run later. Steady sliding stays."""
    solver = solver_of(name)
    follow(solver, 20.0)
    begun, (flow, state) = solver.time, solver.flow(8.0, 1e-11)
    follow(solver, 28.0)
    period = solver.time - begun
    later = solver.flow(8.0, 1e-9)[1]
    assert largest((flow.march(state, period).end - later) / np.maximum(1.0, np.abs(later))) < 1e-8
    assert largest(flow.march(flow.steady, period).end - flow.steady) < 1e-12


@pytest.fixture(scope="module")
def settled():
    """The flow of a settled run over its period at log10 r = -2.68, its state and its period."""

    def of(name):
        scene = slipwave.read("paper")
        solver = ReducedModel(scene, reduction_of(scene, name))
        observer = EventObserver(scene, solver.nodes)
        follow(solver, 2000.0, [observer])
        period = float(observer.events(1000.0).period[-1])
        return *solver.flow(period, 1e-9), period

    return of


def test_a_finer_mesh_has_more_steps_and_a_smaller_error(settled):
    flow, state, period = settled("block12")
    coarse, state = flow.remeshed(flow.march(state, period), 0.2)
    first, _ = closed(coarse, state, period)
    fine, state = coarse.remeshed(first, 1.5)
    second, _ = closed(fine, state, first.period)
    assert second.pieces.time.size == pytest.approx(1.5 * first.pieces.time.size, rel=0.15)
    assert abs(second.period - 77.868569398) < 0.1 * abs(first.period - 77.868569398)
    assert fine.roughness(second, 1e-9) < 0.3 * coarse.roughness(first, 1e-9)
    assert second.pieces.time[-1] + second.pieces.length[-1] == pytest.approx(second.period, rel=1e-14)


def test_another_scene_has_the_same_mesh_and_states():
    """The flow of a run of the other scene does the same with the state."""
    flow, state = moving("kelvin-voigt")
    other = slipwave.read("paper", ["slab.epsilon=2.2e-3", "slab.log10_r=-2.5", "interface.a=0.037"])
    solver = ReducedModel(other, reduction_of(other, "kelvin-voigt"))
    direct = solver.flow(5.0, 1e-11)[0]
    direct, _ = direct.remeshed(direct.march(state, 5.0), 1.0)
    assert largest(flow.of(other).march(state, 5.0).end - direct.march(state, 5.0).end) < 1e-9
    assert flow.of(other).march(state, 5.0).pieces.length.size == flow.march(state, 5.0).pieces.length.size


def test_a_motion_that_cannot_be_followed():
    scene = slipwave.read("paper")
    solver = ReducedModel(scene, reduction_of(scene, "quasistatic"))
    follow(solver, 9.0)
    with pytest.raises(NumericsError, match=r"quasistatic: the step at .* of 5000 transits cannot be solved"):
        solver.flow(5000.0, 1e-9)
