"""The leapfrog converges to the delay system at order 2, at every Courant number.

Below cfl 1 this is independent evidence (waves that disperse against exact transport); at cfl 1 both are the same characteristics
with different quadrature, and agreement only says that both were programmed right.
"""

import numpy as np
import pytest

import slipwave
from fullwave.finite_difference import Leapfrog
from reduced.delay.alike import Delay
from slipwave.solve import follow
from validation.measure.order_fit import fit_order, shortfall

UNTIL = 200.0


@pytest.fixture(scope="module")
def exact():
    chosen = slipwave.read("paper", ["slab.log10_r=-2.6"])
    return chosen, follow(Delay(chosen, tolerance=1e-12), UNTIL)


@pytest.mark.parametrize("cfl", [0.5, 0.9, 1.0])
def test_order_two(exact, cfl):
    chosen, limit = exact
    cells = np.array([72, 144, 288, 576])
    finals = [follow(Leapfrog(chosen, int(n), cfl), UNTIL) for n in cells]
    for name in ("ln_v", "psi", "mu"):
        errors = np.array([abs(getattr(final, name) - getattr(limit, name)) for final in finals])
        result = fit_order(cells, errors)
        assert not shortfall(result, 2), name
        assert errors[-1] < 1e-4
        print(f"cfl {cfl} {name}: {result}, finest error {errors[-1]:.1e}")
