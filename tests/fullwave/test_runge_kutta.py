"""The Runge-Kutta tables: order conditions, order on a nonlinear problem, stability limits as documented."""

import math

import numpy as np
import pytest

from fullwave.lines.runge_kutta import CLASSICAL, combine_stages, method_of
from fullwave.lines.scheme_limit import longest_decay_step, longest_step

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
