"""Random pairs of slabs and drives: the march of the exact system against a plain transcription of its equations, and where its
steps end. The whole study: `python -m tests.reduced.random_networks 500`."""

import numpy as np
import pytest

from reduced.delay.network import DelayNetwork
from slipwave.step.guess import NOT_SMOOTH
from tests.reduced.plain_network import break_points
from tests.reduced.random_networks import ALLOWED, judge, random_network

LIGHT_MASS = 52
"""A step of V behind a light mass, which follows within a small part of a step: 5e-7 off at t = 10 where nobody looked."""


@pytest.mark.parametrize("seed", [*range(24), LIGHT_MASS])
def test_march_agrees_with_the_plain_transcription(seed):
    """Kinds of slab x step, ramp, jump, smooth, at tolerances from 1e-11 to 1e-6."""
    found = judge(seed, until=16.0)
    assert not found.refused
    assert found.ratio <= ALLOWED


@pytest.mark.slow
@pytest.mark.parametrize("first", range(24, 72, 12))
def test_longer_marches_agree_with_the_plain_transcription(first):
    found = [judge(seed) for seed in range(first, first + 12)]
    assert not [one for one in found if not one.ratio <= ALLOWED]


@pytest.mark.parametrize("seed", [0, 3, 5, 9, 12, 14, 16])
def test_every_break_point_is_the_end_of_a_step_after_every_refinement(seed):
    """Every 11 steps they become shorter, by whatever factor is next."""
    scene, tolerance, _ = random_network(seed)
    solver, ends = DelayNetwork(scene, tolerance), []
    while solver.time < 16.0:
        piece = solver.advance(solver.time + 1e-6)
        ends.append(piece.time[-1] + piece.length[-1])
        if len(ends) % 11 == 0 and solver.steps < 200.0:
            solver._refine(NOT_SMOOTH)
    expected = break_points(scene, 16.0)[1:]
    assert expected.size > 10
    assert np.abs(np.array(ends)[np.searchsorted(ends, expected - 1e-9)] - expected).max() < 1e-9
