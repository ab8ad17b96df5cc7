"""One collocated friction step against a general root finder: diagonal, weakly and strongly coupled impedances."""

import numpy as np
import pytest
from scipy.optimize import root

import slipwave
from slipwave.friction import rate_of, respond, steady_state, unknown_of
from slipwave.step.impedance import Diagonal, Full
from tests.one_step import COUPLED, RULE, S, solved


def by_root_finder(law, matrix, h, psi, z, incoming, forced):
    def defect(unknowns):
        answers = np.array([respond(law, z, p) for z, p in zip(unknowns[S:], unknowns[:S], strict=True)])
        state = unknowns[:S] - psi - forced - h * RULE.integral @ answers[:, 5]
        return np.concatenate([state, answers[:, 2] + matrix @ answers[:, 0] - incoming])

    start = np.concatenate([np.full(S, psi), np.full(S, z)])
    return root(defect, start, method="hybr", tol=1e-14).x


@pytest.mark.parametrize("law", ["paper", "slip-law", "regularised"])
@pytest.mark.parametrize("rate", [0.05, 100.0, 3000.0])
@pytest.mark.parametrize("kind", ["diagonal", "weak", "strong"])
def test_the_step_solves_friction_and_state(law, rate, kind):
    scene = slipwave.read(law)
    size = 0.5 * scene.upper.epsilon
    off = {"diagonal": 0.0, "weak": 1e-6, "strong": 1.0}[kind]
    matrix = size * (np.eye(S) + off * (COUPLED - np.diag(np.diag(COUPLED))))
    psi, start, h = steady_state(scene.law, rate), unknown_of(scene.law, rate), 0.05 * scene.transit
    incoming = respond(scene.law, start, psi)[2] + matrix @ np.full(S, rate) + 1e-3 * np.sin(3.0 * RULE.nodes)
    forced = 1e-4 * RULE.nodes
    impedance = Full(matrix)
    used, state, z, v = solved(scene.law, impedance, h, psi, start, incoming, forced)
    wanted = by_root_finder(scene.law, matrix, h, psi, start, incoming, forced)
    assert 0 < used < 12
    np.testing.assert_allclose(state, wanted[:S], atol=1e-11, rtol=0.0)
    np.testing.assert_allclose(z, wanted[S:], atol=1e-10, rtol=0.0)
    np.testing.assert_allclose(v, [rate_of(scene.law, one) for one in z], rtol=1e-10)
    if kind == "diagonal":
        alone = solved(scene.law, Diagonal(size), h, psi, start, incoming, forced)
        np.testing.assert_allclose(alone[1:], (state, z, v), rtol=1e-12)


def test_a_step_without_solution_is_reported():
    scene = slipwave.read("paper")
    used, *_ = solved(scene.law, Diagonal(1e-5), 1e-4, 0.0, 0.0, np.full(S, np.nan), 0.0)
    assert used == 0
