"""Every full-wave family reaches its declared order in T, both drops, v_max and the final state, from the smooth start.

The reference is a pair of elements of another kind on a fine grid, which have to agree: evidence from within the full wave, blind
to faults that all families of the march share, except through the leapfrog. The report and tests/validation hold the same ladders
against the delay system. fem:1 (lumped) and sbp:2 are the same scheme in two words: one witness.
"""

from functools import cache

import numpy as np
import pytest

from validation.compute.build import build
from validation.compute.models import explicit_time
from validation.measure.grid_ladders import GENTLE, LADDERS, ROUGH
from validation.measure.orders import QUANTITIES, climb, errors, measure

FINE = {"dg:12": 12, "fem:11": 14}
"""Galerkin and elements of high degree: the first refers the elements and differences, the second refers Galerkin."""


@cache
def fine(model, course):
    return measure(build(model, course.scene, cells=FINE[model]), course)


@pytest.mark.parametrize(("course", "cycles"), [(GENTLE, 10), (ROUGH, 20)], ids=["gentle", "rough"])
def test_the_references_agree_below_the_floor(course, cycles):
    """In as many complete cycles as lie in the last three quarters of the course."""
    apart = errors(fine("dg:12", course), fine("fem:11", course))
    assert max(apart.values()) < course.floor
    assert fine("dg:12", course)["period"].size == fine("fem:11", course)["period"].size == cycles


def explicit(model, scene, **options):
    """Errors of time and space together; the report climbs with the exact march."""
    return build(model, scene, **options, time=explicit_time(model))


QUICK = ("fd", "sbp:2", "sbp:4", "sbp:6", "fem:3", "fem:7", "dg:2", "dg:5", "dg:7")


@pytest.mark.parametrize("model", [pytest.param(m, marks=() if m in QUICK else pytest.mark.slow) for m in LADDERS])
def test_every_output_reaches_the_declared_order(model):
    ladder = LADDERS[model]
    climbed = climb(ladder, fine("fem:11" if model.startswith("dg") else "dg:12", ladder.course), explicit)
    assert climbed.shortfall() == []


@pytest.mark.slow
def test_lumped_linear_elements_are_differences_of_order_two():
    both = [measure(explicit(model, GENTLE.scene, cells=40), GENTLE) for model in ("fem:1", "sbp:2")]
    for name in QUANTITIES:
        assert np.abs(both[0][name] / both[1][name] - 1.0).max() < 1e-9
