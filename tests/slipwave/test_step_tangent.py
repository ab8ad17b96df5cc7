"""The derivative of a collocation step against differences of the solved step."""

import numpy as np
import pytest

import slipwave
from slipwave.friction import rate_of, respond, steady_state, unknown_of
from slipwave.step.impedance import Diagonal, Full
from slipwave.step.tangent import Answer, Motion, step_answer
from tests.one_step import COUPLED, NODES, RULE, S, solved

INTEGRAL = RULE.integral.T.copy()
LAWS = {
    "ageing": ("paper", []),
    "slip": ("slip-law", []),
    "ageing-regularised": ("regularised", []),
    "slip-regularised": ("regularised", ["interface.law='slip-regularised'"]),
}


class Step:
    """A step of a law from near steady sliding at `rate`, under stress that varies within the step."""

    def __init__(self, law, rate, impedance):
        scene = slipwave.read(*LAWS[law])
        size = 0.5 * scene.upper.epsilon
        self.law, self.h = scene.law, 0.05 * scene.transit
        self.matrix = size * (np.eye(S) + (COUPLED - np.diag(np.diag(COUPLED)) if impedance == "full" else 0.0))
        full = Full(self.matrix)
        self.impedance = full if impedance == "full" else Diagonal(size)
        self.left, self.start = steady_state(self.law, rate), unknown_of(self.law, rate)
        friction = respond(self.law, self.start, self.left)[2]
        self.incoming = friction + self.matrix @ np.full(S, rate) + 1e-2 * np.sin(3.0 * RULE.nodes)

    def solve(self, change, law=None, h=None):
        """v and psi at the nodes for changes of S at the nodes, of psi at the start and of h G at the nodes."""
        stress, left, rate = np.split(np.asarray(change), [S, S + 1])
        forced, law = RULE.integral @ rate, law or self.law
        solution = solved(law, self.impedance, h or self.h, self.left + left[0], self.start, self.incoming + stress, forced)
        used, psi, z, _ = solution
        assert used > 0
        return np.concatenate([[rate_of(law, one) for one in z], psi]), z

    def answer(self, frozen=False):
        """The derivative, z and psi at the nodes."""
        both, z = self.solve(np.zeros(2 * S + 1))
        answer = Answer(np.full((2 * S, 2 * S + 1), np.nan), *np.empty((4, S)), np.empty((S, 2 * S + 1)))
        motion = Motion(z[None], both[None, S:], frozen)
        step_answer(NODES, self.law, self.impedance, self.h, INTEGRAL, motion, 0, answer)
        return answer.matrix, z, both[S:]


def difference(function, size):
    """Derivative at 0 by central differences of fourth order."""
    near, far = (function(k * size) - function(-k * size) for k in (1.0, 2.0))
    return (8.0 * near - far) / (12.0 * size)


def steps(test):
    for name, values in (("law", LAWS), ("rate", (0.05, 100.0, 3000.0)), ("impedance", ("diagonal", "full"))):
        test = pytest.mark.parametrize(name, values)(test)
    return test


@steps
def test_the_answer_is_the_derivative_of_the_solved_step(law, rate, impedance):
    """In units of v and psi that make all entries of order one: dv/v, dS/a."""
    step = Step(law, rate, impedance)
    answer, _, _ = step.answer()
    units = np.r_[np.full(S, step.law.a), np.ones(S + 1)]
    measured = [difference(lambda d, k=k: step.solve(d * units * (np.arange(2 * S + 1) == k))[0], 1e-3) for k in range(2 * S + 1)]
    scale = np.r_[np.full(S, 1.0 / rate), np.ones(S)][:, None]
    np.testing.assert_allclose(answer * units * scale, np.array(measured).T * scale, atol=1e-10, rtol=0.0)


@steps
def test_with_psi_held_the_rate_answers_to_stress_alone(law, rate, impedance):
    """dS = (F_z/v_z + K) dv."""
    step = Step(law, rate, impedance)
    answer, z, psi = step.answer(frozen=True)
    slopes = [respond(step.law, *node) for node in zip(z, psi, strict=True)]
    stiffness = np.diag([friction_z / v_z for _, v_z, _, friction_z, *_ in slopes]) + step.matrix
    np.testing.assert_allclose(stiffness @ answer[:S, :S], np.eye(S), atol=1e-13)
    assert not answer[S:].any()
    assert not answer[:S, S:].any()
