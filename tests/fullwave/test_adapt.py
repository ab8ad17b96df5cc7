"""Grids chosen from a tolerance: the estimate bounds the true error, refusals are clear."""

import dataclasses

import numpy as np
import pytest
from grid_scenes import SCENES

from fullwave.adapt import to_tolerance
from fullwave.discontinuous import DiscontinuousGalerkin
from slipwave.errors import NumericsError
from slipwave.observe import EventObserver
from slipwave.scene.drive import Start, StartKind
from slipwave.solve import follow


def cycles(solver, until=400.0):
    observer = EventObserver(solver.scene, solver.nodes)
    follow(solver, until, [observer])
    return np.concatenate((observer.events().period, observer.events().stress_drop))


@pytest.mark.parametrize("name", ["alike", "unlike", "grip"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_estimate_bounds_the_error_in_period_and_drop(name, tolerance):
    chosen = SCENES[name]
    solver, choice = to_tolerance(chosen, tolerance)
    assert solver.time == 0.0
    assert choice.quantity == "cycles"
    assert choice.error_estimate <= tolerance
    exact = cycles(DiscontinuousGalerkin(chosen, number=11, cells=8))
    error = np.abs(cycles(solver) / exact - 1).max()
    assert error < max(2.0 * choice.error_estimate, 1e-11)


@pytest.mark.parametrize("name", ["alike", "unlike", "grip"])
def test_the_estimate_bounds_the_error_of_a_grid_marched_explicitly(name):
    """Nothing is added for its steps: the estimate is the difference of two grids."""
    solver, choice = to_tolerance(SCENES[name], 1e-5, time="explicit", number=4)
    exact = cycles(DiscontinuousGalerkin(SCENES[name], number=11, cells=8))
    error = np.abs(cycles(solver) / exact - 1).max()
    assert 0.01 * choice.error_estimate < error < choice.error_estimate  # 0.035 to 0.12 of it were measured


def test_the_estimate_counts_the_error_of_the_steps_which_no_grid_shows():
    """Of grids with an error of 1e-8. Measured: 4e-5, the same on both grids."""
    solver, choice = to_tolerance(SCENES["alike"], 1e-2, number=12)
    assert solver.settings["resolution"] == pytest.approx(2e-4)
    assert choice.error_estimate == pytest.approx(2e-3, rel=1e-2)
    exact = cycles(DiscontinuousGalerkin(SCENES["alike"], number=11, cells=8))
    assert 1e-6 < np.abs(cycles(solver) / exact - 1.0).max() < choice.error_estimate


def test_a_grid_too_large_for_the_march_ends_the_search_with_what_was_reached(monkeypatch):
    monkeypatch.setattr("fullwave.lines.budget.MOST_UNKNOWNS", 200)
    jump = dataclasses.replace(SCENES["alike"], start=Start(StartKind.JUMP, 0.5), until=60.0)
    with pytest.raises(
        NumericsError, match=r"not reached with 8 cells: .*; cells = 12: \d+ unknowns, more than the 200 .* explicit"
    ):
        to_tolerance(jump, 1e-11, time="exact")


def test_a_jump_is_given_up_as_soon_as_its_trend_is_seen():
    """Order 1: a factor of 1e6 in the error would take a million times the cells, so few are tried."""
    jump = dataclasses.replace(SCENES["alike"], start=Start(StartKind.JUMP, 0.5), until=60.0)
    with pytest.raises(NumericsError, match=r"by its trend it needs about [\d,]+ cells, but at most 400 are tried") as refusal:
        to_tolerance(jump, 1e-11)
    assert int(str(refusal.value).split(" cells:")[0].split()[-1]) < 60


@pytest.mark.parametrize(("credited", "cells", "estimate"), [(np.inf, 8, 1e-4), (6.0, 8, 0.04 / 1.5**6), (2.0, 18, 2.733e-3)])
def test_a_difference_that_is_small_by_chance_proves_nothing(monkeypatch, credited, cells, estimate):
    """No refinement of order 2 gains a factor of 400; at order 2 the estimate is half as much again."""
    values = {2: 1.124, 3: 1.044, 5: 1.004, 8: 1.0041, 12: 1.0, 18: 1.0}

    class Series:
        model, step, settings, transits_per_piece = "series", 1.0, {}, 4.0

        def __init__(self, scene, cells):
            self.cells = cells

    monkeypatch.setattr("fullwave.adapt.probe", lambda solver: ("cycles", np.array([values[solver.cells]])))
    _, choice = to_tolerance(SCENES["alike"], 7e-3, Series, credited)
    assert (choice.cells, choice.error_estimate) == (cells, pytest.approx(estimate, rel=2e-2))
