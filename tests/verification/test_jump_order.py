"""A start that jumps: what the jump costs each family, and that it costs no more later on.

The jump comes back every transit for ever (MODEL.md section 7). A grid smears it over a width of h^(q/(q + 1)), q the order at
which the scheme damps what it cannot resolve (2 P + 1 for upwind elements of degree P), so that just under order 1 is what
there is: 7/8 for dg:3, 15/16 for dg:7; about 0.9 and 0.8 are measured for differences and for continuous elements. The witness
is the delay system, which keeps the jump on its steps.
"""

import dataclasses
from functools import cache, partial

import numpy as np
import pytest
from order import assert_order

import slipwave
from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from reduced.delay.system import delay_system
from slipwave.scene.drive import Start, StartKind
from slipwave.solve import follow
from validation.compute.build import prepare

JUMP = dataclasses.replace(slipwave.read("paper"), start=Start(StartKind.JUMP, 0.05))
EARLY, LATE = np.arange(40.25, 60.0), np.arange(400.25, 420.0)
FAMILIES = {
    "dg:3": (partial(DiscontinuousGalerkin, number=3), (16, 24, 32, 48, 64), 7 / 8),
    "dg:7": (partial(DiscontinuousGalerkin, number=7), (6, 8, 12, 16, 24), 15 / 16),
    "fem:4": (partial(FiniteElement, number=4), (8, 12, 16, 24, 32, 48), 0.8),
    "sbp:6": (partial(SummationByParts, number=6), (32, 48, 64, 96, 128, 192), 0.9),
}


def states(solver, moments):
    """psi at `moments`."""
    return np.array([follow(solver, moment).psi for moment in moments])


@cache
def exact():
    """psi of the delay system, early and late."""
    return np.split(states(delay_system(JUMP, tolerance=1e-11), np.concatenate((EARLY, LATE))), 2)


def error(found, known):
    return float(np.sqrt(np.mean((found - known) ** 2)))


@pytest.mark.parametrize("name", FAMILIES)
def test_a_jump_is_of_order_one_but_for_its_smearing(name):
    kind, cells, declared = FAMILIES[name]
    errors = [error(states(kind(JUMP, cells=n), EARLY), exact()[0]) for n in cells]
    assert_order(errors, 1 / np.array(cells), declared, tolerance=0.1, absolute=3e-8, at_least=True)


@pytest.mark.parametrize("name", FAMILIES)
def test_the_error_of_a_jump_does_not_grow(name):
    kind, cells, _ = FAMILIES[name]
    found = np.split(states(kind(JUMP, cells=cells[2]), np.concatenate((EARLY, LATE))), 2)
    early, late = (error(ours, theirs) for ours, theirs in zip(found, exact(), strict=True))
    assert late < 4.0 * early


STEP = slipwave.read("paper", {"drive.velocity": [[0, 100], [20, 100], [20, 130]]})


@pytest.mark.parametrize(("model", "cells", "order"), [("dg:3", 8, 7 / 8), ("dg:7", 4, 15 / 16), ("fd", 32, 2.0)])
def test_a_step_of_the_drive_lowers_the_order_of_a_grid_as_much_but_that_of_the_leapfrog(model, cells, order):
    """On the paper's stick-slip, where the step falls on the end of a step of every march. Measured: 0.87, 0.92, 2.1."""
    known = states(delay_system(STEP, tolerance=1e-11), EARLY)
    coarse, fine = (error(states(prepare(model, STEP, cells=n).solver, EARLY), known) for n in (cells, 2 * cells))
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.15)
