"""A machine at the outer face costs no family its order at the interface: against the delay system, whose own error is 1e-13."""

import dataclasses
from functools import partial

import numpy as np
import pytest
from order import assert_order

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_difference import Leapfrog
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from reduced.delay.system import delay_system
from slipwave.scene.slab import MachineFace
from slipwave.solve import follow

PAPER = slipwave.read("paper")
SLAB = dataclasses.replace(PAPER.upper, face=MachineFace(2.0, 0.5, 0.4))
SCENE = dataclasses.replace(PAPER, upper=SLAB, lower=SLAB)
END = 12.0
FAMILIES = {
    "fd": (partial(Leapfrog, SCENE, cfl=0.9), (32, 64, 128, 256), 2, 5e-8),
    "sbp:2": (partial(SummationByParts, SCENE, 2, time="explicit"), (32, 64, 128, 256), 2, 2e-8),
    "fem:2": (partial(FiniteElement, SCENE, 2, time="explicit"), (8, 12, 16, 24, 32), 4, 3e-12),
    "dg:2": (partial(DiscontinuousGalerkin, SCENE, 2, time="explicit"), (8, 12, 16, 24, 32), 4, 5e-11),
}


@pytest.mark.parametrize("family", FAMILIES)
def test_order_at_the_interface(family):
    """As behind a grip. Finest errors of psi measured: 4e-9, 1.2e-9, 1.3e-13, 2.9e-12."""
    build, cells, order, finest = FAMILIES[family]
    exact = follow(delay_system(SCENE, tolerance=1e-13), END)
    errors = [follow(build(cells=n), END).psi - exact.psi for n in cells]
    print(f"{family}: {assert_order(errors, 1.0 / np.array(cells), order, 0.25, absolute=finest)}")
