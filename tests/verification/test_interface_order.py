"""Every full-wave family reaches its declared order: in T, both drops, v_max and the final state, from the smooth start, and in
the fields against an exact standing wave.

The reference of the former is a pair of elements of another kind on a fine grid, which have to agree: evidence from within the
full wave, blind to faults that all families of the march share, except through the leapfrog. The report and tests/validation hold
the same ladders against the delay system. fem:1 (lumped) and sbp:2 are the same scheme in two words: one witness.
"""

from functools import cache, partial

import numpy as np
import pytest
from exact_waves import standing_error
from order import assert_order

from fullwave.discontinuous import DiscontinuousGalerkin
from fullwave.families import ELEMENTS, GALERKIN
from fullwave.finite_element import FiniteElement
from fullwave.summation_by_parts import SummationByParts
from validation.compute.build import build
from validation.compute.models import explicit_time
from validation.measure.grid_ladders import GENTLE, LADDERS, ROUGH
from validation.measure.orders import QUANTITIES, climb, errors, measure

FINE = {"dg:12": 12, "fem:11": 14}
"""Galerkin and elements of high degree: the first refers the elements and differences, the second refers Galerkin."""


@cache
def fine(model, run):
    return measure(build(model, run.scene, cells=FINE[model]), run)


@pytest.mark.parametrize(("run", "cycles"), [(GENTLE, 10), (ROUGH, 20)], ids=["gentle", "rough"])
def test_the_references_agree_below_the_floor(run, cycles):
    """In as many complete cycles as lie in the last three quarters of the run."""
    apart = errors(fine("dg:12", run), fine("fem:11", run))
    assert max(apart.values()) < run.floor
    assert fine("dg:12", run)["period"].size == fine("fem:11", run)["period"].size == cycles


def explicit(model, scene, **options):
    """Errors of time and space together; the report climbs with the exact march."""
    return build(model, scene, **options, time=explicit_time(model))


QUICK = ("fd", "sbp:2", "sbp:4", "sbp:6", "fem:3", "fem:7", "dg:2", "dg:5", "dg:7")


@pytest.mark.parametrize("model", [pytest.param(m, marks=() if m in QUICK else pytest.mark.slow) for m in LADDERS])
def test_every_output_reaches_the_declared_order(model):
    ladder = LADDERS[model]
    climbed = climb(ladder, fine("fem:11" if model.startswith("dg") else "dg:12", ladder.run), explicit)
    assert climbed.shortfall() == []


@pytest.mark.slow
def test_lumped_linear_elements_are_differences_of_order_two():
    both = [measure(explicit(model, GENTLE.scene, cells=40), GENTLE) for model in ("fem:1", "sbp:2")]
    for name in QUANTITIES:
        assert np.abs(both[0][name] / both[1][name] - 1.0).max() < 1e-9


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


def require_order(kind, number, cells, order, tolerance=0.1, **given):
    """Of the fields of a `kind` of grid; `given` to `assert_order`."""
    errors = [standing_error(partial(kind, number=number, cells=n, time="explicit")) for n in cells]
    assert_order(errors, 1 / np.array(cells), order, tolerance, **given)


@pytest.mark.parametrize("degree", CELLS)
def test_discontinuous_fields_are_of_order_degree_plus_one(degree):
    require_order(DiscontinuousGalerkin, degree, CELLS[degree], GALERKIN.order_bulk(degree), 0.15, absolute=FINEST[degree])


@pytest.mark.parametrize("degree", CELLS)
def test_element_fields_are_of_the_odd_order(degree):
    """degree + 1 for odd degrees, degree for even ones: Galerkin for a first-order pair, measured and declared."""
    require_order(FiniteElement, degree, CELLS[degree], ELEMENTS.order_bulk(degree), absolute=FINEST[degree], at_least=True)


@pytest.mark.parametrize(
    ("order", "cells", "finest"),
    [(2, (48, 64, 96, 128), 2e-2), (4, (64, 96, 128, 192), 1e-5), (6, (64, 96, 128, 192, 256), 1e-8)],
)
def test_difference_fields_are_of_the_order_inside(order, cells, finest):
    require_order(SummationByParts, order, cells, order, absolute=finest, at_least=True)
