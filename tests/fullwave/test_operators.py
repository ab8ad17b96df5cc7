"""Each family's operator: accuracy, summation by parts; orders and stability limits of the Runge-Kutta tables."""

import math

import numpy as np
import pytest

from fullwave.finite_element import _assemble_layer
from fullwave.lines.runge_kutta import CLASSICAL, combine_stages, method_of
from fullwave.lines.scheme_limit import longest_decay_step, longest_step
from fullwave.summation_by_parts import SummationByParts, _boundary_closure
from slipwave import read


@pytest.mark.parametrize("order", [2, 4, 6])
def test_differences_are_exact_to_their_order(order):
    """x^k for k < order everywhere (order 2: k <= 1), for k <= order inside."""
    matrix, _ = SummationByParts(read("paper"), order, cells=24).line_of(24)
    x = np.linspace(0.0, 1.0, 25)
    rows = _boundary_closure(order)[0].shape[0]
    for k in range(order + 1):
        error = np.abs(matrix @ x**k - k * x ** max(k - 1, 0))
        assert error[rows:-rows].max() < 1e-11
        if k < order:
            assert error.max() < 2e-11
        else:
            assert error.max() > 1e-6  # the ends are one order lower


@pytest.mark.parametrize("order", [2, 4, 6])
def test_differences_sum_by_parts(order):
    solver = SummationByParts(read("paper"), order, cells=30)
    matrix, _ = solver.line_of(30)
    norm = solver.grid.blocks[0].norm / solver.sections[0].length
    q = norm @ matrix
    ends = np.zeros_like(q)
    ends[0, 0], ends[-1, -1] = -1.0, 1.0
    np.testing.assert_allclose(q + q.T, ends, atol=1e-11)
    dense = norm.toarray()
    np.testing.assert_array_equal(dense, dense.T)
    assert np.linalg.eigvalsh(dense).min() > 0.0
    assert dense.sum() == pytest.approx(1.0, rel=1e-12)
    assert not dense[0, 1:].any()  # a penalty acts on the end node alone


@pytest.mark.parametrize(("order", "first"), [(4, 2839 / 13230), (6, 1581317 / 11215260)])
def test_free_entries_of_the_norm_are_those_of_least_residual(order, first):
    """The first one, as rational arithmetic gives it."""
    assert _boundary_closure(order)[0][0, 0] == pytest.approx(first, abs=1e-10)


@pytest.mark.parametrize("degree", [1, 2, 3, 7, 12])
def test_elements_sum_by_parts(degree):
    depth, mass, slope = _assemble_layer(3, degree)
    assert (np.diff(depth) > 0.0).all()
    ends = np.zeros(slope.shape)
    ends[0, 0], ends[-1, -1] = -1.0, 1.0
    np.testing.assert_allclose((slope + slope.T).toarray(), ends, atol=1e-12)
    derivative = slope.toarray() / mass[:, None]
    for k in range(degree):
        np.testing.assert_allclose(derivative @ depth**k, k * depth ** max(k - 1, 0), atol=1e-9)


METHODS = pytest.mark.parametrize("method", [CLASSICAL, method_of(8)], ids=["order 4", "order 8"])


def integrate(method, steps, until=2.0):
    """u' = -u^2 cos(3t) (with u beside it, padded to eight), u(0) = 1, by the compiled sums."""
    step = until / steps
    state, trial, rates = np.zeros(8), np.zeros(8), np.zeros(8 * method.stages)
    state[0] = 1.0
    weight = step * method.weight
    for n in range(steps):
        for stage in range(method.stages):
            combine_stages(weight, method.stages, stage, state, rates, trial)
            rates[8 * stage] = -(trial[0] ** 2) * math.cos(3.0 * (n + method.abscissae[stage]) * step)
        combine_stages(weight, method.stages, method.stages, state, rates, state)
    return state[0]


@METHODS
def test_order_on_a_nonlinear_problem(method):
    exact = 1.0 / (1.0 + math.sin(6.0) / 3.0)
    errors = [abs(integrate(method, steps) - exact) for steps in (8, 16)]
    assert math.log2(errors[0] / errors[1]) > method.order - 0.7
    assert abs(integrate(method, 64) - exact) < (1e-12 if method.order == 8 else 1e-6)


def test_stability_limits_as_documented():
    imaginary, real = np.array([1.0j]), -1.0
    assert longest_step(imaginary, CLASSICAL) == pytest.approx(2.0 * math.sqrt(2.0), rel=1e-5)
    assert longest_step(imaginary, method_of(8)) == pytest.approx(5.961, abs=2e-3)
    assert longest_decay_step(-real, CLASSICAL) == pytest.approx(2.785, abs=1e-3)
    assert longest_decay_step(-real, method_of(8)) == pytest.approx(6.39, abs=1e-2)
