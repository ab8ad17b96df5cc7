"""Periodic orbits, special points and onsets in closed form (`tests.orbit_by_hand`) and of other programs; Newton's method."""

import math
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest

from reduced.continuation.branch import follow_branch
from reduced.continuation.point import FlowFamily
from reduced.continuation.start import from_orbit, metric_for
from reduced.delay.network import DelayNetwork
from reduced.impedance import reduction_of
from reduced.ode.slabs import STAGES, ReducedModel, ReducedSlabs
from reduced.orbit import periodic_orbit
from reduced.orbit.approach import approach, guesses
from reduced.orbit.closing import Evaluated, _solve_by_newton, close
from reduced.orbit.multipliers import floquet, multipliers
from reduced.orbit.periodic import amplitude, figures_of, repeats_sooner
from reduced.stability.onsets import _bracket, onsets
from slipwave import read, read_scene
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Pieces
from slipwave.step.collocation import radau
from slipwave.step.flow import Cycle
from slipwave.step.port_flow import flow_near
from tests.differences import largest
from tests.orbit_by_hand import SUBCRITICAL, SUPERCRITICAL, FlowByHand

UNSTABLE, STABLE = 0.2, 0.8
"""|w|^2 of the two orbits of the subcritical oscillator at p = -0.16."""


def test_no_orbit_there():
    """Below p = -1/4 none exists; a period far away is not sought; the message says where."""
    flow = FlowByHand(SUBCRITICAL, -0.4)
    with pytest.raises(NumericsError, match=r"by hand: no periodic orbit found near a period of 5\.5 .*\(scene 'by hand'"):
        close(flow, SUBCRITICAL.state(0.5), 5.5)


def motion(functions, period, pieces=5, stages=4):
    """A cycle whose z, psi, mu and y are the given functions of time."""
    nodes, edges = radau(stages).nodes, np.linspace(0.0, period, pieces + 1)
    times = edges[:-1, None] + np.diff(edges)[:, None] * nodes
    return Cycle(period, np.zeros(2), np.zeros(2), Pieces(edges[:-1], np.diff(edges), *(f(times) for f in functions)), 1), nodes


def test_figures_of_a_polynomial_motion():
    """Extrema between the nodes: of degree three, which four nodes show exactly. v = exp z."""

    def cubic(t):
        return t * (t - 2.0) * (t - 4.0)  # extrema at 2 -+ 2/sqrt(3), of size 16/(3 sqrt(3))

    largest = 16.0 / (3.0 * math.sqrt(3.0))
    cycle, nodes = motion([lambda t: 0.5 * cubic(t), cubic, lambda t: 0.1 * cubic(t) + 0.6, lambda t: -0.03 * cubic(t)], 4.0)
    flow = SimpleNamespace(scene=FlowByHand(SUPERCRITICAL, 0.1).scene, nodes=nodes)
    found = figures_of(SimpleNamespace(flow=flow, cycle=cycle))
    drops, rates = (0.2 * largest, 0.06 * largest), (math.exp(0.5 * largest), math.exp(-0.5 * largest))
    assert list(found) == ["period", "stress_drop", "elastic_stress_drop", "v_max", "v_min"]
    assert list(found.values()) == pytest.approx([4.0, *drops, *rates], rel=1e-13)
    assert amplitude(cycle) == pytest.approx(largest, rel=0.02)


@pytest.mark.parametrize(
    ("cycles", "sooner"), [(1, False), (2, False), (3, True), (4, False), (6, True)], ids=lambda value: str(value)
)
def test_a_motion_that_repeats_after_a_third(cycles, sooner):
    cycle, nodes = motion([*[lambda t: np.sin(math.pi * t)] * 4], 6.0, pieces=60)
    assert repeats_sooner(SimpleNamespace(cycle=cycle, flow=SimpleNamespace(nodes=nodes)), cycles) is sooner


def test_the_trivial_multiplier_is_split_off():
    values = np.array([0.3, -2.0, 1.0 + 2e-9, 0.4 + 0.9j, 0.4 - 0.9j])
    basis = np.vander([0.1, 0.5, 1.2, 1.7, 2.3])
    block = np.diag([0.3, -2.0, 1.0 + 2e-9, 0.4, 0.4])
    block[3, 4], block[4, 3] = 0.9, -0.9
    found, defect = floquet(basis @ block @ np.linalg.inv(basis))
    np.testing.assert_allclose(found[[0, 3]], [-2.0, 0.3], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(np.sort_complex(found[1:3]), np.sort_complex(values[3:]), rtol=0.0, atol=1e-9)
    assert defect == pytest.approx(2e-9, abs=1e-10)


def with_multipliers(*values, radius=0.0):
    """A closed cycle that has these real multipliers, then the trivial one."""
    scene, idle = read_scene("unlike-irrational"), np.zeros((len(values) + 1, 0))
    flow = SimpleNamespace(scene=scene, essential_radius=lambda cycle: radius, idle=idle, undecided=radius == 1.0)
    return SimpleNamespace(flow=flow, cycle=SimpleNamespace(period=50.0), monodromy=np.diag([*values, 1.0]))


def test_only_multipliers_beyond_the_essential_radius_are_told():
    found = multipliers(with_multipliers(0.5, -0.11, 0.09, 0.02, radius=0.1))
    assert (found.values, found.essential_radius) == (pytest.approx([0.5, -0.11]), 0.1)
    assert found.trivial_defect < 1e-15


def test_only_multipliers_that_two_meshes_agree_on_are_told():
    """To a thousandth of their size, also of small ones: a ring of essential multipliers is never the same on two meshes."""
    fine, coarse = with_multipliers(0.5, 0.02, -0.3, 3.0), with_multipliers(0.5004, 0.0203, -0.302, 3.002)
    assert multipliers(fine, coarse).values == pytest.approx([3.0, 0.5])
    assert multipliers(fine).values == pytest.approx([3.0, 0.5, -0.3, 0.02])


@pytest.mark.parametrize(
    ("values", "radius", "stable", "reason"),
    [
        ([0.5, -0.9], 0.0, True, ""),
        ([0.5, -1.1], 0.0, False, ""),
        ([1.0 + 1e-5], 0.0, False, ""),
        ([1.0 - 1e-5], 0.0, True, ""),
        ([], 0.0, True, ""),
        ([-1.0 + 3e-7], 0.0, None, "the largest multiplier has modulus 0.999999700"),
        ([0.5], 1.0, None, "the waves' own multipliers reach a radius of 1: "),
        ([5.0], 1.0, False, "the waves' own multipliers reach a radius of 1: "),
        ([0.5], 0.999, True, ""),
    ],
)
def test_the_verdict(values, radius, stable, reason):
    found = multipliers(with_multipliers(*values, radius=radius))
    assert found.stable is stable
    assert found.reason.startswith(reason)
    assert bool(found.reason) is bool(reason)


def found_at(oscillator, s, tolerance=1e-8, **settings):
    flow = FlowByHand(oscillator, oscillator.g(s), steps=12, **settings)
    return periodic_orbit(flow, 1.02 * oscillator.state(s), 1.01 * oscillator.period(s), tolerance)


@pytest.mark.parametrize("s", [UNSTABLE, STABLE])
def test_an_orbit_with_its_figures_and_stability(s):
    """z and psi are sqrt(s) cos and sin; the extrema of their polynomials of degree 7 in a twelfth of the period."""
    result, size = found_at(SUBCRITICAL, s), math.sqrt(s)
    orbit = result.orbit
    assert orbit.period.value == pytest.approx(SUBCRITICAL.period(s), abs=1e-11)
    assert list(orbit.values().values())[1:] == pytest.approx([size, 0.5 * size, math.exp(size), math.exp(-size)], rel=1e-8)
    assert result.multipliers.stable is (s == STABLE)
    assert result.multipliers.values == pytest.approx([SUBCRITICAL.multiplier(s)], rel=2e-3)
    assert result.settled


def test_errors_hold_the_truth_wherever_in_its_step_an_extremum_lies():
    """Orbits begun at 24 of their phases: on one mesh the error of an extremum differs a thousandfold between them."""

    class ByRadau(FlowByHand):
        nodes = radau(7).nodes

    s, held, ratios = 0.5, 0, []
    flow, size = ByRadau(SUBCRITICAL, SUBCRITICAL.g(s), steps=5), math.sqrt(s)
    truth = {"stress_drop": size, "elastic_stress_drop": 0.5 * size, "v_max": math.exp(size), "v_min": math.exp(-size)}
    for phase in np.arange(24) * 0.26:
        start = size * np.array([math.cos(phase), math.sin(phase)])
        orbit = periodic_orbit(flow, start, SUBCRITICAL.period(s), 1e-3).orbit
        for name, true in truth.items():
            error = abs(getattr(orbit, name).value - true)
            held += error <= getattr(orbit, name).error
            ratios.append(getattr(orbit, name).error / max(error, 1e-15))
    assert held == 96
    assert 3.0 < np.median(ratios) < 1000.0  # a sine is smoother than cycles of slip


def test_a_mesh_is_solved_on_although_the_coarser_one_s_orbit_nearly_closes_on_it():
    """Meshes shift the parameter by 2e-13 (12/steps)^2: below what ends Newton's method else."""

    class Shifted(FlowByHand):
        def march(self, start, period):
            moved = replace(self, parameter=self.parameter + 2e-13 * (12.0 / self.steps) ** 2)
            return FlowByHand.march(moved, start, period)

    s = 0.3
    flow = Shifted(SUPERCRITICAL, s, steps=12)
    period = periodic_orbit(flow, 1.02 * SUPERCRITICAL.state(s), SUPERCRITICAL.period(s)).orbit.period
    assert abs(period.value - SUPERCRITICAL.period(s)) < period.error < 2e-12 * period.value


def test_a_tolerance_that_no_mesh_reaches_is_told():
    """Rounding errors remain, also where two meshes give the same number by chance."""
    result = found_at(SUPERCRITICAL, 0.3, tolerance=1e-14)
    assert not result.settled
    assert result.orbit.period.error >= 3e-14 * result.orbit.period.value
    assert result.orbit.period.value == pytest.approx(SUPERCRITICAL.period(0.3), abs=1e-11)
    assert result.closed.flow.steps == 140  # 12 steps, six times 1.5 as many, rounded up


def test_steady_sliding_is_no_orbit():
    assert periodic_orbit(FlowByHand(SUPERCRITICAL, 1e-6), SUPERCRITICAL.state(1e-6), SUPERCRITICAL.period(1e-6)).settled
    with pytest.raises(NumericsError, match="by hand: Newton's method fell back onto steady sliding"):
        periodic_orbit(FlowByHand(SUPERCRITICAL, 1e-8), SUPERCRITICAL.state(1e-8), SUPERCRITICAL.period(1e-8))


class Equations:
    """`residual(u)` = 0 with its `derivative`, and what was asked for."""

    def __init__(self, residual, derivative):
        self._residual, self._derivative, self.tried = residual, derivative, []

    def evaluate(self, u):
        self.tried.append(u)
        return Evaluated(u, self._residual(u), None)

    def derivative(self, at):
        return self._derivative(at.unknowns)

    def solved(self, guess, tolerance=1e-13, near=1e-7, first=None):
        return _solve_by_newton(self.evaluate, self.derivative, np.array(guess), tolerance, near, first)


def test_steps_are_shortened_until_they_help_and_a_neighbour_that_misleads_is_not_followed():
    """For arctan the full step from 3 leads to -9.5, and on to ever larger values. The derivative of the neighbour leads from 0.5
    to -4600, whence no shortened step comes back."""
    far, near = (Equations(np.arctan, lambda u: np.diag(1.0 / (1.0 + u * u))) for _ in range(2))
    assert abs(far.solved([3.0])[0].unknowns[0]) < 1e-12
    assert max(abs(u[0]) for u in far.tried) < 10.0
    assert abs(near.solved([0.5], first=np.array([[1e-4]]))[0].unknowns[0]) < 1e-12
    assert min(u[0] for u in near.tried) == pytest.approx(0.5 - 1e4 * math.atan(0.5))


def test_steps_leave_what_cannot_be_evaluated():

    def residual(u):
        if u[0] <= 0.0:
            raise NumericsError("no logarithm")
        return np.log(u)

    equations = Equations(residual, lambda u: np.diag(1.0 / u))
    assert equations.solved([3.0])[0].unknowns[0] == pytest.approx(1.0, abs=1e-13)


def test_residuals_at_rounding_are_accepted():
    """A residual that cannot fall below 3e-11 counts as zero; one that cannot fall below 3e-7 does not."""
    for floor in (3e-11, 3e-7):
        equations = Equations(lambda u, floor=floor: u - 1.0 + floor * np.sign(u - 1.0 + 1e-300), lambda u: np.eye(1))
        if floor < 1e-9:
            assert equations.solved([1.5])[0].unknowns[0] == pytest.approx(1.0, abs=1e-10)
        else:
            with pytest.raises(NumericsError, match=r"no convergence in 25 iterations: a residual of \de-07 is left"):
                equations.solved([1.5])


def only_at_the_guess(u):
    if u[0] != 2.0:
        raise NumericsError("it runs away")
    return u


@pytest.mark.filterwarnings("ignore:Diagonal number")
@pytest.mark.parametrize(
    ("residual", "derivative", "guess", "message"),
    [
        (
            lambda u: u * u + 1.0,
            lambda u: np.diag(2.0 * u),
            [1.3],
            r"no convergence in 25 iterations: a residual of 1\.?\d* is left",
        ),
        (
            lambda u: u.sum() * np.r_[1, 2] - 1,
            lambda u: np.array([[1.0, 1], [2, 2]]),
            [3.0, 1.0],
            "the linearised equations are sing",
        ),
        (only_at_the_guess, lambda u: np.eye(1), [2.0], "no motion can be computed along Newton's step"),
    ],
)
def test_no_solution(residual, derivative, guess, message):
    with pytest.raises(NumericsError, match=message):
        Equations(residual, derivative).solved(guess)


def scene_at(log10_r):
    return read("paper", {"slab.log10_r": log10_r})


def run_of(model, log10_r):
    scene = scene_at(log10_r)
    return DelayNetwork(scene, tolerance=1e-6) if model == "delay" else ReducedModel(scene, reduction_of(scene, model), 1e-6)


def guessed(model, log10_r, tolerance=1e-9):
    return approach(run_of(model, log10_r), 1e-6 if model == "delay" else tolerance)


@lru_cache
def found(model, log10_r, tolerance=1e-9):
    return periodic_orbit(*guessed(model, log10_r, tolerance)[:3], tolerance)


def test_a_settled_run_is_near_its_orbit():
    guess = guessed("delay", -2.68)
    assert guess.settled
    assert guess.period == pytest.approx(73.47214494, rel=1e-3)
    cycle = guess.flow.march(guess.state, guess.period)
    assert largest(cycle.end - guess.state) < 0.05
    z = cycle.pieces.z.max(axis=1)
    assert 0.3 < z.argmax() / z.size < 0.7  # it begins and ends between slip events


def returns(model, log10_r, near=None):
    """Orbits from the run's closest returns, those of Newton's failures left out."""
    for guess in guesses(run_of(model, log10_r), 1e-6 if model == "delay" else 1e-9, near=near):
        with suppress(NumericsError):
            yield close(*guess[:3]), guess.cycles


@pytest.mark.slow
def test_an_irregular_run_comes_near_to_unstable_orbits():
    """At log10 r = -2.5 the mean of its cycles leads to none; the run's periods lie between 90 and 99."""
    one, cycles = next(returns("delay", -2.5, near=91.0))
    assert cycles == 1
    assert 88.0 < one.cycle.period < 99.0
    assert one.residual < 1e-11
    assert np.abs(floquet(one.monodromy)[0][0]) > 2.0


def test_an_orbit_of_two_cycles_is_found_beside_the_simple_one():
    """The ODE's run at log10 r = -2.59 settles on the doubled orbit, whose period is nearly twice that of the simple one."""
    closed = found("kelvin-voigt", -2.59).closed
    assert floquet(closed.monodromy)[0][0] < -1.2
    twice = close(closed.flow, closed.cycle.start, 2.0 * closed.cycle.period)
    assert repeats_sooner(twice, 2)
    for one, cycles in returns("kelvin-voigt", -2.59, near=158.0):
        if not repeats_sooner(one, cycles):
            break
    assert cycles == 2
    assert one.cycle.period == pytest.approx(2.0 * closed.cycle.period, rel=1e-3)
    assert np.abs(floquet(one.monodromy)[0]).max() < 1.0


def test_no_orbit_near_a_run():
    with pytest.raises(NumericsError, match=r"delay: .*(returns to steady sliding|no orbit near it).*'paper'"):
        guessed("delay", -2.72)
    with pytest.raises(NumericsError, match=r"a run of 300 transits made \d+ cycles in its second half: no orbit near it"):
        approach(run_of("delay", -2.68), 1e-6, most=300.0)


def test_a_run_that_still_grows_from_a_small_disturbance_does_not_return_to_steady_sliding():
    """After 400 transits ln v still swings by less than 1e-3."""
    scene = read("paper", {"slab.log10_r": -2.6, "start.size": 1e-6})
    guess = approach(ReducedModel(scene, reduction_of(scene, "kelvin-voigt"), 1e-9), 1e-9)
    assert guess.settled
    assert guess.period == pytest.approx(78.9, abs=0.1)


def test_cycles_that_change_to_and_fro_for_long_are_those_around_an_orbit():
    """After a jump the twelve cycles of the second half differ by 1.2 %, and the last is smaller than the first by chance; a
    long run settles on a doubled orbit of twice 274.278 transits."""
    slab = {"slab.epsilon": 8.863591783499049e-06, "slab.r": 0.0007942257692100286}
    scene = read("paper", {**slab, "start.kind": "jump", "start.size": 1e-4})
    runs = guesses(ReducedModel(scene, reduction_of(scene, "kelvin-voigt"), 1e-9), 1e-9, most=6870.0)
    periods = [guess.period for guess in islice(runs, 1, 4)]
    assert periods == pytest.approx([274.278] * 3, rel=1e-2)


def test_a_run_that_creeps_past_a_lost_orbit_is_followed_on():
    """At log10 r = -2.675 cycles of 74.68 transits hardly change for a while, and no orbit is near. It has 74.93245
    (by continuation from -2.68); the first guess leads nowhere. On the mesh of a run to 1e-6: 2e-7 was measured."""
    one, _ = next(returns("delay", -2.675))
    assert one.cycle.period == pytest.approx(74.93244964, abs=2e-6)


def test_the_torus_of_kelvin_voigt():
    """From beyond it, where nothing stable is near: an orbit that was found along the branch. The paper reads 10^-2.468."""
    state, period = np.array([-0.0255313, 0.0472059, 0.0722975, -2.1407318]), 81.90486
    slabs = ReducedSlabs(scene_at(-2.466), lambda other: reduction_of(other, "kelvin-voigt"), STAGES)
    flow, metric = flow_near(slabs, state, period, 1e-8, 2.0), metric_for(-2.72, -2.3)
    family = FlowFamily(flow, scene_at)
    point = from_orbit(family, close(flow, state, period), -2.466, -3.0, metric)
    steps = follow_branch(family, point, metric, lambda q: True, 1e-7)
    torus = next(special for _, step in zip(range(60), steps, strict=False) for special in step.special)
    assert (torus.kind, torus.unstable_before, torus.unstable_after) == ("NS", 2, 0)
    assert torus.point.parameter == pytest.approx(-2.469026250, abs=1e-9)
    assert torus.point.closed.cycle.period == pytest.approx(81.900881030, abs=1e-6)
    assert torus.bracket < 1e-9


@pytest.mark.parametrize(
    ("model", "log10_r", "period"), [("delay", -2.6995497159, 49.66818383), ("kelvin-voigt", -2.69954994745, 49.66821032)]
)
def test_onsets_in_any_parameter_are_one(model, log10_r, period):
    """At the critical r the onset in epsilon is at the paper's value, and that in V too, with one period."""
    for key, low, high, known in (("slab.epsilon", 1e-5, 1e-4, 2.8e-5), ("drive.velocity", 50.0, 300.0, 100.0)):
        (onset,) = onsets(lambda p, key=key: read("paper", {"slab.log10_r": log10_r, key: p}), low, high, model)
        assert (onset.parameter, onset.period) == (pytest.approx(known, rel=1e-7), pytest.approx(period, rel=1e-7))
        assert sorted((onset.unstable_below, onset.unstable_above)) == [0, 2]
    assert onsets(scene_at, -2.8, -2.7, "delay") == []


@pytest.mark.parametrize(("coefficient", "hopf"), [(0.99, [(pytest.approx(2.5764611753e-5, rel=1e-9), 2, 0)]), (0.0, [])])
def test_a_single_real_root_is_no_onset_and_hides_none(coefficient, hopf):
    """Slabs without a spring: at epsilon = 1.4e-6 and 2.8e-4 a root crosses at s = 0, for 0.99 between the same samples as a
    pair."""
    face = {"slab.face.kind": "reflection", "slab.face.coefficient": coefficient}
    known = onsets(lambda epsilon: read("paper", face | {"slab.epsilon": epsilon}), 1e-6, 1e-3, "delay")
    assert [(onset.parameter, onset.unstable_below, onset.unstable_above) for onset in known] == hopf


@pytest.mark.parametrize("ends", [(0.0, 1.0), (-1.0, 0.0)])
def test_an_onset_on_a_sample_of_its_search_is_bracketed_beyond_rounding(ends):
    """An end lies on the Hopf point: the sign of the crossing root's real part there is that of rounding."""
    for rounding in (1e-16, -1e-16):
        low, high = _bracket(lambda x, rounding=rounding: x or rounding, *ends)
        assert low < -1e-9 < 1e-9 < high
