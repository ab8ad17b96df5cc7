"""Stated errors hold the truth: the script that measures how often, and a small part of its measurement."""

from itertools import islice

import numpy as np
import pytest

from validation import error_bars
from validation.error_bars import Held, of_orbits, of_runs, random_scene, rows


def test_a_table_of_what_was_held():
    cases = [[Held("period", 2e-9, 1e-9), Held("drop", 1e-9, 4e-9)], [], [Held("period", 8e-9, 1e-9)]]
    assert list(rows(cases)) == [
        ["drop", "1", "0.000", "0.000 .. 0.793", "0.2"],
        ["period", "2", "1.000", "0.342 .. 1.000", "5.0"],
    ]


@pytest.mark.parametrize("kind", error_bars.SLABS)
def test_a_random_scene_is_of_its_kind_and_beyond_the_loss_of_stability(kind):
    scene = random_scene(kind, "sbp:6" if kind == "viscous" else "delay", np.random.default_rng(1))
    assert scene.alike is (kind != "unlike")
    assert scene.upper.is_plain is (kind in ("alike", "unlike"))
    critical, _ = error_bars.critical_round_trip(scene, "delay")
    assert 1.009 < scene.transit / critical < 1.251


def held(cases, count):
    """The least share that is held of any kind of figure, and the largest median of bar over error."""
    table = list(rows(islice(cases, count)))
    return min(float(row[2]) for row in table), max(float(row[4]) for row in table)


@pytest.mark.parametrize("model", ["kelvin-voigt", "block8"])
def test_errors_of_orbits_hold_the_truth(model):
    share, _ = held(of_orbits("alike", model, np.random.default_rng(6)), 3)
    assert share == 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "model"),
    [("machine", "delay"), ("unlike", "modal:1")],
)
def test_errors_of_many_orbits_hold_the_truth(kind, model):
    share, median = held(of_orbits(kind, model, np.random.default_rng(8)), 12)
    assert share > 0.9
    assert median < 150.0


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "model", "tolerance"), [("unlike", "fd", 1e-3), ("layered", "fd", 1e-3)])
def test_estimates_of_grids_hold_the_truth(kind, model, tolerance):
    share, median = held(of_runs(kind, model, np.random.default_rng(7), tolerance), 20)
    assert share > 0.9
    assert 1.0 < median < 100.0
