"""The delay system over one period as a differentiable map, and the vibrations in it that friction does not damp."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.optimize import brentq, newton

from reduced.delay.flow import DelayFlow
from reduced.delay.network import DelayNetwork
from reduced.orbit.closing import Closed
from reduced.orbit.multipliers import count_unstable, multipliers
from reduced.stability.idle import idle_modes
from slipwave import read, read_scene
from slipwave.friction import respond
from slipwave.observe import HistoryObserver
from slipwave.observe.history import values_at
from slipwave.observe.pieces import lagrange_basis
from slipwave.solve import follow
from slipwave.step.flow import eigenvalues_without
from slipwave.threads import one_thread
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
    return settled_in(read(*SCENES[kind]), per_transit, until)


def settled_in(scene, per_transit, until):
    """The solver's run up to `until`, and a flow with the state that it has reached."""
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


@pytest.fixture(autouse=True)
def small_matrices():
    with one_thread():
        yield


def unlike(ratio, **changes):
    """Slabs whose round trips have this ratio, the lower one with three times the impedance."""
    return read_scene("unlike", **{"upper.r": 0.00244, "lower.r": 0.00244 * ratio}, **changes)


@pytest.mark.parametrize(("ratio", "first"), [(1.0, (1, 1)), (3.0, (1, 3)), (5.0 / 3.0, (3, 5))])
def test_odd_ratios_have_modes_that_are_exactly_idle(ratio, first):
    """A slab of n quarter waves swings freely n/2 times in its own round trip."""
    modes = idle_modes(unlike(ratio))
    assert [(mode.upper, mode.lower) for mode in modes] == [(n * first[0], n * first[1]) for n in (1, 3, 5, 7)]
    for mode in modes:
        assert (mode.frequency, mode.decay) == (pytest.approx(0.5 * mode.upper, rel=1e-12), 0.0)
        assert mode.multiplier(65.3) == pytest.approx(np.exp(1j * math.pi * mode.upper * 65.3), abs=1e-10)


def test_layers_count_as_quarter_waves_too():
    """Two layers of one travel time: the lowest free vibration has tan^2(omega/4) = e_outer/e_inner, omega per round trip."""
    layers = [{"fraction": 0.5, "impedance": 1.0}, {"fraction": 0.5, "impedance": 2.0}]
    mode = idle_modes(unlike(1.0, **{"upper.layers": layers, "lower.layers": layers}))[0]
    assert (mode.upper, mode.lower, mode.decay) == (1, 1, 0.0)
    assert mode.frequency == pytest.approx(4.0 * math.atan(math.sqrt(2.0)) / (2.0 * math.pi), rel=1e-10)


def test_nearly_idle_modes_are_those_of_slabs_that_are_welded():
    """Welded slabs, v = 0, have X_1 + X_2 = 0; 0.0075 difference^3 was measured."""
    scene = read_scene("unlike-irrational")
    ratio, modes = scene.lower.round_trip / scene.upper.round_trip, idle_modes(scene)
    assert [(mode.upper, mode.lower) for mode in modes] == [(5, 7), (29, 41), (169, 239)]
    for mode in modes:
        free = sorted((math.pi * mode.upper, math.pi * mode.lower / ratio))
        welded = brentq(lambda w: 1.0 / math.tan(0.5 * w) + 3.0 / math.tan(0.5 * w * ratio), *free, xtol=1e-14)
        assert 2.0 * math.pi * mode.frequency == pytest.approx(welded, abs=0.05 * (free[1] - free[0]) ** 3)


def test_friction_damps_nearly_idle_modes_as_it_damps_steady_sliding_with_psi_held():
    """Roots of 1 + (a/V) (1/Z_1 + 1/Z_2) = 0, Z = e coth(s T/2); the decays are theirs but for 0.044 difference^2, measured."""
    scene = read_scene("unlike-irrational")
    ratio, friction = scene.lower.round_trip / scene.upper.round_trip, scene.law.a / scene.velocity

    def characteristic(s):
        upper, lower = scene.upper.epsilon / np.tanh(0.5 * s), scene.lower.epsilon / np.tanh(0.5 * s * ratio)
        return upper * lower / friction + upper + lower

    for mode in idle_modes(scene):
        root = newton(characteristic, 2j * math.pi * mode.frequency - mode.decay, tol=1e-15, maxiter=100)
        apart = math.pi * (mode.upper - mode.lower / ratio)
        assert mode.decay == pytest.approx(-root.real, rel=0.2 * apart**2)


def steady(flow, period):
    cycle = flow.march(flow.steady, period)
    return Closed(flow, cycle, 0.0, flow.tangent(cycle), np.zeros(flow.size), np.empty(0), 0.0, 0)


HALVED = {"upper.layers": [{"fraction": 0.5, "impedance": 1.0}] * 2}


@pytest.mark.parametrize(("ratio", "changes"), [(3.0, {}), (1.0, HALVED)])
def test_idle_states_keep_their_multipliers_in_any_motion(ratio, changes):
    """All states with f(t + 1) = -f(t) of the smallest unit of time; 3.25 units turn them by exp(3.25 i omega)."""
    flow = DelayFlow(unlike(ratio, **changes), 4.0)
    closed = steady(flow, 3.25)
    states, monodromy = flow.idle, closed.monodromy
    inside = states.T @ monodromy @ states
    assert states.shape[1] == 4 * 8  # steps of a unit, nodes
    np.testing.assert_allclose(monodromy @ states, states @ inside, rtol=0.0, atol=1e-13)
    values = np.linalg.eigvals(inside)
    for mode in idle_modes(flow.scene)[:2]:
        assert np.abs(values - mode.multiplier(3.25)).min() < 1e-9
    every, rest = np.linalg.eigvals(monodromy), eigenvalues_without(monodromy, states)
    assert np.sort(np.abs(rest))[-3:] == pytest.approx(np.sort([abs(v) for v in every if np.abs(values - v).min() > 1e-7])[-3:])


@pytest.mark.parametrize(("ratio", "count"), [(2.0, 0), (1.5, 0), (5.0 / 3.0, 16)])
def test_only_odd_ratios_have_idle_states(ratio, count):
    """With 5/3 a unit of time is a third of a transit, and has two steps."""
    assert DelayFlow(unlike(ratio), 4.0).idle.shape[1] == count


def test_what_grows_beside_idle_modes_is_unstable():
    closed = steady(DelayFlow(unlike(3.0), 4.0), 40.3)
    found = multipliers(closed)
    assert found.stable is False
    assert "but a multiplier outside of it decides" in found.reason
    assert found.essential_radius == 1.0
    assert np.abs(np.linalg.eigvals(closed.monodromy)).max() > 1.0
    assert count_unstable(closed) == (np.abs(found.values) > 1.0).sum()
    assert "1 and 3 quarter waves, 0.5 cycles a transit, multiplier" in found.reason
    assert [mode.upper for mode in found.idle] == [1, 3, 5, 7]


@pytest.mark.parametrize("side", ["upper", "lower"])
@pytest.mark.parametrize("coefficient", [0.999, 0.9997, 0.9998, 0.9999, 0.99989])
def test_behind_a_face_that_leaks_nothing_is_idle(coefficient, side):
    """What both slabs do alike passes the leaking face once in two transits: it is left with R^(T/2) after T."""
    alike = {"upper.epsilon": 2.8e-5, "upper.r": 0.0021, "lower.epsilon": 2.8e-5, "lower.r": 0.0021}
    face = {f"{side}.face": {"kind": "reflection", "coefficient": coefficient}}
    closed = steady(DelayFlow(read_scene("unlike", **alike, **face), 6.0), 73.4)
    found = multipliers(closed)
    assert found.essential_radius == pytest.approx(coefficient**36.7, rel=1e-6)
    assert not found.idle


LEAKS = {"kind": "reflection", "coefficient": 0.9999}
LAYERS = [{"fraction": 0.25, "impedance": 1.0}, {"fraction": 0.75, "impedance": 1.32}]


@pytest.mark.parametrize(
    "scene",
    [
        unlike(1.0, **{"upper.layers": LAYERS, "lower.layers": LAYERS, "upper.face": LEAKS}),
        unlike(1.0, **{"lower.face": LEAKS}),
        unlike(math.sqrt(2.0), **{"upper.face": LEAKS}),
        unlike(1.5),
    ],
)
@pytest.mark.parametrize("period", [30.013, 60.87, 73.4])
def test_no_period_gains_energy_while_friction_holds_its_state(scene, period):
    """Slabs, faces and friction at a given state are passive: no multiplier of the waves alone lies outside the unit circle."""
    flow = DelayFlow(scene, 6.0)
    waves = flow.tangent(flow.march(flow.steady, period), frozen=True)
    assert np.abs(np.linalg.eigvals(waves[:-1, :-1])).max() < 1.0 + 1e-12


@pytest.mark.parametrize("ratio", [0.1, 1.3, 1.9, 2.1, 3.7])
def test_a_state_has_as_many_values_where_one_slab_alone_changes(ratio):
    """In steps that are short enough for both scenes, on a mesh that a file may keep."""
    flow = DelayFlow(unlike(2.0), 4.0)
    loose, start = flow.loosened(flow.steady, [unlike(ratio)])
    there = loose.of(unlike(ratio))
    assert start.size == loose.size == there.size == there.on_mesh(there.mesh_state()).size
    assert there.march(there.steady, 3.0).end == pytest.approx(there.steady, abs=1e-12)


@pytest.mark.parametrize("finer", [1.1, 1.25, 1.5, 1.6, 2.5])
def test_more_waves_than_were_kept_go_on_smoothly(finer):
    """Steps of a sixth of a transit end with the longer delay, others do not, and keep more; before, waves were constant."""
    _, flow, start = settled_in(unlike(0.8635), 6.0, 40.0)
    cycle, times = flow.march(start, 7.37), np.linspace(0.05, 7.37, 23)
    new, same = flow.remeshed(cycle, finer)
    assert flow.kept * flow.length == pytest.approx(0.5, rel=1e-12)
    assert new.kept * new.length > 0.5 + 1e-3
    motion = sampled(new, new.march(same, 7.37), times)
    np.testing.assert_allclose(motion, sampled(flow, cycle, times), rtol=0.0, atol=1e-12)
