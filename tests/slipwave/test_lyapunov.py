"""The largest Lyapunov exponent: of maps with a known one, of the delay system and a grid where the kind of motion is known."""

import math

import numpy as np
import pytest

import slipwave
from slipwave.errors import NumericsError, SceneError
from slipwave.observe import Pieces
from slipwave.solve import follow
from slipwave.solve.lyapunov import WHOLE, largest_exponent
from validation.models.build import build


class Logistic:
    """A solver whose only value x becomes r x (1 - x) every two transits; `counts` is no part of the motion."""

    model, failures, failed_at = "logistic", 0, math.nan
    seconds_per_piece, transits_per_piece = 0.0, WHOLE
    nodes, bookkeeping = np.array([0.0, 1.0]), frozenset({"counts"})

    def __init__(self, r, x=0.3):
        self.scene, self.r, self.steps = slipwave.read("paper"), r, 0
        self.now, self.x = np.zeros(1), np.array([x])

    @property
    def time(self):
        return float(self.now[0])

    def advance(self, until):
        one = np.zeros((1, 2))
        pieces = Pieces(self.now.copy(), np.array([WHOLE]), one, one, one, one)
        self.now, self.x, self.steps = self.now + WHOLE, self.r * self.x * (1.0 - self.x), self.steps + 1
        return pieces

    def state(self):
        return {"now": self.now.copy(), "x": self.x.copy(), "counts": np.array([float(self.steps)])}

    def restore(self, state):
        self.now, self.x, self.steps = state["now"].copy(), state["x"].copy(), int(state["counts"][0])

    def energy(self):
        return None


def test_the_exponent_of_an_irregular_map():
    """ln 2 in a step of the map with r = 4."""
    found = largest_exponent(Logistic(4.0), Logistic(4.0), WHOLE)
    assert found.rate == pytest.approx(0.5 * math.log(2.0), abs=1.5 * found.margin)
    assert 1e-4 < found.margin < 0.05
    assert found.transits == 400.0


def test_the_exponent_of_an_orbit_that_attracts():
    """The orbit of period 2 at r = 3.2 has the multiplier 4 + 2 r - r^2 = 0.16."""
    found = largest_exponent(Logistic(3.2), Logistic(3.2), 2.0 * WHOLE)
    assert found.rate == pytest.approx(math.log(0.16) / (2.0 * WHOLE), rel=1e-5)
    assert found.margin < 1e-5


def test_what_stays_has_no_exponent():
    with pytest.raises(NumericsError, match="slides steadily within rounding at t = 4 transits"):
        largest_exponent(Logistic(2.0, 0.5), Logistic(2.0, 0.5), WHOLE)


def test_work_without_end_is_refused_for_its_whole_length():
    """1040 intervals of 200 pieces: of each solver, 1 s a piece."""
    slow = Logistic(4.0), Logistic(4.0)
    slow[0].seconds_per_piece = slow[1].seconds_per_piece = 1.0
    with pytest.raises(SceneError, match=r"model logistic: 416002 transits would take about \d"):
        largest_exponent(*slow, 400.0, intervals=1000, most_seconds=2e5)


def exponent(model, log10_r, cycle, intervals, **options):
    scene = slipwave.read("paper", {"slab.log10_r": log10_r})
    solver, twin = (build(model, scene, **options) for _ in range(2))
    follow(solver, 1000.0)
    found = largest_exponent(solver, twin, cycle, intervals=intervals)
    assert solver.time == twin.time
    assert found.transits == intervals * WHOLE * round(cycle / WHOLE)
    return found


@pytest.mark.parametrize(("model", "options"), [("delay", {}), ("fd", {"cells": 12})])
def test_irregular_motions_part(model, options):
    """At log10 r = -2.5 all exact models have the same attractor; measured: 0.0163 to 0.0172 on five of them."""
    found = exponent(model, -2.5, 94.0, 32, **options)
    assert found.rate == pytest.approx(0.0166, abs=3.0 * found.margin)
    assert found.rate > found.margin > 0.0


def test_motions_on_a_torus_do_not():
    found = exponent("delay", -2.65, 79.3, 48)
    assert abs(found.rate) < 2.0 * found.margin < 8e-3
