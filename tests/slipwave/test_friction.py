"""The friction laws: derivatives, steady states, limits; the interface solve from any start at any rate; one collocated step."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import root

import slipwave
from slipwave.compiled import njit
from slipwave.errors import NumericsError
from slipwave.friction import LAWS, law_of_step, rate_of, respond, said_of_rest, steady_state, to_own, to_step, unknown_of
from slipwave.friction.ageing import Ageing, respond_ageing
from slipwave.friction.interface import MAX_ITERATIONS, solve_interface
from slipwave.observe.pieces import Pieces
from slipwave.solve import follow
from slipwave.step.collocation import rule_of
from slipwave.step.impedance import Diagonal, Full
from slipwave.step.newton import solve as solve_step
from slipwave.step.nodal import nodal_of
from slipwave.step.tangent import Answer, Motion, step_answer
from tests.differences import difference

PAPER = (0.369, 0.0349, 0.0489)
CUT, SATURATED = 40.0, 0.02
OWN = {"cutoff_velocity": CUT, "saturation_velocity": SATURATED}
REGULARISED = ("ageing-regularised", "slip-regularised")
STEP = 1e-6

rates = st.floats(-12.0, 12.0).map(math.exp)
offsets = st.floats(-3.0, 3.0)
names = st.sampled_from(sorted(LAWS))


def law_called(name, **own):
    """With the paper's parameters; `own` are those that only some laws have."""
    made = LAWS[name].parameters
    return made(*PAPER, **{key: value for key, value in (OWN | own).items() if key in made._fields})


def plainness(rate, psi):
    """How far v is above the range where regularisation matters (small: far above)."""
    return 2.0 * math.exp(-(0.369 + 0.0489 * psi) / 0.0349) / rate


@given(names, rates, offsets)
def test_derivatives_are_those_of_finite_differences(name, rate, offset):
    law = law_called(name)
    z, psi = unknown_of(law, rate), steady_state(law, rate) + offset
    v, v_z, _, f_z, f_psi, g, g_z, g_psi = respond(law, z, psi)
    ahead, behind = respond(law, z + STEP, psi), respond(law, z - STEP, psi)
    up, down = respond(law, z, psi + STEP), respond(law, z, psi - STEP)
    scale = v + abs(g) + math.exp(-psi) + 1.0
    for given_one, pair, place, size in (
        (v_z, (ahead, behind), 0, v),
        (f_z, (ahead, behind), 2, 1.0),
        (f_psi, (up, down), 2, 1.0),
        (g_z, (ahead, behind), 5, scale),
        (g_psi, (up, down), 5, scale),
    ):
        measured = (pair[0][place] - pair[1][place]) / (2 * STEP)
        assert given_one == pytest.approx(measured, rel=1e-6, abs=1e-7 * size)


@given(st.sampled_from(sorted(name for name in LAWS if name != "spinodal")), rates)
def test_steady_sliding_is_steady_and_weakens_as_b_exceeds_a(name, rate):
    law = law_called(name, cutoff_velocity=1e300)
    psi = steady_state(law, rate)
    answer = respond(law, unknown_of(law, rate), psi)
    assert psi == pytest.approx(-math.log(rate), abs=1e-14)
    assert answer[0] == pytest.approx(rate, rel=1e-13)
    assert abs(answer[5]) <= 1e-12 * rate
    slack = 0.0349 * plainness(rate, psi) ** 2 if name in REGULARISED else 0.0
    assert answer[2] == pytest.approx(0.369 + (0.0349 - 0.0489) * math.log(rate), abs=slack + 1e-13)


@given(st.sampled_from(REGULARISED), rates, offsets)
def test_a_regularised_law_equals_its_plain_one_at_forward_rates(name, rate, offset):
    regularised, plain = law_called(name), law_called(name.removesuffix("-regularised"))
    psi = steady_state(plain, rate) + offset
    smooth, sharp = (respond(law, unknown_of(law, rate), psi) for law in (regularised, plain))
    ratio = plainness(rate, psi)
    assert abs(smooth[2] - sharp[2]) <= 0.0349 * ratio**2 + 1e-14
    assert smooth[5] == pytest.approx(sharp[5], rel=1e-9, abs=1e-9 * rate)
    assert smooth[4] == pytest.approx(sharp[4], rel=ratio**2 + 1e-12)


@pytest.mark.parametrize("name", REGULARISED)
def test_a_regularised_law_is_odd_in_v_and_finite_at_rest(name):
    law = law_called(name)
    for rate in (0.0, 1e-30, 1e-12, 1.0, 1e6):
        forward, backward = (respond(law, unknown_of(law, v), 0.7) for v in (rate, -rate))
        assert all(map(math.isfinite, forward + backward))
        assert backward[2] == pytest.approx(-forward[2], rel=1e-12, abs=1e-30)
        assert backward[5] == pytest.approx(forward[5], rel=1e-12)
        assert backward[3] > 0.0
    assert respond(law, unknown_of(law, 0.0), 0.7)[2] == 0.0


@pytest.mark.parametrize("name", REGULARISED)
def test_a_regularised_law_keeps_its_digits_near_rest_and_where_the_exponential_would_overflow(name):
    law = law_called(name)
    growth = math.exp((0.369 + 0.0489 * 0.7) / 0.0349)
    for rate in (1e-25, 1e-18, 1e-12):
        assert respond(law, unknown_of(law, rate), 0.7)[2] == pytest.approx(0.0349 * math.asinh(0.5 * rate * growth), rel=1e-13)
    weak = LAWS[name].parameters(0.6, 1e-3, 1e-3)  # (a_* + b psi)/a = 600
    assert respond(weak, unknown_of(weak, 2.0), 0.0)[2] == pytest.approx(0.6 + 1e-3 * math.log(2.0), rel=1e-13)


@given(st.sampled_from(["ageing-cutoff", "slip-cutoff"]), rates, offsets)
def test_a_law_with_a_cutoff_is_its_plain_one_but_for_young_contacts(name, rate, offset):
    """a_* means the same; the state effect is b ln(phi v_c + 1), but for a constant; 1/v_c = 0 is the plain law."""
    law, plain = law_called(name), law_called(name.removesuffix("-cutoff"))
    psi = offset - math.log(rate)
    cut, sharp = (respond(one, math.log(rate), psi) for one in (law, plain))
    assert cut[2] - sharp[2] == pytest.approx(0.0489 * math.log1p(math.exp(-psi) / CUT), rel=1e-9, abs=1e-14)
    assert cut[2] == pytest.approx(
        0.369 - 0.0489 * math.log(CUT) + 0.0349 * math.log(rate) + 0.0489 * math.log(math.exp(psi) * CUT + 1.0), abs=1e-13
    )
    assert (*cut[:2], cut[3], *cut[5:]) == pytest.approx((*sharp[:2], sharp[3], *sharp[5:]), rel=1e-14)
    far = respond(law_called(name, cutoff_velocity=1e300), math.log(rate), psi)
    assert far == pytest.approx(sharp, rel=1e-14)


@given(rates, offsets)
def test_the_spinodal_law_is_the_regularised_ageing_law_between_its_two_rates(rate, offset):
    law = law_called("spinodal", cutoff_velocity=1e200, saturation_velocity=1e-200)
    plain = law_called("ageing-regularised")
    z, psi = unknown_of(plain, rate), offset - math.log(rate)
    assert steady_state(law, rate) == pytest.approx(-math.log(rate), abs=1e-14)
    assert respond(law, z, psi) == pytest.approx(respond(plain, z, psi), rel=1e-13)


def test_steady_friction_of_the_spinodal_law_rises_falls_and_rises():
    low, high = 1e-6, 1e8
    law = law_called("spinodal", cutoff_velocity=high, saturation_velocity=low)

    def steady(v):
        return respond(law, unknown_of(law, v), steady_state(law, v))[2]

    a, b = PAPER[1:]
    for place, sign in ((low * math.sqrt(a / (b - a)), 1.0), (high * (b - a) / a, -1.0)):
        assert sign * steady(place) > max(sign * steady(place * 1.1), sign * steady(place / 1.1))
        near = [steady(place * factor) for factor in (1.0 / 1.001, 1.001)]
        assert abs(near[1] - near[0]) < 1e-3 * a * 0.002
    assert (steady(0.0), steady(-3.0)) == (0.0, pytest.approx(-steady(3.0), rel=1e-12))
    assert 0.0 < steady(1e-12) < steady(1e-7) < steady(low * 1.5)


@pytest.mark.parametrize("name", sorted(LAWS))
def test_compiled_and_plain_answers_are_the_same(name):
    @njit
    def compiled(law, z, psi, v):
        return respond(law, z, psi), steady_state(law, v), rate_of(law, z), unknown_of(law, v)

    law = law_called(name)
    z = unknown_of(law, 3.7)
    answer, steady, rate, unknown = compiled(law, z, 0.3, 3.7)
    assert answer == pytest.approx(respond(law, z, 0.3), rel=1e-14)
    assert (steady, rate, unknown) == pytest.approx((steady_state(law, 3.7), rate_of(law, z), z), rel=1e-14)


LAW_NAMES = ("ageing", "slip", "ageing-regularised", "slip-regularised")


@njit
def solve(law, impedance, incoming, psi, start):
    """As the solvers call it: compiled, so that e^z overflows to infinity."""
    return solve_interface(law, impedance, incoming, psi, start)


def incoming_for(law, impedance, rate, psi):
    """The rate unknown of `rate` and the incoming stress of which it is the root."""
    z = unknown_of(law, rate)
    v, _, friction, *_ = respond(law, z, psi)
    return z, friction + impedance * v


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("impedance", [0.0, 1e-12, 1.4e-5, 1.0, 1e6])
def test_every_rate_is_found_again(name, impedance):
    law = law_called(name)
    for exponent in np.linspace(-30 if "regularised" not in name else -15, 15, 46):
        rate = 10.0**exponent
        psi = min(60.0, max(-60.0, steady_state(law, rate)))
        wanted, incoming = incoming_for(law, impedance, rate, psi)
        for start in (wanted + 0.01, 0.0, wanted + 30.0, wanted - 30.0):
            z, iterations = solve_interface(law, impedance, incoming, psi, start)
            assert 0 < iterations <= (5 if start == wanted + 0.01 else MAX_ITERATIONS)
            # a root is as sharp as the rounding of the incoming stress over the slope of the balance
            v, v_z, _, friction_z, *_ = respond(law, wanted, psi)
            sharpness = 1e-15 * (abs(incoming) + impedance * v + 1.0) / (friction_z + impedance * v_z)
            assert z == pytest.approx(wanted, abs=8 * sharpness + 1e-14 * abs(wanted))


@given(
    st.sampled_from(LAW_NAMES),
    st.floats(-6, 3).map(lambda x: 10**x),
    st.floats(-2.0, 5.0),
    st.floats(-20.0, 20.0),
    st.floats(-60, 60),
)
def test_random_starts_end_at_a_root(name, impedance, incoming, psi, start):
    law = law_called(name)
    z, iterations = solve_interface(law, impedance, incoming, psi, start)
    assert iterations > 0
    v, v_z, friction, friction_z, *_ = respond(law, z, psi)
    residual = friction + impedance * v - incoming
    slack = (friction_z + impedance * v_z) * 1e-14 * (1.0 + abs(z)) + 1e-14 * (abs(friction) + impedance * abs(v) + 1.0)
    assert abs(residual) <= slack


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("impedance", [1.4e-5, 1.0])
@pytest.mark.parametrize("start", [390.0, 900.0, -390.0])
def test_a_start_hundreds_away_is_no_failure(name, impedance, start):
    """Newton gains one in z an iteration where v = e^z rules, and gains nothing where e^z overflows."""
    law = law_called(name)
    wanted, incoming = incoming_for(law, impedance, 100.0, -4.6)
    z, iterations = solve(law, impedance, incoming, -4.6, start)
    assert 0 < iterations < 120
    assert z == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("name", LAW_NAMES)
@pytest.mark.parametrize("where", range(3))
def test_not_a_number_is_a_counted_failure(name, where):
    values = [0.4, 0.0, 1.0]
    values[where] = math.nan
    incoming, psi, start = values
    assert solve_interface(law_called(name), 1e-5, incoming, psi, start)[1] == 0


respond_plain = njit(respond_ageing)


class WithinBounds(Ageing):
    """The ageing law with values between two rates only."""


@respond.register(WithinBounds)
def respond_within_bounds(law, z, psi):
    v, v_z, friction, friction_z, friction_psi, growth, growth_z, growth_psi = respond_plain(law, z, psi)
    return v, v_z, friction if 1e-3 < v < 1e3 else math.nan, friction_z, friction_psi, growth, growth_z, growth_psi


@pytest.mark.parametrize("start", [-2.0, 0.0, 3.0])
def test_a_rate_at_which_a_law_has_no_value_is_a_counted_failure(start):
    """Before, the rate at which its values end was taken for the root: full waves went on from there."""
    law = WithinBounds(*PAPER)
    for rate, has_root in ((1e-4, False), (2e-3, True), (900.0, True), (1e4, False)):
        wanted, incoming = incoming_for(Ageing(*PAPER), 1.4e-5, rate, -4.6)
        z, iterations = solve_interface(law, 1.4e-5, incoming, -4.6, start)
        assert (iterations > 0) == has_root
        assert z == pytest.approx(wanted, rel=1e-12) or not has_root


def test_errors_where_a_law_has_no_value_name_that_and_no_other_cause(monkeypatch):
    """Before, equal steps advised "more cells or a smaller cfl", and blocks and modes said that the stress stops slip."""
    monkeypatch.setitem(LAWS, "bounded", LAWS["ageing"]._replace(parameters=WithinBounds))
    law = WithinBounds(*PAPER)
    for rate, said in ((5e-3, ""), (500.0, ""), (900.0, "; law 'bounded' has no value at v = 1.48e+03 V*")):
        assert said_of_rest(law, np.array([-1.0]), math.log(rate), -4.6) == said
    column = np.full((1, 2), math.log(1.2e-3))
    pieces = Pieces(np.zeros(1), np.ones(1), column, column, column, column)
    scene = dataclasses.replace(slipwave.read("paper"), law=law)
    solver = SimpleNamespace(time=0.0, model="fd", failures=1, failed_at=0.5, scene=scene, advance=lambda until: pieces)
    with pytest.raises(NumericsError, match=r"not the scene's motion; law 'bounded' has no value at v = 0.000728 V\* \(scene"):
        follow(solver, 2.0)


RULE, COMPILED, NODES = rule_of(5)
S = len(NODES)
INTEGRAL = COMPILED.integral
COUPLED = np.tril(np.random.default_rng(5).uniform(0.2, 1.0, (S, S)))
STEPPED = {
    "paper": ("paper", []),
    "slip": ("slip-law", []),
    "regularised": ("regularised", []),
    "slip-regularised": ("regularised", ["interface.law='slip-regularised'"]),
}


def solved(law, impedance, h, psi, z, incoming, forced):
    """(iterations, psi, z, v) at the nodes, from a guess one unit off in z."""
    nodal, here = nodal_of(S), law_of_step(law, psi)
    nodal.incoming[:], nodal.left[:], nodal.psi[:], nodal.z[:] = incoming, psi + forced, psi, z + 1.0
    to_step(here, law, nodal.z)
    used = solve_step(here, NODES, impedance, h, COMPILED, 1e-13, nodal)
    to_own(here, nodal.z)
    return used, nodal.psi.copy(), nodal.z.copy(), nodal.v.copy()


class Step:
    """A step of a law from near steady sliding at `rate`, under stress that varies within the step by `swing`."""

    def __init__(self, law, rate, coupling, swing=1e-2):
        scene = slipwave.read(*STEPPED[law])
        self.law, self.h, size = scene.law, 0.05 * scene.transit, 0.5 * scene.upper.epsilon
        self.matrix = size * (np.eye(S) + coupling * (COUPLED - np.diag(np.diag(COUPLED))))
        self.impedance = Full(self.matrix) if coupling else Diagonal(size)
        self.left, self.start = steady_state(self.law, rate), unknown_of(self.law, rate)
        friction = respond(self.law, self.start, self.left)[2]
        self.incoming = friction + self.matrix @ np.full(S, rate) + swing * np.sin(3.0 * RULE.nodes)

    def solve(self, change):
        """v and psi at the nodes for changes of S at the nodes, of psi at the start and of h G at the nodes."""
        stress, left, rate = np.split(np.asarray(change), [S, S + 1])
        forced, incoming = RULE.integral @ rate, self.incoming + stress
        used, psi, z, _ = solved(self.law, self.impedance, self.h, self.left + left[0], self.start, incoming, forced)
        assert used > 0
        return np.concatenate([[rate_of(self.law, one) for one in z], psi]), z

    def by_root_finder(self, forced):
        def defect(unknowns):
            answers = np.array([respond(self.law, z, p) for z, p in zip(unknowns[S:], unknowns[:S], strict=True)])
            state = unknowns[:S] - self.left - forced - self.h * RULE.integral @ answers[:, 5]
            return np.concatenate([state, answers[:, 2] + self.matrix @ answers[:, 0] - self.incoming])

        return root(defect, np.repeat([self.left, self.start], S), method="hybr", tol=1e-14).x

    def answer(self, frozen=False):
        both, z = self.solve(np.zeros(2 * S + 1))
        answer = Answer(np.full((2 * S, 2 * S + 1), np.nan), *np.empty((4, S)), np.empty((S, 2 * S + 1)))
        motion = Motion(z[None], both[None, S:], frozen)
        step_answer(NODES, self.law, self.impedance, self.h, INTEGRAL, motion, 0, answer)
        return answer.matrix, z, both[S:]


def steps(test):
    for name, values in (("law", STEPPED), ("rate", (0.05, 100.0, 3000.0)), ("coupling", (0.0, 1e-6, 1.0))):
        test = pytest.mark.parametrize(name, values)(test)
    return test


@steps
def test_the_step_solves_friction_and_state(law, rate, coupling):
    step, forced = Step(law, rate, coupling, 1e-3), 1e-4 * RULE.nodes
    wanted = step.by_root_finder(forced)
    for impedance in (step.impedance, Full(step.matrix)):
        used, state, z, v = solved(step.law, impedance, step.h, step.left, step.start, step.incoming, forced)
        assert 0 < used < 12
        np.testing.assert_allclose(state, wanted[:S], atol=1e-11, rtol=0.0)
        np.testing.assert_allclose(z, wanted[S:], atol=1e-10, rtol=0.0)
        np.testing.assert_allclose(v, [rate_of(step.law, one) for one in z], rtol=1e-10)


def test_a_step_without_solution_is_reported():
    used, *_ = solved(slipwave.read("paper").law, Diagonal(1e-5), 1e-4, 0.0, 0.0, np.full(S, np.nan), 0.0)
    assert used == 0


@steps
def test_the_answer_is_the_derivative_of_the_solved_step(law, rate, coupling):
    """In units of v and psi that make all entries of order one: dv/v, dS/a."""
    step = Step(law, rate, coupling)
    units, scale = np.r_[np.full(S, step.law.a), np.ones(S + 1)], np.r_[np.full(S, 1.0 / rate), np.ones(S)][:, None]
    measured = difference(lambda change: step.solve(change * units)[0], 2 * S + 1, 1e-3)
    np.testing.assert_allclose(step.answer()[0] * units * scale, measured * scale, atol=1e-10, rtol=0.0)


@steps
def test_with_psi_held_the_rate_answers_to_stress_alone(law, rate, coupling):
    """dS = (F_z/v_z + K) dv."""
    step = Step(law, rate, coupling)
    answer, z, psi = step.answer(frozen=True)
    slopes = [respond(step.law, *node) for node in zip(z, psi, strict=True)]
    stiffness = np.diag([friction_z / v_z for _, v_z, _, friction_z, *_ in slopes]) + step.matrix
    np.testing.assert_allclose(stiffness @ answer[:S, :S], np.eye(S), atol=1e-13)
    assert not answer[S:].any()
    assert not answer[:S, S:].any()
