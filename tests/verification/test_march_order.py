"""The declared orders of discontinuous Galerkin, finite elements and summation by parts: fields, final state, outputs of a cycle.

Fields are compared with an exact standing wave, the interface outputs with a family of another kind on a fine grid;
they converge up to twice as fast as the fields, so there the declared order is a floor.
"""

from functools import cache

import numpy as np
import pytest
from exact_waves import LOCKED, rate_scene, standing_error
from order import assert_order

import scene
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from scene.observe import EventObserver, follow

STANDING = rate_scene(LOCKED)
CELLS = {
    1: (48, 64, 96, 128, 192),
    2: (32, 48, 64, 96, 128),
    3: (16, 24, 32, 48, 64),
    4: (12, 16, 24, 32, 48),
    5: (8, 12, 16, 24, 32),
    6: (6, 8, 12, 16, 24),
    7: (6, 8, 12, 16, 20),
}
FINEST = {1: 2e-2, 2: 2e-3, 3: 5e-5, 4: 2e-6, 5: 1e-7, 6: 3e-8, 7: 5e-10}


@pytest.mark.parametrize("degree", CELLS)
def test_discontinuous_fields_are_of_order_degree_plus_one(degree):
    errors = [standing_error(DiscontinuousGalerkin(STANDING, degree, cells)) for cells in CELLS[degree]]
    fit = assert_order(errors, 1 / np.array(CELLS[degree]), degree + 1, 0.15, absolute=FINEST[degree])
    print(f"dg:{degree} fields: {fit}")


@pytest.mark.parametrize("mass", ["lumped", "consistent"])
@pytest.mark.parametrize("degree", CELLS)
def test_element_fields_are_of_the_odd_order(degree, mass):
    """degree + 1 for odd degrees, degree for even ones: Galerkin for a first-order pair, measured and declared as order_bulk."""
    solvers = [FiniteElement(STANDING, degree, cells, mass=mass) for cells in CELLS[degree]]
    errors = [standing_error(solver) for solver in solvers]
    cells = 1 / np.array(CELLS[degree])
    fit = assert_order(errors, cells, solvers[0].order_bulk, 0.1, absolute=FINEST[degree], at_least=True)
    print(f"fem:{degree} {mass} fields: {fit}")


@pytest.mark.parametrize(
    ("order", "cells", "finest"),
    [(2, (48, 64, 96, 128), 2e-2), (4, (64, 96, 128, 192), 1e-5), (6, (64, 96, 128, 192, 256), 1e-8)],
)
def test_difference_fields_are_of_the_order_inside(order, cells, finest):
    errors = [standing_error(SummationByParts(STANDING, order, n)) for n in cells]
    print(f"sbp:{order} fields: {assert_order(errors, 1 / np.array(cells), order, 0.1, absolute=finest, at_least=True)}")


# a rough scene for the outputs of a cycle, else rounding is met before the asymptote; a gentle one where no asymptote is met else
ROUGH, GENTLE = (scene.read("paper", [f"slab.log10_r={log10_r}"]) for log10_r in (-2.2, -2.6))
CASES = {
    "dg:1": (DiscontinuousGalerkin, {"degree": 1}, (144, 216, 324, 486)),
    "dg:2": (DiscontinuousGalerkin, {"degree": 2}, (32, 48, 64, 96)),
    "dg:3": (DiscontinuousGalerkin, {"degree": 3}, (16, 24, 32, 48)),
    "dg:4": (DiscontinuousGalerkin, {"degree": 4}, (8, 12, 16, 24)),
    "dg:5": (DiscontinuousGalerkin, {"degree": 5}, (8, 12, 16, 24)),
    "dg:6": (DiscontinuousGalerkin, {"degree": 6}, (4, 6, 8, 12)),
    "dg:7": (DiscontinuousGalerkin, {"degree": 7}, (4, 6, 8, 10)),
    "fem:1": (FiniteElement, {"degree": 1}, (144, 216, 324, 486)),
    "fem:2": (FiniteElement, {"degree": 2}, (48, 64, 96, 128)),
    "fem:3": (FiniteElement, {"degree": 3}, (12, 16, 24, 32)),
    "fem:4": (FiniteElement, {"degree": 4}, (12, 16, 24, 32)),
    "fem:5": (FiniteElement, {"degree": 5}, (8, 12, 16, 24)),
    "fem:6": (FiniteElement, {"degree": 6}, (8, 10, 12, 16)),
    "fem:7": (FiniteElement, {"degree": 7}, (6, 8, 10, 12)),
    "sbp:2": (SummationByParts, {"order": 2}, (144, 216, 324, 486)),
    "sbp:4": (SummationByParts, {"order": 4}, (128, 192, 256, 384)),
    "sbp:6": (SummationByParts, {"order": 6}, (24, 32, 48, 64)),
}
OUTPUTS = ("period", "stress_drop", "elastic_stress_drop", "v_max")
_FLOOR = 3e-10  # relative; below it an output counts as found, and its error is left out of the slope


def run(chosen, kind, until, **options):
    """Final ln v, psi, mu and the first complete cycle's outputs, of the smooth start."""
    solver = kind(chosen, **options)
    events = EventObserver(chosen, solver.nodes)
    final = follow(solver, until, [events])
    assert solver.failures == 0
    cycle = [getattr(events.events, name)[0] for name in OUTPUTS] if events.events.time.size else []
    return np.array([final.ln_v, final.psi, final.mu]), np.array(cycle)


@cache
def reference(chosen, until):
    """Two kinds of elements on fine grids; the test is of no use unless they agree."""
    one, other = (
        run(chosen, DiscontinuousGalerkin, until, degree=12, cells=10),
        run(chosen, FiniteElement, until, degree=11, cells=12),
    )
    assert until > 150.0 or np.abs(one[0] / other[0] - 1).max() < 1e-11
    assert not other[1].size or np.abs(one[1] / other[1] - 1).max() < 1e-11
    return other


def slope_above_floor(cells, errors):
    """Mean order over the levels whose error is above the floor, and the first below it."""
    last = next((k for k, error in enumerate(errors) if error < _FLOOR), len(errors) - 1)
    if last == 0:
        return np.inf
    used = slice(0, last + 1)
    return -np.polyfit(np.log(cells[used]), np.log(errors[used]), 1)[0]


QUICK = ("dg:3", "dg:7", "fem:5", "sbp:4")


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in CASES])
def test_every_output_of_a_cycle_reaches_the_declared_order(name):
    kind, options, cells = CASES[name]
    declared = kind(ROUGH, cells=cells[0], **options).order_interface
    chosen = GENTLE if declared == 2 else ROUGH
    wanted = reference(chosen, 200.0)[1]
    errors = np.array([np.abs(run(chosen, kind, 200.0, cells=n, **options)[1] / wanted - 1) for n in cells])
    for output, column in zip(OUTPUTS, errors.T, strict=True):
        order = slope_above_floor(np.array(cells), column)
        print(f"{name} {output}: order {order:.2f}, errors {[f'{error:.1e}' for error in column]}")
        assert order > declared - 0.4
        assert column[-1] < 1e-3


@pytest.mark.parametrize("name", [name for name in CASES if name[-1] in "123" or name[:3] == "sbp"])
def test_the_final_state_reaches_the_declared_order(name):
    kind, options, cells = CASES[name]
    declared = kind(GENTLE, cells=cells[0], **options).order_interface
    wanted = reference(GENTLE, 100.0)[0]
    errors = np.array([np.abs(run(GENTLE, kind, 100.0, cells=n, **options)[0] - wanted) for n in cells])
    for output, column in zip(("ln_v", "psi", "mu"), errors.T, strict=True):
        print(f"{name} {output}: {[f'{error:.1e}' for error in column]}")
        fit = assert_order(column, 1 / np.array(cells), declared, 0.25, absolute=2e-3, at_least=True, widest=50.0)
        print(f"{name} {output}: {fit}")
