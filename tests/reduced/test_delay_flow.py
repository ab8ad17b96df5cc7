"""The delay system over one period as a differentiable map: its derivative, its motion against the solver's, its meshes."""

import dataclasses

import numpy as np
import pytest

from reduced.delay.flow import DelayFlow
from reduced.delay.network import DelayNetwork
from slipwave import read
from slipwave.friction import respond
from slipwave.observe import HistoryObserver
from slipwave.observe.history import values_at
from slipwave.observe.pieces import lagrange_basis
from slipwave.solve import follow
from tests.differences import difference

SCENES = {
    "alike": ("paper", []),
    "grip": ("grip", []),
    "machine": ("machine", []),
    "mass": ("machine", ["slab.face.stiffness=0.0"]),
    "reflection": ("reflection", []),
    "swallowing face": ("paper", ["slab.face={kind='reflection', coefficient=0.0}"]),
    "layered": ("layered", []),
    "three layers": (
        "paper",
        ["slab.layers=[{fraction=0.25, impedance=1.0}, {fraction=0.25, impedance=2.0}, {fraction=0.5, impedance=0.7}]"],
    ),
    "unlike": ("unlike", []),
    "irrational": ("unlike-irrational", []),
    "unlike with a grip": ("unlike", ["upper.face={kind='grip', stiffness=10.0, impedance=3.0}"]),
}
every_scene = pytest.mark.parametrize("kind", SCENES)


def settled(kind, per_transit=8.0, until=40.0):
    """The solver's run up to `until`, and a flow with the state that it has reached."""
    scene = read(*SCENES[kind])
    solver, flow = DelayNetwork(scene, tolerance=1e-11), DelayFlow(scene, per_transit)
    follow(solver, until)
    saved = solver.state()
    waves = np.roll(saved["waves"], -int(saved["counts"][2]), axis=2)
    rest = np.append(saved["tops"][flow.tops_remembered], saved["now"][1])
    return solver, flow, flow.sampled(waves, 1.0 / solver.steps, rest)


@every_scene
@pytest.mark.parametrize("period", [0.3, 3.37])
def test_tangent_is_the_derivative_of_the_march(kind, period):
    """Of every value of the end by every value of the start, within two steps and over many; velocities in units of 1/eps."""
    _, flow, start = settled(kind, per_transit=4.0, until=20.0)
    units = np.ones(flow.size)
    units[-2] = 1.0 / flow.scene.upper.epsilon if flow.tops_remembered[:, 1].any() else 1.0
    tangent = flow.tangent(flow.march(start, period))
    measured = difference(lambda change: flow.march(start + change * units, period).end, flow.size, 5e-6)
    np.testing.assert_allclose(tangent * units / units[:, None], measured / units[:, None], rtol=0.0, atol=5e-8)


@every_scene
@pytest.mark.parametrize("period", [0.3, 3.37])
def test_velocity_is_the_derivative_of_the_march_by_the_period(kind, period):
    _, flow, start = settled(kind, per_transit=4.0, until=20.0)
    cycle = flow.march(start, period)
    measured = difference(lambda change: flow.march(start, period + change[0]).end, 1, 1e-4)[:, 0]
    np.testing.assert_allclose(flow.velocity(cycle), measured, rtol=1e-7, atol=1e-8 * np.abs(measured).max())


@every_scene
def test_frozen_tangent_is_the_tangent_where_psi_has_no_effect(kind):
    """Along the same motion, with b = 0."""
    _, flow, start = settled(kind, per_transit=4.0, until=20.0)
    cycle = flow.march(start, 3.37)
    indifferent = flow.of(dataclasses.replace(flow.scene, law=flow.scene.law._replace(b=0.0)))
    frozen = flow.tangent(cycle, frozen=True)
    np.testing.assert_allclose(frozen[:-1, :-1], indifferent.tangent(cycle)[:-1, :-1], rtol=0.0, atol=1e-15)
    assert not frozen[-1].any()
    assert not frozen[:, -1].any()


def returned(flow, cycle):
    """rho = (F_v - eps/2)/(F_v + eps/2) at the nodes of `cycle`: what friction at fixed psi returns of a wave."""
    slopes = [respond(flow.scene.law, z, psi) for z, psi in zip(cycle.pieces.z.ravel(), cycle.pieces.psi.ravel(), strict=True)]
    friction = np.array([friction_z / v_z for _, v_z, _, friction_z, *_ in slopes]).reshape(cycle.pieces.z.shape)
    half = 0.5 * flow.scene.upper.epsilon
    return (friction - half) / (friction + half)


def test_every_wave_between_alike_slabs_is_multiplied_by_what_friction_returns():
    """Over whole transits a wave comes back to its node, times rho of each visit: first those on their way inwards."""
    _, flow, start = settled("alike", until=1600.0)
    cycle = flow.march(start, 9.0)
    factors = returned(flow, cycle).reshape(9, 2, flow.kept, -1).prod(axis=0)
    expected = np.r_[factors[1].ravel(), factors[0].ravel(), 0.0]
    np.testing.assert_allclose(flow.tangent(cycle, frozen=True), np.diag(expected), rtol=0.0, atol=1e-14)
    assert np.ptp(np.log(np.abs(expected[:-1]))) > 0.1


@every_scene
def test_steady_sliding_is_a_fixed_point(kind):
    flow = DelayFlow(read(*SCENES[kind]), 6.0)
    np.testing.assert_allclose(flow.march(flow.steady, 7.37).end, flow.steady, rtol=0.0, atol=1e-13)


def sampled(flow, cycle, times):
    return values_at(cycle.pieces, lagrange_basis(flow.nodes), times)


@every_scene
def test_the_march_goes_on_as_the_solver_does(kind):
    """From the waves of a run, read off its state, as the run itself. y is known up to a constant."""
    solver, flow, start = settled(kind)
    begin, times = solver.time, np.linspace(0.05, 7.37, 23)
    history = HistoryObserver(flow.scene.law, solver.nodes, start=begin)
    follow(solver, begin + 8.0, [history])
    cycle = flow.march(start, 7.37)
    *motion, elastic = sampled(flow, cycle, times)
    _, *wanted, loaded = history.at(begin + times)
    np.testing.assert_allclose(motion, wanted, rtol=0.0, atol=1e-12)
    assert np.ptp(elastic - loaded) < 1e-12
    assert np.ptp(motion[0]) > 0.1
    assert cycle.end[-1] == pytest.approx(history.at(begin + times[-1:])[2, 0], abs=1e-12)


def test_two_marches_in_turn_are_one():
    _, flow, start = settled("unlike", per_transit=12.0)
    halfway = flow.march(start, 3.37).end
    np.testing.assert_allclose(flow.march(halfway, 4.0).end, flow.march(start, 7.37).end, rtol=0.0, atol=1e-14)


@every_scene
def test_another_mesh_keeps_the_motion(kind):
    _, flow, start = settled(kind)
    cycle, times = flow.march(start, 7.37), np.linspace(0.05, 7.37, 23)
    finer, same = flow.remeshed(cycle, 1.5)
    assert finer.length < flow.length
    motion = sampled(finer, finer.march(same, 7.37), times)
    np.testing.assert_allclose(motion, sampled(flow, cycle, times), rtol=0.0, atol=5e-13)


@pytest.mark.parametrize("per_transit", [1.0, 7.3, 49.0])
@pytest.mark.parametrize("kind", ["alike", "unlike", "irrational"])
def test_a_mesh_that_was_stored_is_the_same_to_the_bit(kind, per_transit):
    flow = DelayFlow(read(*SCENES[kind]), per_transit)
    again = flow.on_mesh(flow.mesh_state())
    assert (again.length, again.kept, again.size) == (flow.length, flow.kept, flow.size)
    start = flow.steady + 1e-5 * np.cos(np.arange(flow.size))
    assert np.array_equal(again.march(start, 1.7).end, flow.march(start, 1.7).end)
