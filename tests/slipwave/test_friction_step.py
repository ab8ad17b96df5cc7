"""One collocated friction step: against a general root finder, and its derivative against differences of the solved step."""

import numpy as np
import pytest
from scipy.optimize import root

import slipwave
from slipwave.friction import law_of_step, rate_of, respond, steady_state, to_own, to_step, unknown_of
from slipwave.step.collocation import rule_of
from slipwave.step.impedance import Diagonal, Full
from slipwave.step.nodal import nodal_of
from slipwave.step.solve import solve
from slipwave.step.tangent import Answer, Motion, step_answer
from tests.differences import difference

RULE, COMPILED, NODES = rule_of(5)
S = len(NODES)
INTEGRAL = COMPILED.integral
COUPLED = np.tril(np.random.default_rng(5).uniform(0.2, 1.0, (S, S)))
LAWS = {
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
    used = solve(here, NODES, impedance, h, COMPILED, 1e-13, nodal)
    to_own(here, nodal.z)
    return used, nodal.psi.copy(), nodal.z.copy(), nodal.v.copy()


class Step:
    """A step of a law from near steady sliding at `rate`, under stress that varies within the step by `swing`."""

    def __init__(self, law, rate, coupling, swing=1e-2):
        scene = slipwave.read(*LAWS[law])
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
    for name, values in (("law", LAWS), ("rate", (0.05, 100.0, 3000.0)), ("coupling", (0.0, 1e-6, 1.0))):
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
