"""The leapfrog converges to the delay system at every Courant number: at order 2, and at order 1 after a start that jumps.

Below cfl 1 this is independent evidence (waves that disperse against exact transport); at cfl 1 both are the same characteristics
with different quadrature, and agreement only says that both were programmed right. The jump comes back every transit (MODEL.md
section 7): order 1 is what there is.
"""

from functools import cache

import numpy as np
import pytest

import slipwave
from fullwave.finite_difference import Leapfrog
from reduced.delay.alike import Delay
from slipwave.solve import follow
from validation.measure.order_fit import fit_order, shortfall

STARTS = {
    "smooth": (["slab.log10_r=-2.6"], 200.0, (72, 144, 288, 576), 2, 1e-4),
    "jump": (["start.kind=jump", "start.size=0.05"], 60.0, (45, 90, 180, 360), 1, 1e-5),
}


@cache
def exact(name):
    settings, until, *_ = STARTS[name]
    chosen = slipwave.read("paper", settings)
    return chosen, follow(Delay(chosen, tolerance=1e-12), until)


@pytest.mark.parametrize("cfl", [0.5, 0.9, 1.0])
@pytest.mark.parametrize("name", STARTS)
def test_order(name, cfl):
    _, until, cells, order, finest = STARTS[name]
    chosen, limit = exact(name)
    finals = [follow(Leapfrog(chosen, n, cfl), until) for n in cells]
    for quantity in ("ln_v", "psi", "mu") if name == "smooth" else ("psi",):
        errors = np.array([abs(getattr(final, quantity) - getattr(limit, quantity)) for final in finals])
        result = fit_order(np.array(cells), errors)
        print(f"{name} cfl {cfl} {quantity}: {result}, finest error {errors[-1]:.1e}")
        assert not shortfall(result, order, 0.1 if name == "smooth" else 0.2), quantity
        assert errors[-1] < finest
