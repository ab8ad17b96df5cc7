"""The delay system of unlike, gripped, reflecting and layered slabs: against the alike march, itself, and exact echoes."""

import numpy as np
import pytest

from fullwave.discontinuous import DiscontinuousGalerkin
from reduced.commensurate import common_divisor
from reduced.delay.alike import Delay
from reduced.delay.break_points import DelayBreaks
from reduced.delay.network import DelayNetwork
from reduced.delay.system import delay_system
from reduced.delay.transmission_lines import delay_rows
from slipwave import read
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import EventObserver, summarise
from slipwave.solve import follow
from slipwave.step.collocation import radau
from slipwave.step.nodal import NOT_SMOOTH

ARRANGEMENTS = ("unlike", "unlike-irrational", "grip", "reflection", "layered", "ramp")


def test_network_of_alike_slabs_equals_the_alike_march():
    scene = read("paper", ["slab.log10_r=-2.6"])
    assert follow(DelayNetwork(scene), 600).psi == pytest.approx(follow(Delay(scene), 600).psi, abs=3e-9)


def test_alike_slabs_written_twice_take_the_same_course():
    """Upper and lower slab marched apart (a lower round trip longer by one part in 1e15 makes them unlike)."""
    keys = ["lower.epsilon=2.8e-5", f"lower.r={10**-2.6 * (1 + 4e-16)!r}", f"upper.r={10**-2.6!r}", "upper.epsilon=2.8e-5"]
    twice = follow(DelayNetwork(read("paper", keys)), 200).psi
    assert twice == pytest.approx(follow(Delay(read("paper", ["slab.log10_r=-2.6"])), 200).psi, abs=1e-10)


def halve(solver, times):
    for _ in range(times):
        solver._refine(NOT_SMOOTH)


@pytest.mark.parametrize("name", ARRANGEMENTS)
def test_step_length_does_not_matter(name):
    scene = read(name)
    answers = []
    for halvings in (0, 1):
        solver = DelayNetwork(scene)
        halve(solver, halvings)
        answers.append(follow(solver, 120).psi)
    assert answers[0] == pytest.approx(answers[1], abs=2e-10)


STEP = ["drive.velocity=[[0, 100], [20, 100], [20, 1000]]"]


@pytest.mark.parametrize(("name", "ln_v"), [("unlike", 5.7036059), ("layered", 5.2941163), ("grip", 6.5189910)])
def test_steps_end_on_every_break_point_however_often_they_become_shorter(name, ln_v):
    """V jumps at a multiple of the divisor of all delays, so that the jump's echoes arrive at multiples of it, for ever. The
    first refinements come within such a span."""
    solver = DelayNetwork(read(name, STEP))
    parts, counts = [], {solver.steps}
    while solver.time < 150.0:
        parts.append(solver.advance(solver.time + solver._length))
        counts.add(solver.steps)
    ends = np.concatenate([piece.time + piece.length for piece in parts])
    spans = solver._span * np.arange(1, round(150.0 / solver._span) + 1)
    assert np.abs(ends[np.searchsorted(ends, spans - 1e-9)] - spans).max() < 1e-12
    assert len(counts) > 2
    assert parts[-1].z[-1, -1] == pytest.approx(ln_v, abs=2e-7)


def test_full_grip_is_a_rigid_face():
    grip = 'slab.face={kind="grip", stiffness=1.0, impedance=1e9}'
    rigid = follow(Delay(read("paper")), 100).psi
    assert follow(DelayNetwork(read("paper", [grip])), 100).psi == pytest.approx(rigid, abs=1e-7)


def test_matched_layers_are_no_layers():
    layers = "slab.layers=[{fraction=0.25, impedance=1.0}, {fraction=0.75, impedance=1.0}]"
    plain = follow(Delay(read("paper")), 300).psi
    assert follow(DelayNetwork(read("paper", [layers])), 300).psi == pytest.approx(plain, abs=1e-10)


def test_swallowing_face_returns_no_wave():
    """Behind R = 0 the interface sees a half space: mu = mu_ss - Z (v - V) at every moment, exactly."""
    scene = read("paper", ['slab.face={kind="reflection", coefficient=0.0}'])
    solver = DelayNetwork(scene)
    pieces = solver.advance(30)
    rate = np.exp(pieces.z)
    radiated = scene.steady_stress - scene.impedance * (rate - scene.velocity)
    assert np.abs(pieces.mu - radiated).max() < 1e-13
    assert np.abs(rate - scene.velocity).max() > 1.0


def test_echo_of_a_layer_arrives_after_its_own_round_trip():
    """Before the joint's echo returns, the interface of a layered slab moves as that of a half space of the inner layer."""
    layered = read("paper", ["slab.layers=[{fraction=0.5, impedance=1.0}, {fraction=0.5, impedance=3.0}]", "start.kind='jump'"])
    pieces = DelayNetwork(layered).advance(1.0)
    at = pieces.time[:, None] + pieces.length[:, None] * DelayNetwork(layered).nodes
    radiated = layered.steady_stress - layered.impedance * (np.exp(pieces.z) - layered.velocity)
    difference = np.abs(pieces.mu - radiated)
    assert difference[at < 0.5 - 1e-9].max() < 1e-13
    assert difference[at > 0.5 + 1e-9].max() > 1e-5


@pytest.mark.parametrize("back", [1.0, 1.02, 1.3, 1.875, 2.25, 2.5, 40.6])
def test_waves_that_come_back_between_nodes_gain_nothing(back):
    """In a slab without friction they come back for ever. Values of the waves themselves at the nodes would gain up to 22 % (at
    1.875 steps) every time."""
    nodes = radau(8).nodes
    (steps,), (weights,) = delay_rows(np.array([back]), nodes)
    shift = [weights[0] + np.exp(1j * phase) * weights[1] for phase in np.linspace(0.0, np.pi, 30)]
    assert np.abs(np.linalg.eigvals(shift)).max() < 1.0 + 3e-14
    wave = np.polynomial.Polynomial([0.3, -1.0, 0.5, 0.2])
    arrived = sum(weight @ wave(nodes - step) for step, weight in zip(steps, weights, strict=True))
    np.testing.assert_allclose(arrived, wave(nodes - back), rtol=1e-10)


@pytest.mark.parametrize("ratio", [1.2500123, 1.37])
def test_noise_between_incommensurate_slabs_does_not_grow(ratio):
    """Without the projection: an error of 1e-5 at the first ratio, 96 steps per transit at the second."""
    scene = read("unlike-irrational", {"upper.r": 0.0029, "lower.r": 0.0029 * ratio})
    loose, tight = (DelayNetwork(scene, tolerance) for tolerance in (1e-9, 1e-11))
    assert follow(loose, 600).psi == pytest.approx(follow(tight, 600).psi, abs=3e-8)
    assert loose.steps == 8.0


def test_steps_that_follow_breaks_let_no_noise_grow():
    """Behind a faint kink; equal steps without a projection came to 96 per transit at this ratio. Measured: 6e-9 at t = 600."""
    drive = [[0.0, 100.0], [20.3, 100.0], [25.7, 100.001]]
    scene = read("unlike-irrational", {"upper.r": 0.0029, "lower.r": 0.0029 * 1.37, "drive.velocity": drive})
    found = delay_system(scene, tolerance=1e-7)
    assert isinstance(found, DelayBreaks)
    exact = follow(DiscontinuousGalerkin(scene, 9, 8, time="exact"), 250).psi
    assert follow(found, 250).psi == pytest.approx(exact, abs=1e-7)
    assert found.steps <= 8.0


@pytest.mark.parametrize(("ratio", "divisor"), [(2.0, 0.5), (1.5, 0.25), (np.sqrt(2.0), None)])
def test_common_divisor_of_travel_times(ratio, divisor):
    found = common_divisor(np.array([0.5, 0.5 * ratio]), 64)
    assert found == divisor or found == pytest.approx(divisor)


def test_jump_start_keeps_its_accuracy_where_round_trips_are_commensurate():
    scene = read("unlike", ['start.kind="jump"', "start.size=0.05"])
    loose, tight = (follow(DelayNetwork(scene, tolerance=t), 100).psi for t in (1e-7, 1e-11))
    assert loose == pytest.approx(tight, abs=1e-7)


def test_jump_start_keeps_its_accuracy_where_round_trips_are_not():
    scene = read("unlike-irrational", ['start.kind="jump"', "start.size=0.05"])
    solvers = [delay_system(scene, tolerance=t) for t in (1e-6, 1e-10)]
    loose, tight = (follow(solver, 30).psi for solver in solvers)
    assert isinstance(solvers[0], DelayBreaks)
    assert solvers[0].break_points > 100
    assert loose == pytest.approx(tight, abs=1e-7)


@pytest.mark.parametrize(
    ("name", "one_way"), [("yardstick", [0.5]), ("unlike", [0.5, 1.0]), ("unlike-irrational", [0.5, 0.5**0.5])]
)
def test_break_points_are_the_arrivals_of_the_jump_and_no_others(name, one_way):
    """From the interface into every slab, from its outer face back; what arrives together counts once."""
    solver = DelayBreaks(read(name, ['start.kind="jump"', "start.size=0.05"]))
    follow(solver, 6.0)
    at_interface, arrivals = [0.0], set()
    while at_interface:
        time = at_interface.pop()
        for travel in one_way if time < 6.0 - 1e-9 else []:
            outer, back = round(time + travel, 9), round(time + 2.0 * travel, 9)
            arrivals.add(outer)
            if outer < 6.0 - 1e-9 and back not in arrivals:
                arrivals.add(back)
                at_interface.append(back)
    assert solver.break_points == len(arrivals)


def test_more_break_points_than_can_be_stored_are_refused(monkeypatch):
    """At once: a march that went on would read waves of the wrong step."""
    monkeypatch.setattr("reduced.delay.break_points._RING", 20)
    solver = delay_system(read("unlike-irrational", ['start.kind="jump"']))
    with pytest.raises(NumericsError, match=r"delay: more than 20 break points within a travel time at t = \d+"):
        follow(solver, 30.0)
    assert solver.time == pytest.approx(12.0, abs=0.02)


@pytest.mark.parametrize("name", ["yardstick", "unlike", "grip", "layered"])
def test_break_points_found_by_measure_equal_those_on_the_grid(name):
    scene = read(name, ['start.kind="jump"', "start.size=0.05"])
    assert follow(DelayBreaks(scene), 12).psi == pytest.approx(follow(DelayNetwork(scene), 12).psi, abs=1e-11)


def test_grip_keeps_the_load_and_a_bare_reflection_loses_it():
    """MODEL.md section 3: with R = 0.9 the load relaxes in 10 transits, far less than a cycle, and stick-slip dies; a grip that
    reflects fast waves as much keeps it."""
    drops = {}
    for kind, face in (("bare", 'kind="reflection", coefficient=0.9'), ("grip", 'kind="grip", stiffness=10.0, impedance=19.0')):
        scene = read("paper", [f"slab.face={{{face}}}", "slab.log10_r=-2.55"])
        solver = DelayNetwork(scene)
        observer = EventObserver(scene, solver.nodes)
        follow(solver, 3000, [observer])
        drops[kind] = summarise(observer.events(2000.0)).stress_drop.mean
    assert drops["grip"] > 0.1
    assert not drops["bare"] > 1e-3


@pytest.mark.parametrize(("coefficient", "tolerance"), [(0.999, 1e-8), (0.9, 1e-6), (0.5, 1e-3)])
def test_the_load_on_a_held_interface_falls_to_the_coefficient_every_transit(coefficient, tolerance):
    """MODEL.md section 3: to 1/e in -1/ln R, about 1/(1 - R), transits. The drive stops, strong healing (b = 15 a) holds the
    interface."""
    face = [f"slab.face.coefficient={coefficient}", "interface.a=0.02", "interface.b=0.3"]
    scene = read("reflection", [*face, "drive.velocity=[[0, 100], [1, 0]]", "start.size=0"])
    solver, lasting = DelayNetwork(scene), -1.0 / np.log(coefficient)
    times, loads = [], []
    for periods in (1, 2):
        final = follow(solver, 12 + round(periods * lasting))
        times.append(solver.time)
        loads.append(final.mu - scene.steady_stress)
    assert np.diff(times) / np.log(loads[0] / loads[1]) == pytest.approx(lasting, rel=tolerance)
    assert abs(lasting * (1 - coefficient) - 1) < 1 - coefficient


def test_an_end_that_rounding_just_misses_is_reached():
    solver = DelayNetwork(read("unlike-irrational"))
    follow(solver, 500.0)
    assert abs(solver.time - 500.0) < 0.5
    for just_beyond in (1e-12, 1e-9, 1e-7):
        before = solver.time
        solver.advance(before + just_beyond)
        assert solver.time > before


def test_viscous_slabs_are_refused_with_the_reason():
    with pytest.raises(SceneError, match="disperse"):
        delay_system(read("viscous"))


@pytest.mark.parametrize("march", [DelayNetwork, DelayBreaks])
@pytest.mark.parametrize(("name", "shortest_round_trip"), [("unlike", 1.0), ("layered", 0.5)])
def test_a_step_is_halved_as_far_as_allowed_and_no_further(monkeypatch, march, name, shortest_round_trip):
    """MAX_STEPS in a transit or, if that is shorter, in the shortest round trip through a layer."""
    monkeypatch.setattr("reduced.delay.network.MAX_STEPS", 64)
    solver = march(read(name))
    with pytest.raises(NumericsError, match="cannot be resolved"):
        halve(solver, 12)
    assert 32 / shortest_round_trip < solver.steps <= 64 / shortest_round_trip


def test_unresolvable_run_is_refused_with_place_and_time(monkeypatch):
    monkeypatch.setattr("reduced.delay.network.MAX_STEPS", 8)
    with pytest.raises(NumericsError, match=r"delay: the step at t = .* transits"):
        follow(DelayNetwork(read("unlike", ["upper.log10_r=-2.2", "lower.log10_r=-2.2"])), 1000)
