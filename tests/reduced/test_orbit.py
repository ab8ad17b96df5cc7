"""Periodic orbits known in closed form (`tests.orbit_by_hand`), and Newton's method on equations of known solutions."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from reduced.orbit import periodic_orbit
from reduced.orbit.approach import CycleSection, closest_returns
from reduced.orbit.closing import close, close_family
from reduced.orbit.multipliers import floquet, multipliers
from reduced.orbit.newton import Evaluated, solve_by_newton
from reduced.orbit.periodic import amplitude, figures_of, repeats_sooner
from slipwave import read_scene
from slipwave.errors import NumericsError
from slipwave.observe.pieces import Pieces
from slipwave.step.collocation import radau
from slipwave.step.flow import Cycle
from tests.orbit_by_hand import SHRINKS, SUBCRITICAL, SUPERCRITICAL, TURN, FlowByHand

UNSTABLE, STABLE = 0.2, 0.8
"""|w|^2 of the two orbits of the subcritical oscillator at p = -0.16."""


def test_an_orbit_of_a_family_on_a_plane():
    """With the weight on psi alone, the orbit is the one whose psi at the start is that of the guess."""
    start, flow_at = SUBCRITICAL.state(0.4), lambda p: FlowByHand(SUBCRITICAL, p)
    guess = start + np.array([0.01, 0.03])
    weights = np.array([0.0, 1.0, 0.0, 0.0])
    found = close_family(flow_at, guess, SUBCRITICAL.period(0.4), -0.2, weights)
    s = float(found.cycle.start @ found.cycle.start)
    assert found.cycle.start[1] == pytest.approx(guess[1], abs=1e-11)
    assert found.parameter == found.unknowns[-1] == pytest.approx(SUBCRITICAL.g(s), abs=1e-11)
    assert found.flow.parameter == found.parameter
    assert found.cycle.period == found.unknowns[-2] == pytest.approx(SUBCRITICAL.period(s), abs=1e-11)
    again = close_family(flow_at, guess, SUBCRITICAL.period(0.4), -0.2, weights, neighbour=found)
    np.testing.assert_allclose(again.unknowns, found.unknowns, rtol=0.0, atol=1e-11)


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
    assert repeats_sooner(cycle, nodes, cycles) is sooner


def test_the_closest_returns_come_first():
    sections = [CycleSection(None, np.array([x, 0.0]), date) for x, date in [(0.0, 0.0), (3.0, 10.0), (2.5, 19.0), (2.6, 31.0)]]
    returns = [(first.date, time) for first, time in closest_returns(sections)]
    assert returns == [(19.0, 12.0), (10.0, 9.0), (0.0, 10.0)]
    assert [time for _, time in closest_returns(sections, cycles=2)] == [21.0, 19.0]
    assert [time for _, time in closest_returns(sections, near=9.6)] == [9.0, 10.0]


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


@pytest.mark.parametrize(("strip", "expected"), [(False, 1), (True, -1)])
def test_multipliers_beside_the_plane(strip, expected):
    """exp((d +- 1.3 i) T) of the oscillator that turns, -exp(d T) and -exp(-0.4 T) of the strip."""
    oscillator = SUPERCRITICAL._replace(beside=lambda p: p - 0.2, moebius=strip)
    period = oscillator.period(0.3)
    found = found_at(oscillator, 0.3).multipliers
    pair = np.exp((0.1 + TURN * np.array([1j, -1j])) * period) if expected > 0 else -np.exp(np.array([0.1, SHRINKS]) * period)
    wanted = [*sorted(pair, key=lambda m: (-abs(m), m.imag)), oscillator.multiplier(0.3)]
    assert sorted(found.values, key=lambda m: (-round(abs(m), 9), m.imag)) == pytest.approx(wanted, rel=2e-3)
    assert found.stable is False


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
        return solve_by_newton(self.evaluate, self.derivative, np.array(guess), tolerance, near, first)


def test_steps_are_shortened_until_they_help_and_a_neighbour_that_misleads_is_not_followed():
    """For arctan the full step from 3 leads to -9.5, and on to ever larger values. The derivative of the neighbour leads from 0.5
    to -4600, whence no shortened step comes back."""
    far, near = (Equations(np.arctan, lambda u: np.diag(1.0 / (1.0 + u * u))) for _ in range(2))
    assert abs(far.solved([3.0]).at.unknowns[0]) < 1e-12
    assert max(abs(u[0]) for u in far.tried) < 10.0
    assert abs(near.solved([0.5], first=np.array([[1e-4]])).at.unknowns[0]) < 1e-12
    assert min(u[0] for u in near.tried) == pytest.approx(0.5 - 1e4 * math.atan(0.5))


def test_steps_leave_what_cannot_be_evaluated():

    def residual(u):
        if u[0] <= 0.0:
            raise NumericsError("no logarithm")
        return np.log(u)

    equations = Equations(residual, lambda u: np.diag(1.0 / u))
    assert equations.solved([3.0]).at.unknowns[0] == pytest.approx(1.0, abs=1e-13)


def test_residuals_at_rounding_are_accepted():
    """A residual that cannot fall below 3e-11 counts as zero; one that cannot fall below 3e-7 does not."""
    for floor in (3e-11, 3e-7):
        equations = Equations(lambda u, floor=floor: u - 1.0 + floor * np.sign(u - 1.0 + 1e-300), lambda u: np.eye(1))
        if floor < 1e-9:
            assert equations.solved([1.5]).at.unknowns[0] == pytest.approx(1.0, abs=1e-10)
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
